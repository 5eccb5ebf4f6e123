"""Objects by the names that requests hold, and the names of objects.

Requests hold names, for an undo makes references invalid. An object of a library may bear the name of one of this file:
there its full name, with the library's, stands for it.
"""

from __future__ import annotations

import bpy

from ..errors import DappleError

_GIVES_MESH = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


def find_object(name):
    """The object of a name or full name, None where there is none; this file's own come first."""
    found = bpy.data.objects.get(name)
    return found or next((o for o in bpy.data.objects if o.library and o.name_full == name), None)


def name_of(obj):
    """The name by which `find_object` finds an object."""
    return obj.name if bpy.data.objects.get(obj.name) == obj else obj.name_full


def shows_collection(obj) -> bool:
    """Whether an object is an Empty that shows a collection."""
    return obj.type == "EMPTY" and obj.instance_type == "COLLECTION" and obj.instance_collection is not None


def can_be_water(obj) -> bool:
    """Whether an object can be picked as water: what gives a mesh, or an Empty that shows a collection."""
    return obj.type in _GIVES_MESH or shows_collection(obj)


def shown_by(obj):
    """The objects whose meshes an object shows: those of the collection that it shows, or itself."""
    if not shows_collection(obj):
        return [obj]
    return [mesh for inner in obj.instance_collection.all_objects for mesh in shown_by(inner) if can_be_water(mesh)]


def checked_object(name, serves):
    """The object of a name; raises DappleError unless there is one and it `serves`."""
    found = find_object(name)
    if found is None:
        raise DappleError(f"There is no object '{name}' in the file; check the name or pick another object.")
    if found.type == "EMPTY" and not serves(found):
        raise DappleError(f"Object '{name}' is an empty that shows no collection; pick a mesh, or let it show one.")
    if not serves(found):
        raise DappleError(f"Object '{name}' is a {found.type.lower()}, not a mesh; convert it (Object > Convert).")
    return found
