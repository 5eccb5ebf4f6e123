"""Bake frames: set the frame, read the scene, solve, write; one iterator for buttons, scripts and the command line."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ..kernels.scene import Settings
from .caches import Player
from .choose import receiver_names, water_names
from .errors import DappleError
from .extract import read_scene
from .record import Record, frame_entry, summary
from .shared import Shared
from .volume import Bounds
from .write import check_folder, folder_name, map_path, write_exr

_NO_LIGHT = (
    "No light by way of water, glass or mirrors reaches receiver '{}'; check that one of them lies between the lamps "
    "and it, or that it stands where they mirror the lamps."
)
_BACKS = (
    "{:.0%} of the light that comes to receivers falls on the backs of their faces, which stay dark. Turn the "
    "faces round (Edit Mode: Mesh > Normals > Flip), or give a wall that is lit on both sides a thickness."
)
_SLOW = (
    "Rays are traced by numpy, some twenty times slower, for {}. Reinstall the extension for this system, or use a "
    "Blender from blender.org; the maps are the same."
)
_MUCH = 0.5  # of the light on receivers
LEAST_RESOLUTION, MOST_RESOLUTION = 16, 16384


@dataclass(frozen=True)
class BakeRequest:
    """What to bake, by the names of mesh objects, of water none where something else casts; out: folder of the maps and
    of bake.json; volume: what bounds the work of the casters, if anything; full: maps in float32, not half floats."""

    water: tuple[str, ...]
    receivers: tuple[str, ...]
    frames: tuple[int, ...]
    out: Path
    settings: Settings
    volume: Bounds | None = None
    full: bool = False


@dataclass(frozen=True)
class Preview:
    """A rough picture of a frame, whose maps lie in a folder as they will in that of the bake."""

    frame: int
    folder: Path


@dataclass(frozen=True)
class Progress:
    """A frame that is on disk: its number, how many of how many that makes, a sentence on it, its
    maps, and its warnings."""

    frame: int
    done: int
    total: int
    message: str
    maps: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()


def request_from_scene(scene, water=None, receivers=None, frames=None, out=None) -> BakeRequest:
    """The BakeRequest that the scene's settings make; what is given takes the place of what the scene says.

    Raises DappleError for settings that are not made yet or cannot be met.
    """
    chosen = scene.dapple
    tolerance = float(f"{chosen.tolerance:.6g}")  # Blender keeps it in float32, where 0.01 is 0.0099999998
    settings = Settings(chosen.method, tolerance, chosen.resolution, chosen.padding, surface=chosen.surface)
    abbe = float(f"{chosen.dispersion:.6g}")
    settings = replace(settings, dispersion=abbe, match_cycles=chosen.match_cycles, bounces=chosen.bounces)
    settings = replace(settings, reuse=float(f"{chosen.reuse:.6g}"))
    water = water or water_names(scene)
    receivers = receivers or receiver_names(scene, water)
    out = Path(out or output_folder(chosen.output))
    frames, full = frames or _frames(scene), chosen.depth == "FULL"
    return BakeRequest(water, receivers, frames, out, settings, _volume(chosen), full)


def bake(context, request: BakeRequest, previews: Path | None = None) -> Iterator[Progress | Preview]:
    """Bake frame after frame; yields after each, once its maps and bake.json are on disk.

    previews: a folder for rough pictures of each frame, of which each is told before the frame is done.

    A frame that fails, or an iterator that is closed, leaves the frames before as they are; the scene's current frame
    is put back. Raises DappleError for what cannot be baked.
    """
    _check(request)
    scene_name, frame, subframe = context.scene.name, context.scene.frame_current, context.scene.frame_subframe
    record = Record.open(request)
    check_folder(request.out)
    shared, player = Shared(request.settings), Player(scene_name)
    try:
        for done, number in enumerate(request.frames, 1):
            player.go(number)
            try:
                steps = _bake_frame(context.evaluated_depsgraph_get(), number, request, shared, previews)
                entry = yield from _previews(steps)
            except DappleError as error:
                raise DappleError(f"Frame {number}: {error}") from error
            record.add(number, entry)
            maps = tuple(request.out / name for name in entry["files"].values())
            yield Progress(number, done, len(request.frames), summary(number, entry), maps, tuple(entry["warnings"]))
    finally:
        bpy.data.scenes[scene_name].frame_set(frame, subframe=subframe)


def _previews(steps):
    """Yield the Previews of the steps of a frame; returns its entry, the last step."""
    for step in steps:
        if not isinstance(step, Preview):
            return step
        yield step


def _bake_frame(depsgraph, number, request, shared, previews):
    """Solve and write one frame; yields a Preview for each rough picture, where asked for, and last its entry for
    bake.json."""
    clock = _Clock()
    scene, warnings = read_scene(depsgraph, request.water, request.receivers, shared.topology, request.volume)
    _check_maps([receiver.name for receiver in scene.receivers], request.settings.resolution)
    clock.lap("extract")
    charts = tuple(shared.texels.of(receiver) for receiver in scene.receivers)
    clock.lap("texels")
    for solution in shared.sequence.rough(scene, charts) if previews else ():
        _write_maps(previews, number, scene, solution, request.full)
        yield Preview(number, previews)
    solution = shared.sequence.solve(number, scene, charts)
    clock.lap("solve")
    warnings = [*warnings, *_remarks(solution.diagnostics)]
    files = _write_maps(request.out, number, scene, solution, request.full)
    clock.lap("write")
    yield frame_entry(scene, solution.diagnostics, clock.seconds, files, warnings)


def _write_maps(folder, number, scene, solution, full):
    """Write the maps of a frame; returns where they lie in the folder, by receiver."""
    paths = {receiver.name: map_path(folder, receiver.name, number) for receiver in scene.receivers}
    for path, image in zip(paths.values(), solution.images, strict=True):
        write_exr(path, image, full)
    return {receiver: path.relative_to(folder).as_posix() for receiver, path in paths.items()}


def _remarks(diagnostics):
    """Warnings on receivers that stay dark, and on slow rays."""
    received = diagnostics.flux_received
    warnings = [_NO_LIGHT.format(name) for name, flux in received.items() if not flux.any()]
    back = np.sum(diagnostics.flux_lost.get("back", 0.0))
    total = back + sum(flux.sum() for flux in received.values())
    if back > _MUCH * total:
        warnings.append(_BACKS.format(back / total))
    if diagnostics.slow_rays:
        warnings.append(_SLOW.format(diagnostics.slow_rays))
    return warnings


class _Clock:
    """Seconds from lap to lap."""

    def __init__(self):
        self.seconds = {}
        self._last = time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self.seconds[stage], self._last = now - self._last, now


def _check(request):
    """Raise DappleError for a request that can be seen to fail before the first frame."""
    if not request.receivers:
        raise DappleError("There are no receivers; pick a collection with the meshes that the light falls on.")
    for name in sorted(set(request.water) & set(request.receivers)):
        raise DappleError(f"Object '{name}' is both water and receiver; take it out of one of them.")
    if not request.frames or min(request.frames) < 0:
        raise DappleError("There are no frames to bake from 0 on; set a start that is not after the end.")
    resolution = request.settings.resolution
    if not LEAST_RESOLUTION <= resolution <= MOST_RESOLUTION:
        raise DappleError(f"A resolution of {resolution} is out of range; set {LEAST_RESOLUTION} to {MOST_RESOLUTION}.")
    if not request.settings.tolerance > 0:
        raise DappleError(
            f"A tolerance of {request.settings.tolerance:g} cannot be met; set one above 0, such as 0.01."
        )
    if not request.settings.bounces >= 1:
        raise DappleError(f"{request.settings.bounces} bounces let no light through; set 1 or more, such as 6.")
    if not 0 <= request.settings.reuse < 1:
        raise DappleError(
            f"A reuse of {request.settings.reuse:g} is out of range; set 0 (off) to below 1, such as 0.8."
        )
    abbe = request.settings.dispersion
    if abbe and not abbe >= 1:
        raise DappleError(f"An Abbe number of {abbe:g} is impossible; set 0 for no dispersion, or 55.7 for water.")


def _check_maps(names, resolution):
    """Raise DappleError for maps of these names that cannot all be kept."""
    if len(names) * resolution**2 > MOST_RESOLUTION**2:
        most = int(MOST_RESOLUTION / len(names) ** 0.5)
        raise DappleError(f"{len(names)} maps of {resolution} texels do not fit into memory; set {most} at most.")
    folders = {}
    for name in names:
        other = folders.setdefault(folder_name(name).casefold(), name)
        if other != name:
            raise DappleError(f"Receivers '{other}' and '{name}' would share a folder on some systems; rename one.")


def _volume(chosen):
    """The Bounds that the scene's settings hold, None where there are none."""
    return Bounds(chosen.volume.name, tuple(sorted(chosen.culling))) if chosen.volume else None


def _frames(scene):
    """The scene's range of frames, or the bake's own."""
    holder = scene if scene.dapple.use_scene_range else scene.dapple
    first, last = holder.frame_start, holder.frame_end
    if last < first:
        raise DappleError(f"The frame range is empty: it starts at {first} and ends at {last}; set the end later.")
    return tuple(range(first, last + 1))


def output_folder(output):
    """The absolute folder of the scene's output setting; // stands for the folder of the .blend file."""
    if output.startswith("//") and not bpy.data.filepath:
        raise DappleError(
            f"The output folder '{output}' is relative to a file not saved yet; save it, or set a full path."
        )
    folder = bpy.path.abspath(output)
    if not Path(folder).is_absolute():
        raise DappleError(
            f"The output folder '{output}' is no full path; start it with // or choose it in the browser."
        )
    return folder
