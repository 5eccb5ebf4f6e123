"""What water or glass absorbs, per metre and channel: read from the volume of its material.

As Cycles 5.0 takes the nodes, measured through a slab: Volume Absorption sigma_a = density (1 - colour); Principled
Volume density (1 - colour) (1 - sqrt(absorption colour)), the rest of its density scatters.
"""

from __future__ import annotations

import numpy as np

from .shader_nodes import Sockets, materials_of, output_socket, shaders

_VOLUMES = {"VOLUME_ABSORPTION", "VOLUME_SCATTER", "VOLUME_COEFFICIENTS", "PRINCIPLED_VOLUME"}


def read_sigma_a(water):
    """(sigma_a (3,) [1/m], warnings) of an evaluated object: those of all volume nodes that feed the active output of
    its first material with a volume, added, as mixed; 0 where there is none.

    Sockets that nodes compute count with the values set in them, and light that is scattered is taken as it was going,
    with a warning for either.
    """
    for material in materials_of(water):
        found = _volumes(material)
        if found:
            return _sum(found, material.name)
    return np.zeros(3), []


def material_sigma_a(material):
    """(sigma_a (3,) [1/m], warnings) of a material, as `read_sigma_a` has them of an object's first with a volume."""
    found = _volumes(material)
    return _sum(found, material.name) if found else (np.zeros(3), [])


def _volumes(material):
    """The volume nodes of a material, as `shader_nodes.shaders` yields them."""
    socket = output_socket(material, "Volume")
    return list(shaders(socket, _VOLUMES)) if socket else []


def _sum(found, material):
    """(sigma_a (3,), warnings) of (node, groups, share) in a material."""
    total, doubts, scatters = np.zeros(3), False, False
    for node, groups, share in found:
        read = Sockets(node, groups)
        sigma_a, scattered = _coefficients(node.type, read)
        total += share * sigma_a
        doubts, scatters = doubts or read.computed, scatters or bool(np.any(scattered))
    warnings = []
    if doubts:
        warnings.append(f"The volume of material '{material}' is fed by nodes; the bake takes the sockets' own values.")
    if scatters:
        warnings.append(f"The volume of material '{material}' scatters light; the bake takes what it absorbs only.")
    return np.array([float(f"{s:.6g}") for s in np.maximum(total, 0)]), warnings  # Blender keeps them in float32


def _coefficients(kind, read):
    """sigma_a and what is scattered, (3,) [1/m] both, of a node."""
    if kind == "VOLUME_COEFFICIENTS":
        return read("Absorption Coefficients"), read("Scatter Coefficients")
    density, colour = max(read("Density"), 0.0), np.clip(read("Color"), 0, 1)
    if kind == "VOLUME_ABSORPTION":
        return density * (1 - colour), np.zeros(3)
    if kind == "VOLUME_SCATTER":
        return np.zeros(3), density * colour
    tint = np.sqrt(np.clip(read("Absorption Color"), 0, 1))
    return density * (1 - colour) * (1 - tint), density * colour
