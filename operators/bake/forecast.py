"""What a bake will ask of the machine, from counts that are there before it starts."""

from __future__ import annotations

from ...kernels.scene import Settings
from ..read.receivers import can_receive
from .memory import count_workers, memory_per_worker


def forecast(scene, view_layer):
    """(workers, bytes of memory that each takes, about) of a bake of the range by the scene's settings."""
    chosen = scene.dapple
    holder = scene if chosen.use_scene_range else chosen
    settings = Settings(tolerance=chosen.tolerance, resolution=chosen.resolution, surface=chosen.surface)
    receivers = [o for o in chosen.receivers.all_objects if can_receive(o)] if chosen.receivers else []
    maps = max(1, len({o.dapple.shared_map.strip() or o.name for o in receivers if o != chosen.water}))
    each = memory_per_worker(_triangles(chosen.water, view_layer.depsgraph), maps, settings)
    workers = 1 if chosen.reuse else count_workers(chosen.workers, holder.frame_end - holder.frame_start + 1, each)
    return workers, each


def size(count):
    """Bytes as people read them: 80 MB, 1.3 GB."""
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"


def _triangles(water, depsgraph):
    """How many triangles the water has, as far as it was evaluated."""
    if water is None or depsgraph is None:
        return 0
    mesh = water.evaluated_get(depsgraph).data
    return max(0, len(mesh.loops) - 2 * len(mesh.polygons))
