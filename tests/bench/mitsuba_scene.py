"""A Scene of the kernels as a scene of Mitsuba 3: the same triangles and shading normals, its own optics.

Receivers are white diffuse surfaces, occluders black ones, the water and glass smooth dielectrics, with homogeneous
media that only absorb; mirrors have a BSDF of their own, since Mitsuba has none with Schlick's curve.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from dapple.kernels.casters import Glass
from dapple.kernels.scene import Point, Spot

_PLANE = 1024  # pixels along the side of a projector's image
WHITE = 0.005  # albedo of receivers, for what a camera sees of them: so dark that they light nothing else


class SchlickMirror(mi.BSDF):
    """A perfect mirror on both sides: f0 + (f90 - f0) (1 - cos)^5."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.f0, self.f90 = (mi.Color3f(props[name]) for name in ("f0", "f90"))
        self.m_components = [mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide]
        self.m_flags = self.m_components[0]

    def sample(self, ctx, si, sample1, sample2, active=True):
        sample = mi.BSDFSample3f()
        sample.wo = mi.reflect(si.wi)
        sample.pdf, sample.eta = 1.0, 1.0
        sample.sampled_type = mi.UInt32(int(mi.BSDFFlags.DeltaReflection))
        sample.sampled_component = 0
        share = (1 - dr.abs(mi.Frame3f.cos_theta(si.wi))) ** 5
        return sample, self.f0 + (self.f90 - self.f0) * share

    def eval(self, ctx, si, wo, active=True):
        return mi.Color3f(0)

    def pdf(self, ctx, si, wo, active=True):
        return mi.Float(0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return mi.Color3f(0), mi.Float(0)

    def to_string(self):
        return "SchlickMirror"


mi.register_bsdf("schlick_mirror", lambda props: SchlickMirror(props))


@dataclass(frozen=True)
class Loaded:
    """scene, of Mitsuba; receivers, their shapes; specular: pairs of a shape and its mesh's positions (V,3)."""

    scene: Any
    receivers: list
    specular: list


def load(scene, emitters=False):
    """The Loaded of a Scene; with its lights as Mitsuba's emitters where `emitters`."""
    water = _medium(scene.sigma_a)
    parts = {"type": "scene"}
    for number, receiver in enumerate(scene.receivers):
        bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": WHITE}}}
        parts[f"receiver{number}"] = _shape(receiver, receiver.triangles, None, bsdf, receiver.uvs)
    for number, occluder in enumerate(scene.occluders):
        bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}
        parts[f"occluder{number}"] = _shape(occluder, occluder.triangles, None, bsdf)
    if len(scene.water.triangles):
        bsdf = {"type": "dielectric", "int_ior": float(scene.eta), "ext_ior": 1.0}
        parts["water"] = _shape(scene.water, scene.water.triangles, scene.water, bsdf, inside=water)
    for number, caster in enumerate(scene.casters):
        sunken = _sunken(caster, scene.water)
        bsdf, inside = _material(caster.material, scene.eta if sunken else 1.0)
        around = water if sunken else None
        parts[f"caster{number}"] = _shape(caster, caster.triangles, caster, bsdf, inside=inside, outside=around)
    if emitters:
        parts.update({f"light{number}": _emitter(light) for number, light in enumerate(scene.lights)})
    receivers = [parts[f"receiver{number}"] for number in range(len(scene.receivers))]
    meshes = {"water": scene.water, **{f"caster{number}": caster for number, caster in enumerate(scene.casters)}}
    specular = [(parts[name], mesh.positions[mesh.triangles.ravel()]) for name, mesh in meshes.items() if name in parts]
    return Loaded(mi.load_dict(parts), receivers, specular)


def _material(material, around):
    """BSDF and medium of a Glass or a Mirror, the Glass in a medium of index `around`."""
    if not isinstance(material, Glass):
        return {"type": "schlick_mirror", "f0": mi.Color3f(material.f0), "f90": mi.Color3f(material.f90)}, None
    bsdf = {"type": "dielectric", "int_ior": float(material.eta), "ext_ior": float(around)}
    for name, colour in (("specular_reflectance", material.reflects), ("specular_transmittance", material.transmits)):
        bsdf[name] = {"type": "rgb", "value": list(map(float, colour))}
    return bsdf, _medium(material.sigma_a)


