"""Attaching maps to materials: the light is right, nobody else's look changes, and detaching leaves no trace."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.attach import attach, detach, refresh  # noqa: E402
from dapple.operators.errors import DappleError  # noqa: E402
from dapple.operators.write import map_path, write_exr  # noqa: E402

RADIANCE = 0.5 / math.pi


@pytest.fixture(autouse=True)
def _scene(empty_scene):
    return empty_scene


@pytest.fixture
def out(tmp_path):
    """A folder that has maps of "Floor" and "Wall" for frames 3 to 5: the irradiance is the frame's number."""
    for name in ("Floor", "Wall"):
        for frame in (3, 4, 5):
            write_exr(map_path(tmp_path, name, frame), np.full((4, 4, 3), float(frame)))
    return tmp_path


def plane(name, material=None, height=0.0, size=4.0):
    mesh = bpy.data.meshes.new(name)
    s = size / 2
    mesh.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="Detail")
    layer = mesh.uv_layers.new(name="Bake")
    layer.data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    layer.active_render = True
    if material:
        mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    obj.location.z = height
    bpy.context.scene.collection.objects.link(obj)
    return obj


def principled(name="Stone", colour=(0.2, 0.4, 0.6, 1.0)):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    shader(material).inputs["Base Color"].default_value = colour
    return material


def shader(material):
    return next(n for n in material.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")


def surface_of(material):
    return material.node_tree.get_output_node("EEVEE").inputs["Surface"]


def textured():
    material = principled()
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("tiles", 8, 8)
    material.node_tree.links.new(texture.outputs["Color"], shader(material).inputs["Base Color"])
    return material


def glowing():
    material = principled()
    shader(material).inputs["Emission Color"].default_value = (1.0, 0.1, 0.0, 1.0)
    shader(material).inputs["Emission Strength"].default_value = 3.0
    return material


def mixed():
    """Half glossy, half a rerouted Diffuse."""
    material = principled()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mix, glossy = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeBsdfAnisotropic")
    diffuse, reroute = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("NodeReroute")
    diffuse.inputs["Color"].default_value = (0.2, 0.4, 0.6, 1.0)
    links.new(glossy.outputs[0], mix.inputs[1])
    links.new(diffuse.outputs[0], reroute.inputs[0])
    links.new(reroute.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], surface_of(material))
    return material


def without_surface():
    material = principled()
    material.node_tree.nodes.remove(shader(material))
    return material


def plain(value):
    """A value that can be compared after the data it came from has gone."""
    if isinstance(value, (bool, int, float, str, type(None))):
        return value
    if isinstance(value, bpy.types.ID):
        return value.name
    try:
        return tuple(plain(v) for v in value)
    except TypeError:
        return type(value).__name__


def dump(tree):
    """All nodes with their properties and values, and all links."""
    nodes = {
        node.name: (
            {
                p.identifier: plain(getattr(node, p.identifier))
                for p in node.bl_rna.properties
                if p.type != "COLLECTION"
            },
            [plain(getattr(s, "default_value", None)) for s in node.inputs],
            sorted(node.keys()),
        )
        for node in tree.nodes
    }
    links = {
        (k.from_node.name, k.from_socket.identifier, k.to_node.name, k.to_socket.identifier, k.is_muted)
        for k in tree.links
    }
    return nodes, links


def state():
    """What the file holds: materials with their nodes and properties, slots of objects and meshes, images."""
    return (
        {m.name: (dump(m.node_tree), sorted(m.keys()), m.use_transparent_shadow) for m in bpy.data.materials},
        {
            o.name: ([(s.link, plain(s.material)) for s in o.material_slots], sorted(o.keys()), o.visible_shadow)
            for o in bpy.data.objects
        },
        {m.name: [plain(x) for x in m.materials] for m in bpy.data.meshes},
        sorted(i.name for i in bpy.data.images),
    )


MATERIALS = [principled, textured, glowing, mixed, without_surface]


@pytest.mark.parametrize("make", MATERIALS)
def test_detach_restores_the_node_tree(make, out):
    plane("Floor", make())
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert state() != before
    assert detach(bpy.context, ["Floor"]) == ["Floor"]
    assert state() == before


@pytest.mark.parametrize("make", MATERIALS)
def test_attaching_twice_is_attaching_once(make, out):
    plane("Floor", make())
    attach(bpy.context, ["Floor"], out)
    once = state()
    attach(bpy.context, ["Floor"], out)
    assert state() == once


