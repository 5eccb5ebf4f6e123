"""What an artist set in a material's nodes: a walk back from its output, and the values of sockets."""

from __future__ import annotations

import bpy
import numpy as np

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # how Blender makes a colour that feeds a value one number


def materials_of(shown):
    """The materials of an evaluated object, by the index that its faces hold: those of its mesh, as modifiers leave
    them, but where a slot is the object's own."""
    slots = shown.material_slots
    return [
        slots[i].material if i < len(slots) and slots[i].link == "OBJECT" else material
        for i, material in enumerate(shown.data.materials)
    ]


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
    nearest the output first. A muted node is passed by as Blender does, or is none.
    """
    for link in _links(socket):
        node, identifier, inside = link.from_node, link.from_socket.identifier, groups
        if node.mute:
            for source in _passed_on(link):
                yield from shaders(source, kinds, groups, share)
            continue
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
            shares = [share * part for part in _mixed(node, groups)]
        for source, own in zip(sockets, shares):
            yield from shaders(source, kinds, inside, own)


def value(socket, groups):
    """What a socket is set to, by its own field, a Value or RGB node or a group input; None where nodes compute it."""
    links = _links(socket)
    if not links:
        return socket.default_value
    node = links[0].from_node
    if node.mute:
        sources = _passed_on(links[0])
        return value(sources[0], groups) if sources else None
    if node.type in ("VALUE", "RGB"):
        return node.outputs[0].default_value
    if node.type == "REROUTE" and _links(node.inputs[0]):
        return value(node.inputs[0], groups)
    if node.type == "GROUP_INPUT" and groups:
        outer = _same(groups[-1].inputs, links[0].from_socket.identifier)
        return value(outer[0], groups[:-1]) if outer else None
    return None


class Sockets:
    """Values of a node's sockets by name, (3,) of colours and vectors, with the values set in those that nodes compute;
    `computed` says whether one that was asked for is such."""

    def __init__(self, node, groups):
        self._node, self._groups, self.computed = node, groups, False

    def __call__(self, name):
        socket = self._node.inputs[name]
        found = value(socket, self._groups)
        self.computed |= found is None
        found = np.ravel(socket.default_value if found is None else found)[:3].astype(np.float64)
        if socket.type in ("VALUE", "BOOLEAN", "INT"):
            return float(found[0] if len(found) == 1 else found @ _LUMINANCE)
        return found if len(found) == 3 else np.full(3, found[0])

    def __contains__(self, name):
        return name in self._node.inputs

    def linked(self, name):
        """Whether something feeds the socket."""
        return bool(_links(self._node.inputs[name]))


def _mixed(node, groups):
    """Shares of the two shaders of a Mix Shader.

    A mix by what kind of ray it is counts as for none of those that Light Path names, the ways of light being traced;
    one by Fresnel or Layer Weight as for light along the normal. It takes nothing from the first: what glass reflects
    is taken from it where light meets it, and not twice.
    """
    by = {link.from_node.type: link for link in _links(node.inputs[0]) if not link.from_node.mute}
    if "LIGHT_PATH" in by:
        return 1.0, 0.0
    for kind in _ALONG_THE_NORMAL.keys() & by.keys():
        return 1.0, _ALONG_THE_NORMAL[kind](by[kind], groups)
    second = min(max(Sockets(node, groups)(0), 0.0), 1.0)
    return 1 - second, second


def _fresnel(link, groups):
    return _reflected(Sockets(link.from_node, groups)("IOR"))


def _layer_weight(link, groups):
    if link.from_socket.identifier != "Fresnel":
        return 0.0  # Facing
    return _reflected(1 / max(1 - Sockets(link.from_node, groups)("Blend"), 1e-5))


def _reflected(eta):
    return ((eta - 1) / (eta + 1)) ** 2


_ALONG_THE_NORMAL = {"FRESNEL": _fresnel, "LAYER_WEIGHT": _layer_weight}


def _passed_on(link):
    """The inputs that a muted node hands on to a link."""
    return [inner.from_socket for inner in link.from_node.internal_links if inner.to_socket == link.from_socket]


def _links(socket):
    """The links that feed a socket, without muted ones and those that close a circle."""
    return [link for link in socket.links if link.is_valid and not link.is_muted]


def _same(sockets, identifier):
    """The socket on the other side of a group's boundary."""
    return [socket for socket in sockets if socket.identifier == identifier]
