"""What frames of an animated scene with glass cost, with what is kept of the frame before and without.

Run as `.venv/bin/python tests/bench/bench_animated.py`; it pins itself to one core and prints the tables of
docs/glass_and_metal.md. For the first two changes glass.blend gets a second lamp; frames with a Kept and without
alternate.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from dataclasses import replace

from bench_stages import Table, load_dapple

RESOLUTION, FRAMES = 256, 3
_POINTS = 60_000  # of the sun's, that are followed to see what they meet
_STEP, _TURN = 0.02, 0.05  # from frame to frame: m, rad


def scenes():
    """The frames (a list of Scene) of each change, by its name."""
    import numpy as np
    from bench.sample_scenes import read

    from dapple.kernels.scene import Point

    glass, room = read("glass", 1), read("mirror_room", 1)
    sun, lamp = glass.lights[0], Point("Lamp", np.array([-0.5, 0.4, 1.0]), np.full(3, 0.5))
    both = replace(glass, lights=(sun, lamp))
    return {
        "the lamp moves": [replace(both, lights=(sun, _moved(lamp, k))) for k in range(FRAMES)],
        "the sun fades": [replace(both, lights=(_dimmed(sun, k), lamp)) for k in range(FRAMES)],
        "the ring moves": [_with(glass, "Ring", _shifted, k) for k in range(FRAMES)],
        "the ball moves": [_with(glass, "Ball", _shifted, k) for k in range(FRAMES)],
        "the diamond turns": [read("glass", 1 + k) for k in range(FRAMES)],
        "Suzanne turns": [_with(glass, "Suzanne", _turned, k) for k in range(FRAMES)],
        "the star turns, in mirror_room.blend": [_with(room, "Star", _turned, k) for k in range(FRAMES)],
        "lamp and star move, in mirror_room.blend": [read("mirror_room", 1 + k) for k in range(FRAMES)],
        "the water moves, a glass ball stands on the rim of pool.blend": _beside_water(),
    }


def _beside_water():
    """Frames of pool.blend with a ball of glass on its rim."""
    from bench.sample_scenes import read
    from casters import ball

    still = ball(0.12, (2.1, 0.3, 1.88), fine=64)
    return [replace(read("pool", 1 + k), casters=(still,)) for k in range(FRAMES)]


def _with(scene, name, change, k):
    return replace(scene, casters=tuple(change(c, k) if c.name == name else c for c in scene.casters))


def _shifted(caster, k):
    import numpy as np

    return replace(caster, positions=caster.positions + np.array([_STEP * k, 0, 0]))


def _turned(caster, k):
    import numpy as np

    c, s = np.cos(_TURN * k), np.sin(_TURN * k)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    middle = (caster.positions.min(0) + caster.positions.max(0)) / 2
    return replace(caster, positions=(caster.positions - middle) @ turn + middle, normals=caster.normals @ turn)


def _moved(lamp, k):
    return replace(lamp, position=lamp.position + _STEP * k)


def _dimmed(sun, k):
    return replace(sun, irradiance=sun.irradiance * 0.9**k)


def measured(frames):
    """Of the frames after the first the median CPU seconds, alone and with what is kept, and the share of rays that
    are cast with it; that the light is the same is checked."""
    from dapple.kernels.anchor import Anchor, Kept
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Settings

    texels = tuple(rasterise(receiver, RESOLUTION) for receiver in frames[0].receivers)
    settings, kept = Settings("photon_splat", resolution=RESOLUTION), Kept(Anchor())
    spent, rays, images = ([], []), ([], []), [[], []]
    for frame in frames:
        for k, own in enumerate((None, kept)):
            with Counted() as counted:
                start = time.process_time()
                images[k] = solve(frame, texels, settings, own).images
                spent[k].append(time.process_time() - start)
            rays[k].append(counted.rays())
        same = all((a == b).all() for a, b in zip(*images, strict=True))
        assert same, "the light is not the same"
    return *(statistics.median(times[1:]) for times in spent), sum(rays[1][1:]) / max(sum(rays[0][1:]), 1)


class Counted:
    """Counts the rays that are cast over casters while it is entered."""

    def __enter__(self):
        from dapple.kernels.trace.follow import Follower

        self._class, self._made, self._followers = Follower, Follower.__init__, []

        def make(follower, *given):
            self._made(follower, *given)
            self._followers.append(follower)

        Follower.__init__ = make
        return self

    def __exit__(self, *_):
        self._class.__init__ = self._made

    def rays(self):
        return sum(follower.cast for follower in self._followers)


class Seen:
    """In place of `Surfaces.first` of a Scene: which casters the branches of each point meet, from the first on."""

    def __init__(self, scene, surfaces):
        import numpy as np

        self._first, self._solid = surfaces.first, surfaces.solid
        self._ends = surfaces.solid + np.cumsum([len(caster.triangles) for caster in scene.casters])
        self.blocks = []  # pairs: the first caster of each point, or -1; which ones (points, casters) it meets

    def __call__(self, rays):
        import numpy as np

        end = self._first(rays)
        at = np.flatnonzero(end >= self._solid)
        own, photon = np.searchsorted(self._ends, end[at], "right"), rays.photon[at]
        if not rays.cast.any():
            self.blocks.append((np.full(len(end), -1), np.zeros((len(end), len(self._ends)), bool)))
            self.blocks[-1][0][photon] = own
        self.blocks[-1][1][photon, own] = True
        return end


def meetings(scene):
    """Shares (casters, casters) of the points on each caster of which some branch meets each of them."""
    import numpy as np

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Settings
    from dapple.kernels.trace.cast import over_casters

    texels = tuple(rasterise(receiver, RESOLUTION) for receiver in scene.receivers)
    cast = over_casters(scene, texels, Settings(resolution=RESOLUTION))[0]
    cast.surfaces.first = seen = Seen(scene, cast.surfaces)
    cast.throw(_POINTS, np.random.default_rng(1))
    first, met = (np.concatenate(parts) for parts in zip(*seen.blocks, strict=True))
    return np.stack([met[first == k].mean(0) for k in range(len(scene.casters))])


def main():
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple(register=False)
    table, frames = Table(), scenes()
    first = frames["the diamond turns"][0]
    names = [caster.name for caster in first.casters]
    table.head("of the points on", *(f"meet {name}" for name in names))
    for name, shares in zip(names, meetings(first), strict=True):
        table.add(name, *(f"{share:.1%}" for share in shares))
    table.head("what changes", "CPU of a frame [s]", "with what is kept [s]", "ratio", "rays cast")
    for name, own in frames.items():
        alone, kept, share = measured(own)
        table.add(name, f"{alone:.2f}", f"{kept:.2f}", f"{alone / kept:.2f}", f"{share:.0%}")


if __name__ == "__main__":
    sys.exit(main())
