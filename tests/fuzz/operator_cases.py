"""Blender files with odd names, paths, meshes and UVs, and words of the command line: baked, or told why not."""

import contextlib
import io
import tempfile
from pathlib import Path

import bpy
import numpy as np
from hypothesis import strategies as st

from dapple.kernels.maps.texels import UVError, rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings
from dapple.operators import cli
from dapple.operators.errors import DappleError
from dapple.operators.maps.exr_file import is_whole
from dapple.operators.maps.write import map_path, write_exr
from dapple.operators.read.extract import read_scene
from dapple.operators.read.mesh_arrays import TopologyCache
from dapple.tests.blender.small_pool import add_grid
from dapple.tests.fuzz.kernel_cases import NUMBERS, rarely

ODD = (
    "",
    " ",
    ".",
    "..",
    "a/b",
    "a\\b",
    "CON",
    "nul.txt",
    "<x>",
    "é",
    "水",
    "🌊",
    "a" * 60,
    "x\n",
    "-o",
    "{}",
    "%s",
    "//",
)
NAMES = st.one_of(st.sampled_from(ODD), st.text(max_size=12), st.just("Floor"))
WORDS = st.one_of(
    st.sampled_from(
        ("bake", "--frames", "1-3", "3-1", "1,2", "--method", "auto", "ice", "--tolerance", "nan", "-1", "1e-9")
    ),
    st.sampled_from(
        ("--resolution", "0", "99999999", "--water", "--receivers", "--out", "--bounces", "--reuse", "--help")
    ),
    NAMES,
)


@st.composite
def cases(draw):
    """What is odd about a file: names, spoils of both meshes' vertices and of the UVs, a folder, words."""
    spoil = st.lists(st.tuples(st.integers(0, 24), st.integers(0, 2), NUMBERS), min_size=1, max_size=2)
    return {
        "water": draw(NAMES),
        "floor": draw(NAMES),
        "heights": draw(rarely([], spoil, of=7)),
        "bed": draw(rarely([], spoil, of=7)),
        "uvs": draw(rarely([], spoil, of=7)),
        "scale": [draw(rarely(1.0, of=20)) for _ in range(3)],
        "energy": draw(rarely(1.0, of=12)),
        "folder": draw(NAMES),
        "frame": draw(rarely(1, st.integers(0, 10**9))),
        "words": draw(st.lists(WORDS, max_size=5)),
    }


def run(case):
    """What becomes of a case: "answered" or a sentence; raises for all that is neither."""
    _read_words(case["words"])
    water, floor = _build(case)
    with tempfile.TemporaryDirectory() as folder:
        try:
            path = _bake(water.name, floor.name, case, Path(folder))
        except (DappleError, UVError) as error:
            assert len(str(error).split()) >= 4, f"no sentence: {error}"
            return str(error)
        except ValueError as error:
            assert " must " in str(error), f"no sentence: {error}"
            return str(error)
        assert is_whole(path)
        assert Path(folder).resolve() in path.resolve().parents, f"{path} is outside the folder"
    return "answered"


def _read_words(words):
    """The command line takes the words or leaves with a message, never anything else."""
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        try:
            cli._parser(()).parse_args(words)
        except SystemExit as leaving:
            assert leaving.code in (0, 2)


def _build(case):
    """Water and floor of a new scene with what is odd about them."""
    for things in (bpy.data.objects, bpy.data.meshes, bpy.data.lights):
        for thing in [*things]:
            things.remove(thing)
    water, floor = add_grid("Water", 1.0), add_grid("Floor", 0.0)
    water.name, floor.name = case["water"], case["floor"]
    for obj, spoils in ((water, case["heights"]), (floor, case["bed"])):
        for vertex, axis, value in spoils:
            obj.data.vertices[vertex].co[axis] = _single(value)
    for corner, axis, value in case["uvs"]:
        floor.data.uv_layers[0].uv[corner].vector[axis % 2] = _single(value)
    floor.scale = [_single(value) for value in case["scale"]]
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy = _single(case["energy"])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Sun", sun))
    for obj in (water, floor):
        obj.data.update()
    return water, floor


def _single(value):
    """A number as Blender takes it: float32, beyond whose range lies infinity."""
    with np.errstate(over="ignore"):
        return float(np.float32(value))


def _bake(water, floor, case, folder):
    """Read the scene, solve and write one map; returns its path."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    scene, _ = read_scene(depsgraph, (water,), (floor,), TopologyCache())
    settings = Settings(tolerance=0.1, resolution=8)
    texels = tuple(rasterise(receiver, 8) for receiver in scene.receivers)
    with np.errstate(all="ignore"):
        image = solve(scene, texels, settings).images[0]
    path = map_path(folder / "maps", floor, case["frame"])
    write_exr(path, image)
    return path
