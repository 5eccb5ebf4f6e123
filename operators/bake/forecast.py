"""What a bake will ask of the machine, from counts that are there before it starts."""

from __future__ import annotations

import time

from ...kernels.scene import Settings
from ..buttons.choose import flagged_receivers
from ..read.casters import caster_names
from ..read.density import side_in_metres, size_for
from ..read.receivers import can_receive, map_name
from .memory import count_workers, memory_per_worker

# Panels are drawn many times a second.
_FEW = 20  # receivers that are looked at
_SECONDS = 2.0  # for which what casts is taken as it was
_cast: dict[str, tuple[float, int]] = {}  # scene -> when, triangles


def forecast(scene, view_layer):
    """(workers, bytes of memory that each takes, about) of a bake of the range by the scene's settings."""
    chosen = scene.dapple
    holder = scene if chosen.use_scene_range else chosen
    settings = Settings(tolerance=chosen.tolerance, resolution=chosen.resolution, surface=chosen.surface)
    flagged = [scene.objects[name] for name in flagged_receivers(scene)]
    receivers = [o for o in chosen.receivers.all_objects if can_receive(o)] if chosen.receivers else flagged
    maps = {map_name(o): o for o in receivers if o != chosen.water}
    depsgraph = view_layer.depsgraph
    water, casting = _triangles(chosen.water, depsgraph), _casting(scene, depsgraph, maps.values())
    ground = sum(_triangles(o, depsgraph) for o in maps.values())
    each = memory_per_worker(water, casting, ground, _sizes(chosen, maps.values()), settings)
    workers = 1 if chosen.reuse else count_workers(chosen.workers, holder.frame_end - holder.frame_start + 1, each)
    return workers, each


def _sizes(chosen, receivers):
    """How many texels a side the maps of receivers have; of many some are looked at, for the rest."""
    count = max(1, len(receivers))
    if not chosen.texels_per_metre:
        return (chosen.resolution,) * count
    few = [o for o in receivers if o.type == "MESH"][:_FEW]
    found = [size_for(side_in_metres(o), chosen.texels_per_metre, chosen.resolution) for o in few]
    return tuple((found or [chosen.resolution]) * -(-count // max(len(found), 1)))[:count]


def size(count):
    """Bytes as people read them: 80 MB, 1.3 GB."""
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"


def _casting(scene, depsgraph, receivers):
    """How many triangles the glass and metal of a scene have; looked up anew every few seconds."""
    now = time.monotonic()
    when, count = _cast.get(scene.name, (-_SECONDS, 0))
    if depsgraph is not None and now - when >= _SECONDS:
        others = {o.name for o in (*receivers, scene.dapple.water) if o}
        found = map(scene.objects.get, caster_names(depsgraph, others))
        count = sum(_triangles(o, depsgraph) for o in found if o)
        _cast[scene.name] = now, count
    return count


def _triangles(obj, depsgraph):
    """How many triangles an object has, as far as it was evaluated."""
    if obj is None or depsgraph is None:
        return 0
    mesh = obj.evaluated_get(depsgraph).data
    return max(0, len(mesh.loops) - 2 * len(mesh.polygons)) if obj.type == "MESH" else 0