@pytest.mark.parametrize("make", [principled, textured, glowing, mixed])
def test_surface_is_kept_and_light_is_added(make, out):
    material = make()
    plane("Floor", material)
    kept = surface_of(material).links[0].from_socket
    attach(bpy.context, ["Floor"], out)
    total = surface_of(material).links[0].from_node
    assert total.bl_idname == "ShaderNodeAddShader"
    assert total.inputs[0].links[0].from_socket == kept
    emission = total.inputs[1].links[0].from_node
    assert emission.inputs["Strength"].default_value == pytest.approx(1 / math.pi)


@pytest.mark.parametrize("make", [principled, glowing, mixed])
def test_albedo_is_the_value_of_the_shader(make, out):
    material = make()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.2, 0.4, 0.6))


def test_metal_takes_no_light(out):
    material = principled()
    shader(material).inputs["Metallic"].default_value = 0.75
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    strength = material.node_tree.nodes["Dapple Light"].inputs["Strength"].default_value
    assert strength == pytest.approx(0.25 / math.pi)


def test_albedo_is_read_through_the_link_that_feeds_the_shader(out):
    material = textured()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert product.inputs[0].links[0].from_socket == shader(material).inputs["Base Color"].links[0].from_socket


def grouped(colour_inside):
    """A group that holds a Diffuse; its colour comes from the group's input, or from a texture inside."""
    group = bpy.data.node_groups.new("Tile", "ShaderNodeTree")
    group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    enter, leave = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    diffuse, texture = group.nodes.new("ShaderNodeBsdfDiffuse"), group.nodes.new("ShaderNodeTexChecker")
    group.links.new(texture.outputs[0] if colour_inside else enter.outputs["Tint"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], leave.inputs["Shader"])
    material = without_surface()
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Tint"].default_value = (0.7, 0.8, 0.9, 1.0)
    material.node_tree.links.new(node.outputs["Shader"], surface_of(material))
    return material


def test_albedo_is_found_through_a_node_group(out):
    material = grouped(colour_inside=False)
    plane("Floor", material)
    assert attach(bpy.context, ["Floor"], out) == []
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.7, 0.8, 0.9))


@pytest.mark.parametrize("make", [lambda: grouped(colour_inside=True), without_surface])
def test_white_stands_in_and_is_said_where_there_is_no_albedo(make, out):
    material = make()
    plane("Floor", material)
    notes = attach(bpy.context, ["Floor"], out)
    assert len(notes) == 1
    assert "'Floor'" in notes[0] and "white" in notes[0]
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == (1.0, 1.0, 1.0)


def test_material_that_others_show_is_not_touched(out):
    material = principled()
    floor, wall, ring = plane("Floor", material), plane("Wall", material), plane("Ring", material)
    tree = dump(material.node_tree)
    before = state()
    notes = attach(bpy.context, ["Floor", "Wall"], out)
    assert dump(material.node_tree) == tree
    assert ring.material_slots[0].material == material
    assert len({o.material_slots[0].material.name for o in (floor, wall, ring)}) == 3
    images = [o.material_slots[0].material.node_tree.nodes["Dapple Irradiance"].image.filepath for o in (floor, wall)]
    assert "Floor" in images[0] and "Wall" in images[1]
    assert len(notes) == 2
    detach(bpy.context)
    assert state() == before


def test_two_receivers_that_share_a_material_keep_it_alive(out):
    plane("Floor", principled()), plane("Wall", bpy.data.materials["Stone"])
    attach(bpy.context, ["Floor", "Wall"], out)
    bpy.data.orphans_purge()
    detach(bpy.context, ["Floor"])
    assert bpy.data.objects["Floor"].material_slots[0].material == bpy.data.materials["Stone"]
    assert "Dapple Irradiance" in bpy.data.objects["Wall"].material_slots[0].material.node_tree.nodes


def test_mesh_that_another_object_shows_is_not_touched(out):
    floor = plane("Floor", principled())
    twin = bpy.data.objects.new("Twin", floor.data)
    bpy.context.scene.collection.objects.link(twin)
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert twin.material_slots[0].material == bpy.data.materials["Stone"]
    assert floor.material_slots[0].link == "OBJECT"
    assert floor.material_slots[0].material != bpy.data.materials["Stone"]
    detach(bpy.context)
    assert state() == before


@pytest.mark.parametrize("link", ["DATA", "OBJECT"])
def test_empty_slot_gets_a_grey_material_for_a_while(link, out):
    floor = plane("Floor")
    floor.data.materials.append(None)
    floor.material_slots[0].link = link
    before = state()
    notes = attach(bpy.context, ["Floor"], out)
    assert "grey" in notes[0]
    product = floor.material_slots[0].material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.8, 0.8, 0.8))
    detach(bpy.context)
    assert state() == before


