"""What to bake, and the bake itself: one iterator for buttons, scripts and the command line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ...kernels.scene import Settings
from ..buttons.choose import receiver_names, water_names
from ..errors import DappleError
from ..maps.write import check_folder
from ..read.density import resolution_for
from ..read.volume import Bounds
from .pool import Pool
from .record import Record
from .remarks import LEAST_RESOLUTION, MOST_RESOLUTION
from .run import Run
from .timeline import Timeline


@dataclass(frozen=True)
class BakeRequest:
    """What to bake, by the names of mesh objects, of water none where something else casts; out: folder of the maps and
    of bake.json; volume: what bounds the work of the casters, if anything; full: maps in float32, not half floats;
    workers: how many processes solve at once, 0 for as many as cores and memory allow; anchor: the frame that the
    others are made to fit, None for the first, see `kernels.anchor`; density: texels on a metre of each receiver, 0
    where all maps have the resolution of the settings."""

    water: tuple[str, ...]
    receivers: tuple[str, ...]
    frames: tuple[int, ...]
    out: Path
    settings: Settings
    volume: Bounds | None = None
    full: bool = False
    workers: int = 0
    anchor: int | None = None
    density: float = 0.0


def request_from_scene(scene, water=None, receivers=None, frames=None, out=None) -> BakeRequest:
    """The BakeRequest that the scene's settings make; what is given takes the place of what the scene says.

    Raises DappleError for settings that are not made yet or cannot be met.
    """
    chosen = scene.dapple
    tolerance = float(f"{chosen.tolerance:.6g}")  # Blender keeps it in float32, where 0.01 is 0.0099999998
    settings = Settings(chosen.method, tolerance, chosen.resolution, chosen.padding, surface=chosen.surface)
    abbe = float(f"{chosen.dispersion:.6g}")
    settings = replace(settings, dispersion=abbe, match_cycles=chosen.match_cycles, bounces=chosen.bounces)
    settings = replace(settings, reuse=float(f"{chosen.reuse:.6g}"), tile=chosen.tile)
    water = water or water_names(scene)
    receivers = receivers or receiver_names(scene, water)
    density = float(f"{chosen.texels_per_metre:.6g}")
    wanted = resolution_for(density, receivers) if density else None
    settings = replace(settings, resolution=wanted or settings.resolution)
    out = Path(out or output_folder(chosen.output))
    frames, full, anchor = frames or _frames(scene), chosen.depth == "FULL", _range(scene)[0]
    return BakeRequest(water, receivers, frames, out, settings, _volume(chosen), full, chosen.workers, anchor, density)


def bake(context, request: BakeRequest, previews: Path | None = None, wait: float | None = None):
    """Bake all frames; yields a Progress for each, once its maps and bake.json are on disk, in the order in which they
    get there.

    previews: a folder for rough pictures of each frame, of which each is told by a Preview before the frame is done.
    wait: None blocks until there is something to tell; with a number of seconds an Iterator that yields a Waiting after
    so many, where there is nothing else, and never keeps its caller for longer than it takes to read a frame.

    Other processes solve; they end with the iterator, when it is closed too, at once. Frames that are on disk stay
    there; the scene's current frame is put back. Raises DappleError for what cannot be baked.
    """
    check(request)
    record = Record.open(request)
    check_folder(request.out)
    timeline = Timeline(context)
    try:
        with Pool(1) as pool:
            yield from Run(timeline, request, record, pool, previews, wait).steps()
    finally:
        timeline.restore()


def check(request):
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
    if not 0 <= request.density < float("inf"):
        raise DappleError(f"{request.density:g} texels per metre are out of range; set more than 0, or 0 for none.")
    if not request.settings.tolerance > 0:
        raise DappleError(
            f"A tolerance of {request.settings.tolerance:g} cannot be met; set one above 0, such as 0.01."
        )
    if request.workers < 0:
        raise DappleError(f"{request.workers} workers cannot bake; set 1 or more, or 0 for as many as fit.")
    if not request.settings.bounces >= 1:
        raise DappleError(f"{request.settings.bounces} bounces let no light through; set 1 or more, such as 6.")
    if not 0 <= request.settings.reuse < 1:
        raise DappleError(
            f"A reuse of {request.settings.reuse:g} is out of range; set 0 (off) to below 1, such as 0.8."
        )
    abbe = request.settings.dispersion
    if abbe and not abbe >= 1:
        raise DappleError(f"An Abbe number of {abbe:g} is impossible; set 0 for no dispersion, or 55.7 for water.")


def _volume(chosen):
    """The Bounds that the scene's settings hold, None where there are none."""
    return Bounds(chosen.volume.name, tuple(sorted(chosen.culling))) if chosen.volume else None


def _range(scene):
    """First and last frame of the scene's range, or the bake's own."""
    holder = scene if scene.dapple.use_scene_range else scene.dapple
    return holder.frame_start, holder.frame_end


def _frames(scene):
    """The frames of the range."""
    first, last = _range(scene)
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
