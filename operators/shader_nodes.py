"""What an artist set in a material's nodes: a walk back from its output, and the values of sockets."""

from __future__ import annotations

import bpy


def output_socket(material, name):
    """The socket `name` of a material's active output, None where it has no nodes or no output."""
    if material is None or not _has_nodes(material):
        return None
    tree = material.node_tree
    output = tree.get_output_node("EEVEE") or tree.get_output_node("CYCLES")
    return output.inputs[name] if output else None


def _has_nodes(material):
    """Whether nodes make the material; since Blender 5.0 they always do, and to ask is deprecated."""
    return material.node_tree is not None and (bpy.app.version >= (5, 0, 0) or material.use_nodes)


def shaders(socket, kinds, groups=(), share=1.0):
    """Walk back from a shader socket: yields (node of one of `kinds`, groups entered, its share in Mix Shaders),
    nearest the output first."""
    for link in _links(socket):
        node, identifier, inside = link.from_node, link.from_socket.identifier, groups
        if node.type in kinds:
            yield node, groups, share
            continue
        if node.type == "GROUP" and node.node_tree:
            outputs = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            sockets, inside = [s for n in outputs for s in _same(n.inputs, identifier)], (*groups, node)
        elif node.type == "GROUP_INPUT" and groups:
            sockets, inside = _same(groups[-1].inputs, identifier), groups[:-1]
        else:
            sockets = [s for s in node.inputs if s.type == "SHADER" or node.type == "REROUTE"]
        shares = [share] * len(sockets)
        if node.type == "MIX_SHADER":
            mixed = value(node.inputs[0], groups)
            mixed = float(node.inputs[0].default_value if mixed is None else mixed)
            shares = [share * (1 - mixed), share * mixed]
        for source, own in zip(sockets, shares):
            yield from shaders(source, kinds, inside, own)


def value(socket, groups):
    """What a socket is set to, by its own field, a Value or RGB node or a group input; None where nodes compute it."""
    links = _links(socket)
    if not links:
        return socket.default_value
    node = links[0].from_node
    if node.type in ("VALUE", "RGB"):
        return node.outputs[0].default_value
    if node.type == "REROUTE" and _links(node.inputs[0]):
        return value(node.inputs[0], groups)
    if node.type == "GROUP_INPUT" and groups:
        outer = _same(groups[-1].inputs, links[0].from_socket.identifier)
        return value(outer[0], groups[:-1]) if outer else None
    return None


def _links(socket):
    """The links that feed a socket, without muted ones and those that close a circle."""
    return [link for link in socket.links if link.is_valid and not link.is_muted]


def _same(sockets, identifier):
    """The socket on the other side of a group's boundary."""
    return [socket for socket in sockets if socket.identifier == identifier]
