"""The index of refraction that an artist gave the water: read from its material."""

from __future__ import annotations

from ...kernels.scene import WATER_IOR
from ..errors import DappleError
from .shader_nodes import materials_of, output_socket, shaders, value

_REFRACTING = {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_PRINCIPLED"}
_LEAST, _MOST = 1.0001, 4.0
_NOT_WATER = 0.05


def read_eta(water):
    """(eta, warnings) of an evaluated object: the IOR of the first Principled, Glass or Refraction node that feeds its
    active material output; 1.333 where there is none.

    An IOR socket that something else than a Value node feeds counts with the number typed into it, with a warning.
    Raises DappleError for an IOR outside 1.0001..4.
    """
    for material in materials_of(water):
        socket = output_socket(material, "Surface")
        node, groups, _ = next(shaders(socket, _REFRACTING), (None, (), 0)) if socket else (None, (), 0)
        if node is None:
            continue
        number = value(node.inputs["IOR"], groups)
        eta = float(node.inputs["IOR"].default_value if number is None else number)
        eta = float(f"{eta:.6g}")  # Blender keeps it in float32, where 1.333 is 1.33299994
        _check(eta, water.name, material.name)
        return eta, _remarks(eta, number is not None, water.name, material.name)
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
