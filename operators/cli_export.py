"""`dapple export`: loops, PNG, atlases and cookies of maps that are baked."""

from __future__ import annotations

import bpy

from .bake.bake import request_from_scene
from .maps.export import Export, export


def add_words(commands, names, frames):
    """Add the command to argparse's subparsers; names, frames: types of words of lists of either."""
    text = "Make loops, PNG, flipbook atlases and light cookies of the baked maps of the open scene."
    words = commands.add_parser("export", help="make loops, PNG, atlases and cookies of baked maps", description=text)
    form = words.add_mutually_exclusive_group()
    form.add_argument("--atlas", action="store_true", help="all frames in one image, for game engines")
    form.add_argument("--cookie", action="store_true", help="light over its mean, for a light's cookie")
    words.add_argument("--png", action="store_true", help="16-bit PNG, with a scale in the JSON; default: OpenEXR")
    words.add_argument(
        "--loop",
        type=int,
        nargs="?",
        const=0,
        metavar="N",
        help="no seam in time: one period of the motion, or the last N frames blended into the first",
    )
    words.add_argument("--size", type=int, default=0, help="texels along each side of a frame; default: as baked")
    words.add_argument("--frames", type=frames, default=(), help="such as 1-24; default: all that are baked")
    words.add_argument("--receivers", type=names, default=(), metavar="NAME,...", help="default: all that are baked")
    words.add_argument("--maps", help="folder of the maps; default: the scene's, //caustics")
    words.add_argument("--out", help="where to; default: export, in the folder of the maps")
    words.set_defaults(run=run)


def run(words):
    """Export, a line for each receiver; returns the exit code."""
    from pathlib import Path

    form = "atlas" if words.atlas else "cookie" if words.cookie else "sequence"
    out = Path(words.out) if words.out else None
    wish = Export(form, words.png, words.loop, words.size, words.frames, words.receivers, out)
    request = request_from_scene(bpy.context.scene, frames=(bpy.context.scene.frame_current,), out=words.maps)
    for sentence in export(bpy.context, request, wish):
        print(sentence, flush=True)
    return 0
