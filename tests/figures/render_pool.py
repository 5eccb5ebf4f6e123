"""Render the pool with baked caustics in EEVEE, with the same maps in Cycles once, and by Cycles without any bake.

Run as `.venv/bin/python tests/figures/render_pool.py`; it writes docs/images/pool_<view>_<engine>_<frame>.jpg. On two
cores without a graphics card it takes about twenty-five minutes, most of it Cycles. Cycles gets what an artist would
give it: shadow caustics on the water, the receivers and the Sun, which the file has, and 128 samples, not denoised.
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "sample_blends" / "pool.blend"
IMAGES = ROOT / "docs" / "images"
FRAMES = (1, 13, 25)
VIEWS = ("Edge", "Underwater")
JPEG_QUALITY = 88


def load_dapple():
    """Import the working tree as the package `dapple` and register the add-on."""
    spec = importlib.util.spec_from_file_location(
        "dapple", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    package = sys.modules["dapple"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    package.register()
    return package


def open_scene():
    """Open the pool, set to write JPEG files."""
    bpy.ops.wm.open_mainfile(filepath=str(SCENE))
    write_jpegs(bpy.context.scene.render)


def write_jpegs(render):
    """Have pictures written as JPEG files, over those that are there, that do not name folders of this machine."""
    render.image_settings.file_format, render.image_settings.quality = "JPEG", JPEG_QUALITY
    render.use_overwrite, render.use_stamp_filename = True, False


def render_views(engine, frames=FRAMES, views=VIEWS):
    """Render every view on every frame; `engine` is a part of the files' names."""
    scene = bpy.context.scene
    for frame in frames:
        scene.frame_set(frame)
        for view in views:
            scene.camera = bpy.data.objects[view]
            scene.render.filepath = str(IMAGES / f"pool_{view.lower()}_{engine}_{frame:03d}.jpg")
            bpy.ops.render.render(write_still=True)


def render_eevee(folder):
    """Bake the frames into `folder`, attach the maps and render."""
    from dapple.operators.bake.bake import bake, request_from_scene
    from dapple.operators.show.attach import attach

    open_scene()
    request = request_from_scene(bpy.context.scene, frames=FRAMES, out=folder)
    for progress in bake(bpy.context, request):
        print(progress.message, flush=True)
    attach(bpy.context, request.receivers, request.out, request.water)
    bpy.context.scene.eevee.taa_render_samples = 16
    render_views("eevee")
    set_up_cycles(samples=48)
    render_views("maps", FRAMES[:1], VIEWS[:1])


def set_up_cycles(samples):
    """Let Cycles render, small and not denoised."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = 640, 360


def render_cycles():
    """Render the file as it is by path tracing."""
    open_scene()
    set_up_cycles(samples=128)
    render_views("cycles")


def main():
    """Write all the pictures."""
    dapple = load_dapple()
    IMAGES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        render_eevee(folder)
    render_cycles()
    dapple.unregister()


if __name__ == "__main__":
    main()