@pytest.mark.parametrize("shared", [False, True])
def test_object_without_slots_gets_one_for_a_while(shared, out):
    floor = plane("Floor")
    if shared:
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("Twin", floor.data))
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material
    assert not shared or bpy.data.objects["Twin"].material_slots[0].material is None
    detach(bpy.context)
    assert state() == before


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="every material has nodes from Blender 5.0 on")
def test_material_without_nodes_keeps_its_colour(out):
    material = bpy.data.materials.new("Paint")
    material.diffuse_color = (0.3, 0.2, 0.1, 1.0)
    floor = plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = floor.material_slots[0].material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.3, 0.2, 0.1))
    detach(bpy.context)
    assert floor.material_slots[0].material == material and not material.use_nodes


def test_linked_material_is_copied(out, tmp_path):
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {principled()})
    bpy.data.materials.remove(bpy.data.materials["Stone"])
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.materials = ["Stone"]
    floor = plane("Floor", wanted.materials[0])
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material.library is None
    detach(bpy.context)
    assert state() == before


def test_override_of_a_linked_object_shows_its_map(out, tmp_path):
    library = tmp_path / "library.blend"
    floor = plane("Floor", principled())
    bpy.data.libraries.write(str(library), {floor})
    bpy.data.batch_remove([floor, floor.data, bpy.data.materials["Stone"]])
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Floor"]
    linked = wanted.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    with pytest.raises(DappleError, match="library override"):
        attach(bpy.context, ["Floor"], out)
    floor = linked.override_create(remap_local_usages=True)
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert "Dapple Irradiance" in floor.material_slots[0].material.node_tree.nodes
    detach(bpy.context)
    assert state() == before


def test_material_of_a_modifier_is_said(out):
    floor, marble = plane("Floor", principled()), principled("Marble")
    group = bpy.data.node_groups.new("Set", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    enter, leave = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    node = group.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = marble
    group.links.new(enter.outputs[0], node.inputs["Geometry"])
    group.links.new(node.outputs[0], leave.inputs[0])
    floor.modifiers.new("Set", "NODES").node_group = group
    notes = attach(bpy.context, ["Floor"], out)
    assert len(notes) == 1 and "'Marble'" in notes[0]


def test_two_slots_of_one_material_are_one_edit(out):
    floor = plane("Floor", principled())
    floor.data.materials.append(bpy.data.materials["Stone"])
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material == floor.material_slots[1].material
    assert sum("dapple" in n for n in floor.material_slots[0].material.node_tree.nodes) == 6
    detach(bpy.context)
    assert state() == before


def test_a_copy_keeps_what_was_changed_in_it(out):
    floor, _ = plane("Floor", principled()), plane("Ring", bpy.data.materials["Stone"])
    attach(bpy.context, ["Floor"], out)
    copy = floor.material_slots[0].material
    shader(copy).inputs["Base Color"].default_value = (0.1, 0.1, 0.1, 1.0)
    assert attach(bpy.context, ["Floor"], out) == []
    assert floor.material_slots[0].material == copy
    product = copy.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.1, 0.1, 0.1))


def test_refresh_reads_new_maps_and_leaves_the_rest(out):
    material = principled()
    plane("Floor", material), plane("Wall", principled("Paint"))
    attach(bpy.context, ["Floor"], out)
    nodes = material.node_tree.nodes
    nodes["Dapple Light"].inputs["Strength"].default_value = 7.0
    write_exr(map_path(out, "Floor", 9), np.full((4, 4, 3), 9.0))
    refresh(["Floor", "Wall"], out)
    assert nodes["Dapple Irradiance"].image_user.frame_duration == 7
    assert nodes["Dapple Light"].inputs["Strength"].default_value == 7.0
    assert not any("dapple" in n for n in bpy.data.materials["Paint"].node_tree.nodes)
    assert [i.source for i in bpy.data.images] == ["SEQUENCE"]


def test_duplicate_of_a_receiver_gets_its_own_map(out):
    floor = plane("Floor", principled())
    attach(bpy.context, ["Floor"], out)
    wall = floor.copy()
    wall.name = "Wall"
    bpy.context.scene.collection.objects.link(wall)
    attach(bpy.context, ["Wall", "Floor"], out)
    for obj in (floor, wall):
        nodes = obj.material_slots[0].material.node_tree.nodes
        assert [n.image.name for n in nodes if n.type == "TEX_IMAGE"] == [f"Dapple {obj.name}"]
    detach(bpy.context)
    assert [m.name for m in bpy.data.materials] == ["Stone"]
    assert not any("dapple" in n for n in bpy.data.materials["Stone"].node_tree.nodes)


