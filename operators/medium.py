"""The index of refraction that an artist gave the water: read from its material."""

from __future__ import annotations

import bpy

from ..kernels.scene import WATER_IOR
from .errors import DappleError

_REFRACTING = {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_PRINCIPLED"}
_LEAST, _MOST = 1.0001, 4.0
_NOT_WATER = 0.05


def read_eta(water):
    """(eta, warnings) of an evaluated object: the IOR of the first Principled, Glass or Refraction node that feeds its
    active material output; 1.333 where there is none.

    An IOR socket that something else than a Value node feeds counts with the number typed into it, with a warning.
    Raises DappleError for an IOR outside 1.0001..4.
    """
    for slot in water.material_slots:
        node, groups = _first_shader(slot.material)
        if node is None:
            continue
        number = _number(node.inputs["IOR"], groups)
        eta = float(node.inputs["IOR"].default_value) if number is None else number
        eta = float(f"{eta:.6g}")  # Blender keeps it in float32, where 1.333 is 1.33299994
        _check(eta, water.name, slot.material.name)
        return eta, _remarks(eta, number is not None, water.name, slot.material.name)
    return WATER_IOR, []


def _check(eta, water, material):
    """Raise DappleError for an eta that bends nothing, or bends as no transparent matter does."""
    if not _LEAST <= eta <= _MOST:
        raise DappleError(
            f"Water '{water}' has IOR {eta:.4g} in its material '{material}'; "
            f"set it between {_LEAST} and {_MOST:g} (water: {WATER_IOR})."
        )


def _remarks(eta, known, water, material):
    """Warnings on an eta that may not be what the artist meant."""
    remarks = []
    if not known:
        remarks.append(f"The IOR of material '{material}' is fed by nodes; the bake takes the socket's own {eta:.4g}.")
    if abs(eta - WATER_IOR) > _NOT_WATER:
        remarks.append(f"Water '{water}' bends light with IOR {eta:.4g} of material '{material}'; water's is 1.333.")
    return remarks


def _first_shader(material):
    """(node, groups entered to get to it) or (None, ())."""
    if material is None or not _has_nodes(material):
        return None, ()
    tree = material.node_tree
    output = tree.get_output_node("EEVEE") or tree.get_output_node("CYCLES")
    return next(_shaders(output.inputs["Surface"], ()), (None, ())) if output else (None, ())


def _has_nodes(material):
    """Whether nodes make the material; since Blender 5.0 they always do, and to ask is deprecated."""
    return material.node_tree is not None and (bpy.app.version >= (5, 0, 0) or material.use_nodes)


def _links(socket):
    """The links that feed a socket, without muted ones and those that close a circle."""
    return [link for link in socket.links if link.is_valid and not link.is_muted]


def _same(sockets, identifier):
    """The socket on the other side of a group's boundary."""
    return [socket for socket in sockets if socket.identifier == identifier]


def _shaders(socket, groups):
    """Walk back from a shader socket: yields (refracting node, groups entered), nearest the output first."""
    for link in _links(socket):
        node, identifier, inside = link.from_node, link.from_socket.identifier, groups
        if node.type in _REFRACTING:
            yield node, groups
            continue
        if node.type == "GROUP" and node.node_tree:
            outputs = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            sockets, inside = [s for n in outputs for s in _same(n.inputs, identifier)], (*groups, node)
        elif node.type == "GROUP_INPUT" and groups:
            sockets, inside = _same(groups[-1].inputs, identifier), groups[:-1]
        else:
            sockets = [s for s in node.inputs if s.type == "SHADER" or node.type == "REROUTE"]
        for source in sockets:
            yield from _shaders(source, inside)


def _number(socket, groups):
    """What a float socket is set to, by its own field, a Value node or a group's input; None where nodes compute it."""
    links = _links(socket)
    if not links:
        return float(socket.default_value)
    node = links[0].from_node
    if node.type == "VALUE":
        return float(node.outputs[0].default_value)
    if node.type == "REROUTE" and _links(node.inputs[0]):
        return _number(node.inputs[0], groups)
    if node.type == "GROUP_INPUT" and groups:
        outer = _same(groups[-1].inputs, links[0].from_socket.identifier)
        return _number(outer[0], groups[:-1]) if outer else None
    return None