def _medium(sigma_a):
    """A medium that absorbs, None for one that does not."""
    if not np.any(sigma_a):
        return None
    scale = float(np.max(sigma_a))  # Mitsuba takes colours of a medium up to 1
    sigma = {"type": "rgb", "value": [float(value) / scale for value in sigma_a]}
    black = {"type": "rgb", "value": 0.0}
    return mi.load_dict({"type": "homogeneous", "albedo": black, "sigma_t": sigma, "scale": scale})


def _sunken(caster, water):
    """Whether a caster lies under the water; raises ValueError where glass does in part."""
    if not len(water.triangles):
        return False
    top, bottom = water.positions[:, 2].max(), water.positions[:, 2].min()
    if isinstance(caster.material, Glass) and caster.positions[:, 2].max() > bottom:
        if caster.positions[:, 2].min() < top:
            raise ValueError(f"{caster.name} lies in the water in part, which Mitsuba's dielectrics cannot say")
        return False
    return caster.positions[:, 2].max() <= bottom


def _shape(mesh, triangles, shaded, bsdf, uvs=None, inside=None, outside=None):
    """A mesh of Mitsuba; every corner has a vertex of its own, with the normals of `shaded` and uvs (T,3,2)."""
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    for name, medium in (("interior", inside), ("exterior", outside)):
        if medium is not None:
            props[name] = medium
    count = 3 * len(triangles)
    shape = mi.Mesh(mesh.name, count, len(triangles), props, shaded is not None, uvs is not None)
    values = mi.traverse(shape)
    values["vertex_positions"] = mi.Float(mesh.positions[triangles].astype(np.float32).ravel())
    values["faces"] = mi.UInt32(np.arange(count, dtype=np.uint32))
    if shaded is not None:
        normals = shaded.normals[shaded.normal_triangles]
        values["vertex_normals"] = mi.Float(normals.astype(np.float32).ravel())
    if uvs is not None:
        values["vertex_texcoords"] = mi.Float(np.asarray(uvs, np.float32).ravel())
    values.update()
    return shape


def _emitter(light):
    """A light as an emitter of Mitsuba: a Sun without its disc, a lamp as a point, a round Spot as a projector."""
    if isinstance(light, Spot):
        return _projector(light)
    if isinstance(light, Point):
        intensity = {"type": "rgb", "value": list(map(float, light.intensity))}
        return {"type": "point", "position": list(map(float, light.position)), "intensity": intensity}
    irradiance = {"type": "rgb", "value": list(map(float, light.irradiance))}
    return {"type": "directional", "direction": list(map(float, light.direction)), "irradiance": irradiance}


def falloff(spot, cosine):
    """Share of a Spot's intensity at a cosine from its axis: smoothstep over the blend."""
    edge = np.cos(spot.half_angle)
    x = np.clip((cosine - edge) / max((1 - edge) * spot.blend, 1e-9), 0, 1)
    return x * x * (3 - 2 * x)


def _projector(spot):
    """A Spot as what it throws on a plane at distance 1: intensity times cos^3, over the pi by which Mitsuba multiplies
    a projector's. Raises ValueError for a cone that is an ellipse."""
    if not np.allclose(spot.frame @ spot.frame.T, np.eye(3), atol=1e-5):
        raise ValueError("a Spot whose cone is an ellipse: it is handed to Mitsuba round only")
    reach = np.tan(spot.half_angle) * (1 + 4 / _PLANE)
    axis = ((np.arange(_PLANE) + 0.5) / _PLANE * 2 - 1) * reach
    cosine = 1 / np.sqrt(1 + axis**2 + axis[:, None] ** 2)
    image = (falloff(spot, cosine) * cosine**3 / np.pi)[:, :, None] * np.asarray(spot.intensity, float)
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = spot.frame.T, spot.position
    place[:3, 0] *= np.sign(np.linalg.det(place[:3, :3]))
    return {
        "type": "projector", "to_world": mi.ScalarTransform4f(place), "fov": float(2 * np.degrees(np.arctan(reach))),
        "irradiance": {"type": "bitmap", "bitmap": mi.Bitmap(image.astype(np.float32)), "raw": True},
    }  # fmt: skip
