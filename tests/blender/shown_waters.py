"""Waters that are shown by instances, or come from another file; builders as in `waters`."""

import bpy
import numpy as np

from dapple.operators.read.find import name_of
from dapple.tests.blender.waters import HEIGHT, SIZE, rippling, surface


def _in_collection(water):
    """A collection, not part of the scene, that holds a surface."""
    ponds = bpy.data.collections.new("Ponds")
    ponds.objects.link(water)
    return ponds


def _show(scene, collection, name):
    """An Empty that shows a collection."""
    empty = bpy.data.objects.new(name, None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    scene.collection.objects.link(empty)
    return empty


def collection_instance(scene, _folder):
    """The surface is in no collection of the scene; an Empty shows it, turned and mirrored, and is picked."""
    empty = _show(scene, _in_collection(rippling(surface("Pond", link=False))), "Water")
    empty.scale.x = -1
    empty.rotation_euler.z = 0.5 * np.pi
    return (empty.name,)


def surface_behind_an_instance(scene, _folder):
    """As `collection_instance`, but the surface itself is picked."""
    pond = rippling(surface("Pond", link=False))
    _show(scene, _in_collection(pond), "Place")
    return (pond.name,)


def several_instances(scene, _folder):
    """Four Empties that show the same surface side by side, half as large; all are picked."""
    ponds = _in_collection(rippling(surface("Pond", link=False, height=0.0)))
    names = []
    for k, (x, y) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        empty = _show(scene, ponds, f"Water {k}")
        empty.location, empty.scale = (x * SIZE / 4, y * SIZE / 4, HEIGHT), (0.5, 0.5, 0.5)
        names.append(empty.name)
    return tuple(names)


def nested_instances(scene, folder):
    """An Empty that shows a collection with an Empty that shows the surface."""
    inner = bpy.data.objects.new("Inner", None)
    inner.instance_type = "COLLECTION"
    inner.instance_collection = _in_collection(rippling(surface("Pond", link=False)))
    outer = bpy.data.collections.new("Outer")
    outer.objects.link(inner)
    return (_show(scene, outer, "Water").name,)


def _library(folder, make):
    """Write what `make` makes to a file of its own, take it out of this one; returns the path."""
    kept = make()
    path = str(folder / "library.blend")
    bpy.data.libraries.write(path, {kept}, fake_user=True)
    for thing in [*bpy.data.objects]:
        if thing.name.startswith("Pond"):
            bpy.data.objects.remove(thing)
    for collection in [*bpy.data.collections]:
        if collection.name.startswith("Ponds"):
            bpy.data.collections.remove(collection)
    return path


def _link_ponds(folder):
    """The collection of a library with a surface, linked."""
    path = _library(folder, lambda: _in_collection(rippling(surface("Pond", link=False))))
    with bpy.data.libraries.load(path, link=True) as (_, to):
        to.collections = ["Ponds"]
    return to.collections[0]


def linked_collection_instance(scene, folder):
    return (_show(scene, _link_ponds(folder), "Water").name,)


def linked_object(scene, folder):
    """An object of a library that the scene holds itself, beside a local one of the same name elsewhere."""
    pond = _link_ponds(folder).objects[0]
    scene.collection.objects.link(pond)
    scene.collection.objects.link(bpy.data.objects.new(pond.name, None))
    return (name_of(pond),)


def library_override(scene, folder):
    """A library override: an object of this file by the name of the linked one."""
    ponds = _link_ponds(folder)
    scene.collection.children.link(ponds)
    own = ponds.override_hierarchy_create(scene, bpy.context.view_layer)
    scene.collection.children.unlink(ponds)
    return (name_of(own.objects[0]),)


def linked_mesh(scene, folder):
    """A local object with the mesh of a library."""
    mesh = _link_ponds(folder).objects[0].data
    water = bpy.data.objects.new("Water", mesh)
    water.location.z = HEIGHT
    scene.collection.objects.link(water)
    return (rippling(water).name,)
