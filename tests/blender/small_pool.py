"""The least scene that can be baked, and a solver whose answer is known: what the tests of the pipeline share."""

import json
import sys
import types
from dataclasses import replace

import bpy
import numpy as np

import dapple.kernels
from dapple.kernels.anchor import Anchor
from dapple.kernels.scene import Diagnostics, Solution
from dapple.operators.bake import bake
from dapple.operators.bake.solver import Solver


def add_grid(name, z, collection=None, n=4):
    """n x n quads over 2 x 2 m at height z, with UVs over the unit square; returns the object."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=n, y_subdivisions=n, size=2.0, location=(0, 0, z))
    grid = bpy.context.object
    grid.name = grid.data.name = name
    grid.data.polygons.foreach_set("use_smooth", [True] * len(grid.data.polygons))
    grid.data.update()
    if collection:
        bpy.context.scene.collection.objects.unlink(grid)
        collection.objects.link(grid)
    return grid


def build_pool(scene, out):
    """Water that rises from z = 1 by 0.1 m a frame, a floor at z = 0, a sun straight above; settings that bake it."""
    water = add_grid("Water", 1.0)
    water.driver_add("location", 2).driver.expression = "1 + (frame - 1) / 10"
    receivers = bpy.data.collections.new("Receivers")
    scene.collection.children.link(receivers)
    add_grid("Floor", 0.0, receivers)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy = 1.0
    scene.collection.objects.link(bpy.data.objects.new("Sun", sun))
    scene.frame_end = 3
    scene.dapple.water, scene.dapple.receivers = water, receivers
    scene.dapple.resolution, scene.dapple.output = 16, str(out)


def solve_by_height(scene, texels, settings, kept=None):
    """A Solution whose irradiance is the mean height of the water."""
    height = scene.water.positions[:, 2].mean()
    images = tuple(one.image(np.full((len(one.texel), 3), height)) for one in texels)
    diagnostics = Diagnostics("by_height", "a test asked for it", {"think": 0.25}, np.full(3, 4.0))
    diagnostics.flux_received = {receiver.name: np.full(3, 3.0) for receiver in scene.receivers}
    diagnostics.flux_lost = {"rim": np.full(3, 1.0)}
    return Solution(images, tuple(np.ones(image.shape[:2], np.uint8) for image in images), diagnostics)


class InlinePool:
    """A Pool without processes, for tests whose solver is their own: it solves when it is given a job."""

    def __init__(self, most):
        self.most, self._solver, self._said, self.busy = most, Solver(), [], []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    @property
    def has_room(self):
        return not self.busy

    def give(self, job):
        self.busy.append(job)
        self._said += [(job, answer) for answer in self._solver.answers(job)]

    def answers(self, _seconds=None):
        said, self._said, self.busy = self._said, [], []
        return said


HALF = 2.0**-11  # relative: how far half floats may be off


def use_solver(monkeypatch, solve):
    """Let `solve` answer in the place of the kernels, in this process."""
    monkeypatch.setattr(bake, "Pool", InlinePool)
    fake = types.ModuleType("dapple.kernels.methods")
    fake.prepare = lambda *_: Anchor()
    fake.METHODS, fake.solve = {"photon_splat": None, "conic_walk": None}, solve
    monkeypatch.setitem(sys.modules, fake.__name__, fake)
    monkeypatch.setattr(dapple.kernels, "methods", fake, raising=False)


def run(scene, **changes):
    """Bake what the scene says, with changes to the request; returns its steps."""
    return list(bake.bake(bpy.context, replace(bake.request_from_scene(scene), **changes)))


def record(out):
    """What bake.json in a folder holds."""
    return json.loads((out / "bake.json").read_text())


def content(out):
    """{name: bytes} of every file under a folder."""
    return {name: (out / name).read_bytes() for name in files_in(out)}


def files_in(folder):
    """Every file under a folder, hidden ones too, relative to it."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
