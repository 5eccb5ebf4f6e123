"""`dapple bake` and its like: the same words for the launcher as for `blender -b SCENE.blend --command dapple bake`."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import bpy

from ..kernels.presets import PRESETS
from ..kernels.scene import SURFACES
from . import cli_export
from .bake.bake import bake, request_from_scene
from .chart import command as chart
from .errors import DappleError
from .maps.exr_file import is_whole
from .read.density import resolution_for
from .read.lightmap_uvs import supply

_UNSAVED = (
    "The file itself stays as it is: press Make Lightmap UVs in it, which makes the same, before you attach maps."
)
_SETTINGS = ("method", "surface", "tolerance", "resolution", "dispersion", "match_cycles", "bounces", "reuse", "tile")


def main(argv: list[str], peers=()) -> int:
    """Run the command in argv on the open file. Returns the exit code: 0 when all that was asked for is on disk and
    whole, 1 with a sentence on stderr when not, 2 for words that make no sense. peers: what joins a chart."""
    try:
        words = _parser(peers).parse_args(argv)
    except SystemExit as leaving:  # argparse has said why
        return int(leaving.code or 0)
    try:
        return words.run(words)
    except DappleError as error:
        print(f"dapple: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        kept = "no chart is written" if words.command == "chart" else "the finished frames are kept"
        print(f"dapple: stopped; {kept}.", file=sys.stderr)
    return 1


def _request(words):
    """The BakeRequest of the scene's settings and the words that take their place."""
    request = request_from_scene(bpy.context.scene, words.water, words.receivers, words.frames, words.out)
    given = {key: getattr(words, key) for key in _SETTINGS}
    settings = replace(request.settings, **{key: value for key, value in given.items() if value is not None})
    workers = request.workers if words.workers is None else words.workers
    density = 0.0 if words.resolution else request.density
    if words.texels_per_metre is not None:
        density = words.texels_per_metre
        wanted = resolution_for(density, request.receivers) if density > 0 else None
        settings = replace(settings, resolution=wanted or settings.resolution)
    full = request.full or words.full_float
    return replace(request, settings=settings, full=full, workers=workers, density=density)


def _bake(words):
    """Bake, one line a frame; returns the exit code."""
    request = _request(words)
    made = supply(bpy.context, request)
    if made:
        print(f"dapple: {made} {_UNSAVED}", flush=True)
    said, maps = set(), []
    for progress in bake(bpy.context, request):
        print(f"[{progress.done}/{progress.total}] {progress.message}", flush=True)
        for warning in progress.warnings:
            if warning not in said:
                print(f"dapple: warning: {warning}", file=sys.stderr, flush=True)
        said.update(progress.warnings)
        maps += progress.maps
    broken = [path for path in maps if not is_whole(path)]  # not on disk any more, or cut short
    if broken:
        raise DappleError(f"{len(broken)} maps are not on disk and whole: {broken[0]} is one; bake these frames again.")
    print(f"Maps of {len(request.frames)} frames for {len(request.receivers)} receivers are in {request.out}")
    return 0


def _parser(peers):
    """The parser of the command's words."""
    # Here, since it loads embreex, which nothing but a bake needs.
    from ..kernels.methods import METHODS

    parser = argparse.ArgumentParser(
        prog="dapple", description="Bake caustics of animated water and glass into lightmaps."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    words = commands.add_parser("bake", help="bake the open scene", description="Bake the caustics of the open scene.")
    words.set_defaults(run=_bake)
    words.add_argument("--frames", type=_frames, help="such as 1-24,30; default: the scene's range")
    words.add_argument("--method", choices=("auto", *METHODS), help="how the light is found; default: the scene's")
    words.add_argument("--surface", choices=SURFACES, help="the smooth water (auto) or its mesh as it is")
    words.add_argument("--dispersion", type=float, metavar="ABBE", help="0: none; the Abbe number of water is 55.7")
    words.add_argument("--match-cycles", action="store_true", default=None, help="divide the maps by the IOR squared")
    exactness = words.add_mutually_exclusive_group()
    exactness.add_argument("--tolerance", type=float, help="mean squared error over the mean square of the light")
    exactness.add_argument("--preset", type=_preset, dest="tolerance", help="tolerance of draft, preview or final")
    fineness = words.add_mutually_exclusive_group()
    fineness.add_argument("--resolution", type=int, help="texels along each side of a map")
    fineness.add_argument("--texels-per-metre", type=float, help="the same by the size of each receiver; 0: none")
    words.add_argument("--bounces", type=int, help="surfaces that bend or mirror light on its way, at most")
    words.add_argument("--reuse", type=float, help="share of its light that a texel keeps from frame to frame; 0: none")
    words.add_argument("--tile", action="store_true", default=None, help="water and floor are one tile of many")
    words.add_argument("--full-float", action="store_true", help="32-bit maps; default: the scene's, or half floats")
    words.add_argument("--workers", type=int, help="frames solved at once; 0: as cores and memory allow")
    words.add_argument("--out", help="folder of the maps and of bake.json; default: the scene's, //caustics")
    words.add_argument("--water", type=_names, metavar="OBJECT,...", help="default: the scene's")
    words.add_argument("--receivers", type=_names, metavar="OBJECT,...", help="default: the scene's")
    cli_export.add_words(commands, _names, _frames)
    chart.add_words(commands, _names, peers)
    return parser


def _preset(text):
    """The tolerance of a preset."""
    if text.upper() not in PRESETS:
        raise argparse.ArgumentTypeError(f"expected draft, preview or final, got '{text}'")
    return PRESETS[text.upper()]


def _names(text):
    """Names between commas, each once."""
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise argparse.ArgumentTypeError("expected names of objects between commas")
    return names


def _frames(text):
    """Frame numbers of a text such as 1-24,30, in order, each once."""
    frames = set()
    for part in text.split(","):
        first, _, last = part.strip().partition("-")
        if not (first.isdecimal() and (last or first).isdecimal() and int(first) <= int(last or first)):
            raise argparse.ArgumentTypeError(f"expected frames such as 1-24,30, got '{part.strip()}'")
        frames.update(range(int(first), int(last or first) + 1))
    return tuple(sorted(frames))