@pytest.mark.parametrize("make", [principled, lambda: None])
def test_duplicate_of_a_receiver_with_a_copy_goes_back_to_the_original(make, out):
    floor = plane("Floor", make())
    if not floor.material_slots:
        floor.data.materials.append(None)
    original = floor.material_slots[0].material
    plane("Ring", original)
    attach(bpy.context, ["Floor"], out)
    wall = floor.copy()
    wall.name, wall.data = "Wall", floor.data.copy()
    bpy.context.scene.collection.objects.link(wall)
    attach(bpy.context, ["Wall"], out)
    detach(bpy.context)
    assert floor.material_slots[0].material == wall.material_slots[0].material == original
    assert len(bpy.data.materials) == (1 if original else 0)


def test_map_is_a_linear_sequence_on_the_baked_uv_map(out):
    material = principled()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    nodes = material.node_tree.nodes
    texture = nodes["Dapple Irradiance"]
    assert texture.image.source == "SEQUENCE"
    assert texture.image.colorspace_settings.name == "Non-Color"
    assert texture.image_user.use_auto_refresh
    assert nodes["Dapple UV Map"].uv_map == "Bake"
    assert nodes["Dapple UV Map"].outputs["UV"] == texture.inputs["Vector"].links[0].from_socket


def test_maps_of_another_folder_take_the_place_of_the_first(out, tmp_path):
    plane("Floor", principled())
    attach(bpy.context, ["Floor"], out)
    write_exr(map_path(tmp_path / "second", "Floor", 8), np.ones((4, 4, 3)))
    attach(bpy.context, ["Floor"], tmp_path / "second")
    (image,) = bpy.data.images
    assert image.filepath == str(map_path(tmp_path / "second", "Floor", 8))
    assert image.source == "FILE"


def test_missing_frames_are_said(out):
    map_path(out, "Floor", 4).unlink()
    plane("Floor", principled())
    assert "1 frame(s) from 4" in attach(bpy.context, ["Floor"], out)[0]


@pytest.mark.parametrize("name", ["Roof", "Nothing"])
def test_nothing_changes_where_a_map_or_an_object_is_missing(name, out):
    plane("Floor", principled()), plane("Roof", principled())
    before = state()
    with pytest.raises(DappleError, match=name):
        attach(bpy.context, ["Floor", name], out)
    assert state() == before


def test_water_casts_a_whole_shadow_while_maps_are_attached(out):
    plane("Floor", principled())
    glass = principled("Glass")
    water = plane("Water", glass, height=1.0)
    glass.use_backface_culling_shadow = True
    water.visible_shadow = False
    before = state()
    for _ in range(2):
        attach(bpy.context, ["Floor"], out, ["Water"])
    assert water.visible_shadow
    assert not glass.use_transparent_shadow and not glass.use_backface_culling_shadow
    detach(bpy.context)
    assert state() == before
    assert glass.use_backface_culling_shadow


def test_sun_without_a_shadow_is_said(out):
    plane("Floor", principled()), plane("Water", height=1.0)
    sun(2.0).data.use_shadow = False
    notes = attach(bpy.context, ["Floor"], out, ["Water"])
    assert len(notes) == 1 and "'Sun'" in notes[0]


def sun(strength):
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy = strength
    obj = bpy.data.objects.new("Sun", lamp)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def look_at_the_floor(scene):
    """An orthographic camera under the water, and a render without samples, world or display transform to speak of."""
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 1.0
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location.z = 0.5
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    scene.eevee.taa_render_samples = 8
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"


def radiance(scene, path):
    """Render and return the mean of all pixels."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(16 * 16 * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)[:, :3].mean()


def diffuse():
    material = without_surface()
    node = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    material.node_tree.links.new(node.outputs[0], surface_of(material))
    return material


def test_eevee_shows_the_map_in_watts_and_the_sun_not_twice(out, tmp_path):
    """A floor of albedo 0.5 under E W/m^2 has a radiance of 0.5 / pi E, be it from a bare Sun or from the map."""
    scene = bpy.context.scene
    plane("Floor", diffuse())
    sun(3.0)
    look_at_the_floor(scene)
    picture = tmp_path / "view.exr"
    bare = radiance(scene, picture)
    assert bare == pytest.approx(3.0 * RADIANCE, rel=0.01)

    glass = principled("Glass")
    shader(glass).inputs["Alpha"].default_value = 0.1
    plane("Water", glass, height=1.0, size=6.0)
    attach(bpy.context, ["Floor"], out, ["Water"])
    # Before the range and after it the sequence repeats.
    for frame, value in ((3, 3.0), (5, 5.0), (2, 5.0), (6, 3.0)):
        scene.frame_set(frame)
        assert radiance(scene, picture) == pytest.approx(value * RADIANCE, rel=0.01)

    for frame in (3, 4, 5):
        write_exr(map_path(out, "Floor", frame), np.zeros((4, 4, 3)))
    refresh(["Floor"], out)
    assert radiance(scene, picture) < 0.005 * bare
