"""The nodes that show a map in a material: emission of albedo / pi x E, added to the surface that is there.

A diffuse surface of albedo a under the irradiance E [W/m^2] sends a E / pi [W/m^2/sr] everywhere; an Emission node of
strength 1 sends its colour in the same unit. Every node of ours carries the tag TAG, so that `strip` finds these only.
"""

from __future__ import annotations

import math

import bpy

from .map_nodes import TAG, Sequence, map_socket, new

# The input that holds the albedo, of the shaders that scatter light diffusely.
ALBEDO_INPUTS = {
    "ShaderNodeBsdfPrincipled": "Base Color",
    "ShaderNodeEeveeSpecular": "Base Color",
    "ShaderNodeBsdfDiffuse": "Color",
    "ShaderNodeBsdfToon": "Color",
    "ShaderNodeBsdfSheen": "Color",
    "ShaderNodeBsdfTranslucent": "Color",
    "ShaderNodeSubsurfaceScattering": "Color",
}


def add(tree: bpy.types.NodeTree, sequences: tuple[Sequence, ...], uv_map: str) -> bool:
    """Add the light of `sequences`, one or one for each UDIM tile, to the surface of `tree`, for EEVEE and for Cycles
    where each has an output of its own; False if an albedo was not found and white stands in."""
    outputs = dict.fromkeys(filter(None, (tree.get_output_node(engine) for engine in ("EEVEE", "CYCLES"))))
    outputs = outputs or {new(tree, "ShaderNodeOutputMaterial", None, (0, 0), "Output"): None}
    found = [_add(tree, output, sequences, uv_map) for output in outputs]
    return all(found)


def _add(tree, output, sequences, uv_map):
    """Add the light to what one output shows; whether its albedo was found."""
    frame = tree.nodes.new("NodeFrame")
    frame.name, frame.label, frame[TAG] = "Dapple", "Dapple", True
    x, y = output.location
    surface = output.inputs["Surface"]
    shader, groups = find_diffuse(surface) or (None, ())
    albedo = _resolve(shader.inputs[ALBEDO_INPUTS[shader.bl_idname]], groups) if shader else None
    emission = new(tree, "ShaderNodeEmission", frame, (x - 200, y - 300), "Light")
    emission.inputs["Strength"].default_value = _diffuse_share(shader) / math.pi
    product = new(tree, "ShaderNodeVectorMath", frame, (x - 400, y - 300), "Albedo x Irradiance")
    product.operation = "MULTIPLY"
    _feed(tree, albedo, product.inputs[0])
    tree.links.new(map_socket(tree, sequences, uv_map, frame, (x - 700, y - 300)), product.inputs[1])
    tree.links.new(product.outputs[0], emission.inputs["Color"])
    _add_to_surface(tree, emission, surface, frame, (x, y - 300))
    return albedo is not None


def strip(tree: bpy.types.NodeTree) -> bool:
    """Remove what `add` added and give the surface its former link back; False if there was nothing of ours."""
    ours = [node for node in tree.nodes if TAG in node]
    for node in ours:
        if node.bl_idname == "ShaderNodeAddShader" and node.inputs[0].links:
            source = node.inputs[0].links[0].from_socket
            for target in [link.to_socket for link in node.outputs[0].links]:
                tree.links.new(source, target)
    # Children before their frame: a node of a removed frame is moved.
    for node in sorted(ours, key=lambda node: node.type == "FRAME"):
        tree.nodes.remove(node)
    return bool(ours)


def find_diffuse(surface: bpy.types.NodeSocket, groups: tuple = ()) -> tuple[bpy.types.Node, tuple] | None:
    """Find the first diffuse shader that feeds `surface`, an input socket inside the nested group nodes `groups`.

    Returns the shader's node and the group nodes that it is in, outermost first; None if there is no such shader.
    """
    source = _source(surface)
    if source is None:
        return None
    node = source.node
    if node.bl_idname in ALBEDO_INPUTS:
        return node, groups
    if node.type == "GROUP":
        return find_diffuse(_twin(_group_output(node), source), (*groups, node)) if _group_output(node) else None
    if node.type == "GROUP_INPUT":
        return find_diffuse(_twin(groups[-1], source), groups[:-1])
    shaders = (find_diffuse(socket, groups) for socket in node.inputs if socket.type == "SHADER")
    return next((found for found in shaders if found), None)


def _diffuse_share(shader):
    """How much of a shader is diffuse: neither metal nor glass. A share that a texture gives is taken as 1."""
    share = 1.0
    for name in ("Metallic", "Transmission Weight"):
        socket = shader.inputs.get(name) if shader else None
        if socket and _source(socket) is None:
            share *= 1.0 - socket.default_value
    return share


def _resolve(socket, groups):
    """Follow a colour input to an output socket of the outermost tree or to its value; None if inside a group."""
    source = _source(socket)
    if source is None:
        return tuple(socket.default_value)[:3]
    if not groups:
        return source
    if source.node.type == "GROUP_INPUT":
        return _resolve(_twin(groups[-1], source), groups[:-1])
    return None


def _source(socket):
    """Return the output socket that feeds an input socket, reroutes left out; None if nothing does."""
    for link in socket.links:
        if link.is_muted or not link.is_valid:
            continue
        return _source(link.from_node.inputs[0]) if link.from_node.type == "REROUTE" else link.from_socket
    return None


def _group_output(group):
    nodes = group.node_tree.nodes if group.node_tree else ()
    return next((node for node in nodes if node.type == "GROUP_OUTPUT" and node.is_active_output), None)


def _twin(node, socket):
    """Return the input of `node` that stands for the same interface socket."""
    return next(twin for twin in node.inputs if twin.identifier == socket.identifier)


def _feed(tree, albedo, target):
    if isinstance(albedo, bpy.types.NodeSocket):
        tree.links.new(albedo, target)
    else:
        target.default_value = albedo or (1.0, 1.0, 1.0)


def _add_to_surface(tree, emission, surface, frame, location):
    """Put emission + what feeds `surface` in its place."""
    total = new(tree, "ShaderNodeAddShader", frame, location, "Add")
    if surface.links:
        tree.links.new(surface.links[0].from_socket, total.inputs[0])
    tree.links.new(emission.outputs[0], total.inputs[1])
    tree.links.new(total.outputs[0], surface)
