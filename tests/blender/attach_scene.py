"""Receivers and materials to attach maps to, and all that a file holds of them, to be compared."""

import bpy


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


def two_outputs():
    """EEVEE shows a Principled of the usual colour, Cycles a Diffuse of another, each by an output of its own."""
    material = principled()
    nodes, links = material.node_tree.nodes, material.node_tree.links
    material.node_tree.get_output_node("EEVEE").target = "EEVEE"
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    output.target = "CYCLES"
    diffuse.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def without_surface():
    material = principled()
    material.node_tree.nodes.remove(shader(material))
    return material


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


def _custom(thing):
    """The names of its custom properties; up to Blender 4.5 what add-ons register is among them once it was read."""
    return sorted(set(thing.keys()) - {"dapple"})


def state():
    """What the file holds: materials with their nodes and properties, slots of objects and meshes, images."""
    return (
        {m.name: (dump(m.node_tree), _custom(m), m.use_transparent_shadow) for m in bpy.data.materials},
        {
            o.name: (
                [(s.link, plain(s.material)) for s in o.material_slots],
                _custom(o),
                o.visible_shadow,
                o.visible_diffuse,
            )
            for o in bpy.data.objects
        },
        {m.name: [plain(x) for x in m.materials] for m in bpy.data.meshes},
        sorted(i.name for i in bpy.data.images),
    )
