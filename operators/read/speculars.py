"""What of a material bends light or mirrors it: the Glass or Mirror of `kernels.scene` that its nodes make.

Colours multiply as in Cycles 5.0, measured on a plane of each: Principled transmission by the root of its base colour,
so that a body shows the colour itself, Glass by its colour, refracted and reflected light alike, metals by the colour
along the normal and 1 at grazing incidence, Glossy by its colour everywhere. Refraction, which reflects nothing, loses
Fresnel's share here, and not in Cycles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...kernels.casters import Glass, Mirror
from .absorption import material_sigma_a
from .shader_nodes import Sockets, output_socket, shaders

# Microfacets of roughness r lean by some r^2 rad: up to here a caustic blurs by little more than by the sun's disc.
MOST_ROUGHNESS = 0.1
_LEAST_SHARE = 0.05  # of a material's light, by which it is worth following
_LEAST_IOR, _MOST_IOR = 1.0, 4.0
_NODES = {"BSDF_PRINCIPLED", "BSDF_GLASS", "BSDF_REFRACTION", "BSDF_GLOSSY", "BSDF_METALLIC"}


_THIN = "Material '{}' is a thin wall, which bends nothing; it casts no caustics and blocks the light."
_LAYERS = ("Coat Weight", "Thin Film Thickness")  # over glass or metal, and left out


@dataclass(frozen=True)
class Specular:
    """material: a Glass or Mirror; roughness as the artist set it; warnings: where it is not what the nodes say; wrong:
    why it cannot be used at all, empty if it can."""

    material: Glass | Mirror
    roughness: float
    warnings: tuple[str, ...] = ()
    wrong: str = ""

    @property
    def word(self):
        return "glass" if isinstance(self.material, Glass) else "a mirror"


@dataclass(frozen=True)
class _Part:
    """A shader's share in a material, of one kind, with the light that it lets through or reflects; warnings and wrong
    as of a Specular, still without the material's name."""

    share: float
    material: Glass | Mirror
    roughness: float
    warnings: tuple[str, ...]
    wrong: str = ""


def read_specular(material, ior=0.0, abbe=0.0) -> Specular | None:
    """The Specular of an evaluated material: of the shaders that feed its active output that with the largest share,
    its colours times that share; None where none has a share that matters. ior and abbe: index and Abbe number of
    glass in place of those of the material, where they are not 0."""
    socket = output_socket(material, "Surface")
    nodes = shaders(socket, _NODES) if socket else ()
    parts = [part for node, groups, share in nodes for part in _PARTS[node.type](Sockets(node, groups), node, share)]
    parts = [part for part in parts if part.share >= _LEAST_SHARE]
    if not parts:
        return None
    most = max(parts, key=lambda part: part.share)
    found = Specular(_dimmed(most.material, most.share), float(f"{most.roughness:.6g}"))  # 0.1 as it was typed
    if isinstance(found.material, Mirror):
        sigma_a, remarks = np.zeros(3), []
    else:
        sigma_a, remarks = material_sigma_a(material)
        glass = replace(found.material, sigma_a=sigma_a, eta=ior or found.material.eta, abbe=abbe)
        found = replace(found, material=glass, wrong=most.wrong or _wrong(glass))
    said = [sentence.format(material.name) for sentence in most.warnings]
    if most.share < 1 - 1e-6:
        said.append(
            f"Material '{material.name}' is {found.word} by {most.share:.0%}: caustics are of that part, and the rest "
            "lets no light through."
        )
    return replace(found, warnings=(*said, *remarks), wrong=found.wrong.format(material.name))


def _wrong(glass):
    """Why a Glass cannot be baked, as a sentence; empty if it can."""
    if not _LEAST_IOR <= glass.eta <= _MOST_IOR:
        return (
            f"Material '{{}}' has IOR {glass.eta:.4g} and casts no caustics; set it between {_LEAST_IOR:g} and "
            f"{_MOST_IOR:g}, that of the matter itself, in water too."
        )
    if glass.abbe and not glass.abbe >= 1:
        return f"Glass of material '{{}}' is given the impossible Abbe number {glass.abbe:.4g}; set 0 or 1 and more."
    return ""


def _principled(read, node, share):
    """Metal, and of what is left of it glass; Alpha cuts a share out of both."""
    thin = "Thin Wall" in read and read("Thin Wall")  # since Blender 5.2
    share *= min(max(read("Alpha"), 0.0), 1.0)
    metal, glass = (min(max(read(name), 0.0), 1.0) for name in ("Metallic", "Transmission Weight"))
    roughness, colour, tint = read("Roughness"), _colour(read, "Base Color"), _colour(read, "Specular Tint")
    yield _Part(share * metal, Mirror(colour, np.ones(3)), roughness, _doubts(read) + _edge(tint))
    body = Glass(_index(read), reflects=tint, transmits=np.sqrt(colour))
    yield _Part(share * (1 - metal) * glass, body, roughness, _doubts(read), _THIN if thin else "")


def _glass(read, node, share):
    colour = _colour(read, "Color")
    yield _Part(share, Glass(_index(read), reflects=colour, transmits=colour), read("Roughness"), _doubts(read))


def _refraction(read, node, share):
    body = Glass(_index(read), reflects=np.zeros(3), transmits=_colour(read, "Color"))
    yield _Part(share, body, read("Roughness"), _doubts(read))


def _glossy(read, node, share):
    colour = _colour(read, "Color")
    yield _Part(share, Mirror(colour, colour), read("Roughness"), _doubts(read))


def _metallic(read, node, share):
    if node.fresnel_type == "PHYSICAL_CONDUCTOR":
        n, k = read("IOR"), read("Extinction")
        colour, edge = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2), ()
    else:
        colour, edge = _colour(read, "Base Color"), _edge(_colour(read, "Edge Tint"))
    yield _Part(share, Mirror(colour, np.ones(3)), read("Roughness"), _doubts(read) + edge)


_PARTS = {
    "BSDF_PRINCIPLED": _principled,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _refraction,
    "BSDF_GLOSSY": _glossy,
    "BSDF_METALLIC": _metallic,
}


def _colour(read, name):
    return np.array([float(f"{c:.6g}") for c in np.clip(read(name), 0, 1)])  # Blender keeps them in float32


def _index(read):
    return float(f"{read('IOR'):.6g}")


def _doubts(read):
    """Warnings, still without the material's name, on sockets that hold more than a value."""
    said = ()
    if read.computed:
        said += ("Material '{}' is fed by nodes; its caustics take the values set in the sockets themselves.",)
    if any(name in read and read(name) > 0 for name in _LAYERS):
        said += ("The coat or thin film of material '{}' is left out of its caustics.",)
    if read.linked("Normal"):
        said += ("Material '{}' has a bump or normal map; its caustics are those of the mesh alone.",)
    return said


def _edge(tint):
    """A warning on a metal whose reflection dips before it rises to 1: by less than 0.04 up to 60 degrees."""
    if (tint == 1).all():
        return ()
    return ("The edge tint of material '{}' is left out: its caustics are too bright where light grazes it.",)


def _dimmed(material, share):
    """A Glass or Mirror of which a share covers the surface."""
    if isinstance(material, Glass):
        return replace(material, reflects=share * material.reflects, transmits=share * material.transmits)
    return replace(material, f0=share * material.f0, f90=share * material.f90)
