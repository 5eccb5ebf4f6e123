"""Render glass, the room with a mirror and the lagoon in EEVEE with baked caustics.

Run as `.venv/bin/python tests/figures/render_casters.py [scene ...]`; it writes docs/images/<scene>_<view>.jpg. A scene
takes some minutes on two cores without a graphics card.
"""

from __future__ import annotations

import sys
import tempfile

import bpy
from render_pool import IMAGES, ROOT, load_dapple, write_jpegs

# scene: (frame, texels along a map, tolerance, views)
SCENES = {
    "glass": (1, 512, 0.02, ("Above", "Near")),
    "mirror_room": (1, 512, 0.02, ("Room", "Into the Mirror")),
    "lagoon": (1, 512, 0.1, ("Boat", "Diver")),
}


def bake_and_attach(name, folder):
    """Open a scene, bake its frame into `folder` and let its materials show the maps."""
    from dapple.operators.bake.bake import bake, request_from_scene
    from dapple.operators.read.casters import caster_names
    from dapple.operators.show.attach import attach

    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / f"{name}.blend"))
    scene = bpy.context.scene
    frame, scene.dapple.resolution, scene.dapple.tolerance, _ = SCENES[name]
    scene.frame_set(frame)
    request = request_from_scene(scene, frames=(frame,), out=folder)
    for progress in bake(bpy.context, request):
        print(progress.message, *progress.warnings, flush=True)
    casters = caster_names(bpy.context.evaluated_depsgraph_get(), {*request.water, *request.receivers})
    attach(bpy.context, request.receivers, request.out, (*request.water, *casters))


def render_views(name):
    """Render the scene's views to docs/images."""
    scene = bpy.context.scene
    scene.eevee.taa_render_samples = 8
    write_jpegs(scene.render)
    for view in SCENES[name][3]:
        scene.camera = bpy.data.objects[view]
        scene.render.filepath = str(IMAGES / f"{name}_{view.lower().replace(' ', '_')}.jpg")
        bpy.ops.render.render(write_still=True)


def main(names):
    """Write the pictures of the scenes named."""
    dapple = load_dapple()
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            bake_and_attach(name, folder)
            render_views(name)
    dapple.unregister()


if __name__ == "__main__":
    main(sys.argv[1:] or list(SCENES))
