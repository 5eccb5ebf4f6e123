"""Frames of the sample .blend files as Scenes, read by Blender in a process of its own, beside which Mitsuba need not
live."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from bench_stages import ROOT, load_dapple


def read(name, frame=2):
    """The Scene of a frame of sample_blends/NAME.blend, as a bake reads it."""
    with ProcessPoolExecutor(1, get_context("spawn")) as alone:
        return alone.submit(_read, name, frame).result()


def _read(name, frame):
    load_dapple()
    return read_here(name, frame)


def read_here(name, frame=2):
    """As `read`, in this process, in which the add-on is registered."""
    import bpy

    from dapple.operators.bake.bake import request_from_scene
    from dapple.operators.read.extract import read_scene
    from dapple.operators.read.mesh_arrays import TopologyCache

    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / f"{name}.blend"))
    request = request_from_scene(bpy.context.scene, frames=(frame, frame + 1), out=".")
    bpy.context.scene.frame_set(frame)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return read_scene(depsgraph, request.water, request.receivers, TopologyCache(), request.volume)[0]
