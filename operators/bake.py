"""Bake frames: set the frame, read the scene, solve, write; one iterator for buttons, scripts and the command line."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ..kernels.scene import Settings
from ..kernels.surface.reconstruct import Reconstruction
from .errors import DappleError
from .extract import read_scene
from .mesh_arrays import TopologyCache
from .receivers import can_receive
from .record import Record, frame_entry, summary
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
_MUCH = 0.5  # of the light on receivers
LEAST_RESOLUTION, MOST_RESOLUTION = 16, 16384


@dataclass(frozen=True)
class BakeRequest:
    """What to bake, by the names of mesh objects, of water none where something else casts; out: folder of the maps and
    of bake.json; volume: what bounds the work of the casters, if anything."""

    water: tuple[str, ...]
    receivers: tuple[str, ...]
    frames: tuple[int, ...]
    out: Path
    settings: Settings
    volume: Bounds | None = None


@dataclass(frozen=True)
class Progress:
    """A frame that is on disk: its number, how many of how many that makes, a sentence on it, its
    maps, and its warnings."""

    frame: int
    done: int
    total: int
    message: str
    maps: tuple[Path, ...]
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
    water = water or ((chosen.water.name,) if chosen.water else ())
    receivers = receivers or _receivers(chosen, water)
    out = Path(out or _folder(chosen.output))
    return BakeRequest(water, receivers, frames or _frames(scene), out, settings, _volume(chosen))


def bake(context, request: BakeRequest) -> Iterator[Progress]:
    """Bake frame after frame; yields after each, once its maps and bake.json are on disk.

    A frame that fails, or an iterator that is closed, leaves the frames before as they are; the scene's current frame
    is put back. Raises DappleError for what cannot be baked.
    """
    _check(request)
    scene_name, frame, subframe = context.scene.name, context.scene.frame_current, context.scene.frame_subframe
    record = Record.open(request)
    check_folder(request.out)
    shared = TopologyCache(), _TexelCache(request.settings), Reconstruction()
    try:
        for done, number in enumerate(request.frames, 1):
            bpy.data.scenes[scene_name].frame_set(number)
            try:
                entry = _bake_frame(context.evaluated_depsgraph_get(), number, request, *shared)
            except DappleError as error:
                raise DappleError(f"Frame {number}: {error}") from error
            record.add(number, entry)
            maps = tuple(request.out / name for name in entry["files"].values())
            yield Progress(number, done, len(request.frames), summary(number, entry), maps, tuple(entry["warnings"]))
    finally:
        bpy.data.scenes[scene_name].frame_set(frame, subframe=subframe)


def _bake_frame(depsgraph, number, request, topology, texels, reconstruction):
    """Solve and write one frame; returns its entry for bake.json."""
    # Only a bake needs embreex: without this, Blender would load it at every start.
    from ..kernels import methods

    clock = _Clock()
    scene, warnings = read_scene(depsgraph, request.water, request.receivers, topology, request.volume)
    _check_maps([receiver.name for receiver in scene.receivers], request.settings.resolution)
    clock.lap("extract")
    charts = tuple(texels.of(receiver) for receiver in scene.receivers)
    clock.lap("texels")
    solution = methods.solve(scene, charts, request.settings, reconstruction)
    clock.lap("solve")
    warnings = [*warnings, *_dark(solution.diagnostics)]
    paths = {receiver.name: map_path(request.out, receiver.name, number) for receiver in scene.receivers}
    for path, image in zip(paths.values(), solution.images):
        write_exr(path, image)
    clock.lap("write")
    files = {receiver: path.relative_to(request.out).as_posix() for receiver, path in paths.items()}
    return frame_entry(scene, solution.diagnostics, clock.seconds, files, warnings)


def _dark(diagnostics):
    """Warnings on receivers that stay dark."""
    received = diagnostics.flux_received
    warnings = [_NO_LIGHT.format(name) for name, flux in received.items() if not flux.any()]
    back = np.sum(diagnostics.flux_lost.get("back", 0.0))
    total = back + sum(flux.sum() for flux in received.values())
    if back > _MUCH * total:
        warnings.append(_BACKS.format(back / total))
    return warnings


class _Clock:
    """Seconds from lap to lap."""

    def __init__(self):
        self.seconds = {}
        self._last = time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self.seconds[stage], self._last = now - self._last, now


class _TexelCache:
    """Texels of each receiver, made anew only where its mesh or UVs changed since the frame before."""

    def __init__(self, settings):
        self._settings = settings
        self._known = {}

    def of(self, receiver):
        """The Texels of a Receiver; raises DappleError for UVs that cannot carry a lightmap."""
        from ..kernels.maps.texels import UVError, rasterise

        before, texels = self._known.get(receiver.name, (None, None))
        if before is None or not _same(before, receiver):
            try:
                texels = rasterise(receiver, self._settings.resolution, self._settings.padding)
            except UVError as error:
                raise DappleError(f"Receiver '{receiver.name}' cannot take a lightmap: {error}.") from error
            self._known[receiver.name] = (receiver, texels)
        return texels


def _same(one, other):
    """Whether two Receivers are equal in every number."""
    return all(np.array_equal(getattr(one, key), getattr(other, key)) for key in ("positions", "triangles", "uvs"))


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


def _receivers(chosen, water):
    """Names of what can receive in the receivers' collection and those inside it, but the water, in order."""
    if chosen.receivers is None:
        raise DappleError(
            "No receivers are chosen; pick the collection of the meshes that the light falls on in the Dapple tab."
        )
    names = {o.name for o in chosen.receivers.all_objects if can_receive(o)} - set(water)
    if not names:
        raise DappleError(f"Collection '{chosen.receivers.name}' holds no mesh but the water; put the receivers in it.")
    return tuple(sorted(names))


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


def _folder(output):
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
