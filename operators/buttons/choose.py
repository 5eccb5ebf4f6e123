"""Water and receivers where none are set: by Cycles' flags, or from what is selected.

Receivers are what Cycles' Receive Shadow Caustics marks, until a collection is picked. On the first press of Bake with
nothing set, the selection says what is what, and the answer is written into the settings, where it can be changed.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..errors import DappleError
from ..read.casters import casts
from ..read.find import name_of
from ..read.receivers import can_receive
from ..read.shader_nodes import materials_of
from ..read.speculars import Glass, read_specular

COLLECTION = "Caustics Receivers"
_OPEN = 1e-3  # of a mesh's area: the area of its holes that is more than rounding


def flagged_receivers(scene) -> tuple[str, ...]:
    """Names of the scene's meshes whose Receive Shadow Caustics is on, Cycles' own flag."""
    flagged = (o for o in scene.objects if o.type == "MESH" and _is_flagged(o))
    return tuple(sorted(o.name for o in flagged if o != scene.dapple.water))


def wants_choice(scene) -> bool:
    """Whether a scene says neither what is water nor what the light falls on."""
    return scene.dapple.water is None and scene.dapple.receivers is None and not flagged_receivers(scene)


def can_choose(context) -> bool:
    """Whether enough is selected to choose from."""
    return sum(o.type == "MESH" for o in context.selected_objects) > 1


def choose(context) -> str:
    """Write water and receivers into the scene's settings, as what is selected says; returns a sentence on it.

    Water is what lets light through and is no closed body; where nothing does, and no glass or metal is selected, the
    highest. Glass and metal cast by themselves. All else are receivers, put in a collection of their own beside those
    that they are in. Raises DappleError, with nothing changed, where no receiver is left.
    """
    depsgraph = context.evaluated_depsgraph_get()
    kinds = {o: _kind(o.evaluated_get(depsgraph)) for o in context.selected_objects if o.type == "MESH"}
    water = [o for o, kind in kinds.items() if kind == "water"]
    if not water and "caster" not in kinds.values():
        water = sorted(kinds, key=_height)[-1:]
    water = sorted(water, key=_extent)[-1:]
    receivers = [o for o, kind in kinds.items() if kind is None and o not in water]
    if not receivers:
        raise DappleError("Select what the light falls on too, beside the water or the glass; or pick a collection.")
    settings = context.scene.dapple
    settings.receivers = _collection(context.scene, receivers)
    settings.water = water[0] if water else None
    names = ", ".join(f"'{o.name}'" for o in receivers)
    taken = f"'{water[0].name}' as the water" if water else "glass and metal as what casts"
    return f"Took {taken} and {names} as what the light falls on, in collection '{settings.receivers.name}'"


def _is_flagged(obj):
    cycles = getattr(obj, "cycles", None)  # Cycles is an add-on, and can be off
    return bool(getattr(cycles, "is_caustics_receiver", False))


def _kind(shown):
    """What an evaluated object looks like: "water", "caster" of caustics, or None."""
    speculars = [m and read_specular(m) for m in materials_of(shown)]
    found = [s and (s, "") for s in speculars]
    cast = casts(shown.original, found)[0]
    if not any(cast):
        return None
    return "water" if any(isinstance(c, Glass) for c in cast) and _is_open(shown) else "caster"


def _is_open(shown):
    """Whether the surface of an evaluated object has a rim: its faces' areas, as vectors, do not cancel."""
    mesh = shown.to_mesh()
    try:
        count = len(mesh.polygons)
        normals, areas = np.empty(3 * count, np.float32), np.empty(count, np.float32)
        mesh.polygons.foreach_get("normal", normals)
        mesh.polygons.foreach_get("area", areas)
    finally:
        shown.to_mesh_clear()
    return np.linalg.norm(areas @ normals.reshape(-1, 3)) > _OPEN * areas.sum()


def _corners(obj):
    """The corners (8,3) of an object's bounds, in the world."""
    corners = np.array(obj.bound_box)
    matrix = np.array(obj.matrix_world)
    return corners @ matrix[:3, :3].T + matrix[:3, 3]


def _height(obj):
    return _corners(obj)[:, 2].mean()


def _extent(obj):
    return np.prod(np.ptp(_corners(obj)[:, :2], axis=0))


def _collection(scene, receivers):
    """A collection that holds just these objects: one that does so already, or a new one in the scene."""
    for known in scene.collection.children_recursive:
        if set(known.all_objects) == set(receivers):
            return known
    made = bpy.data.collections.new(COLLECTION)
    scene.collection.children.link(made)
    for obj in receivers:
        made.objects.link(obj)
    return made


def water_names(scene) -> tuple[str, ...]:
    """Names of what was picked as water, and of what is water by its own settings."""
    picked = [scene.dapple.water] if scene.dapple.water else []
    return tuple(map(name_of, dict.fromkeys(picked + [o for o in scene.objects if o.dapple.caustics == "WATER"])))


def receiver_names(scene, water) -> tuple[str, ...]:
    """Names of what can receive: in the collection that is picked and those inside it, else by Cycles' flag; in order,
    but the water. Raises DappleError where there is none."""
    picked = scene.dapple.receivers
    if picked is None:
        names = set(flagged_receivers(scene)) - set(water)
        if not names:
            raise DappleError(
                "No receivers are chosen; pick the collection of the meshes that the light falls on in the Dapple tab, "
                "or turn on Receive Shadow Caustics on them, in the Object tab under Shading."
            )
        return tuple(sorted(names))
    names = {name_of(o) for o in picked.all_objects if can_receive(o)} - set(water)
    if not names:
        raise DappleError(f"Collection '{picked.name}' holds no mesh but the water; put the receivers in it.")
    return tuple(sorted(names))
