"""Scenes and settings as solvers may trust them: numbers that are numbers, and that mean something.

What is wrong with the water or a caster and can be mended is mended in `sound_water.py`; all else is said here, by a
ValueError that names the argument.
"""

from __future__ import annotations

import numpy as np

from .casters import Glass
from .facets import used
from .scene import Area, Spot, Sun

FARTHEST = 1e9  # m from the origin: squares and cubes of what is further away have no digits left
_SMALLEST = 1e-6  # of what bends light: rays are cast in float32
_FLAT = 1e-9  # of a box's longest side to the third power
_FEW = 64  # triangles, that tell of most receivers that they are large enough
_MOST = 1e30  # W/m^2 or W/sr: what is stronger overflows the maps


def check_scene(scene):
    """Raise ValueError for a Scene with numbers that are not finite or that no scene can have."""
    for kind in ("receivers", "occluders", "casters"):
        for mesh in getattr(scene, kind):
            _check_positions(f"positions of {kind} '{mesh.name}'", mesh.positions)
    _check_positions("positions", scene.water.positions)
    _check_sizes(scene)
    _check_range("eta", scene.eta, 1.0, 10.0)
    _check_range("sigma_a", scene.sigma_a, 0.0, FARTHEST)
    for light in scene.lights:
        _check_light(light)
    for caster in scene.casters:
        _check_material(caster)
    if scene.volume is not None:
        _check_positions("matrix of the volume", scene.volume.matrix)
        axes = scene.volume.matrix[:3, :3]
        longest = np.linalg.norm(axes, axis=0).max()
        if not abs(np.linalg.det(axes)) > _FLAT * longest**3:
            raise ValueError("matrix of the volume must enclose something, but it is flat")


def check_settings(settings):
    """Raise ValueError for Settings that no method can meet."""
    if not 0 < settings.tolerance < np.inf:
        raise ValueError(f"tolerance must be a number above 0, got {settings.tolerance}")
    if not settings.bounces >= 1:
        raise ValueError(f"bounces must be 1 or more, got {settings.bounces}")


def _check_positions(name, positions):
    """Raise ValueError unless all coordinates are finite and not too far away."""
    if np.abs(positions).max(initial=0) <= FARTHEST:  # which no number is that is not one
        return
    broken = np.count_nonzero(~np.isfinite(positions).all(1))
    if broken:
        raise ValueError(f"{name} must be finite, but {broken} of {len(positions)} are not")
    raise ValueError(f"{name} must lie within {FARTHEST:g} m of the origin, got {np.abs(positions).max():g} m")


def _check_sizes(scene):
    """Raise ValueError for a receiver that is too small for rays from what bends light to meet it."""
    bending = [mesh for mesh in (scene.water, *scene.casters) if len(mesh.triangles)]
    most = max((_box(mesh.positions) for mesh in bending), default=0.0)
    small = [r for r in scene.receivers if _box(r.positions[r.triangles[:_FEW].ravel()]) < _SMALLEST * most]
    widest = max((_extent(mesh) for mesh in bending), default=0.0) if small else 0.0
    for receiver in small:
        extent = _extent(receiver)
        if extent < _SMALLEST * widest:
            raise ValueError(
                f"positions of receiver '{receiver.name}' span {extent:.2g} m under {widest:.2g} m of water and glass: "
                "too small for rays to meet; leave it out, or make the water smaller"
            )


def _extent(mesh):
    """The longest side [m] of the box round what a mesh's triangles use."""
    return _box(used(mesh.positions, mesh.triangles))


def _box(positions):
    """The longest side [m] of the box round positions (n,3)."""
    return max(float(np.ptp(v)) for v in positions.T) if len(positions) else 0.0


def _check_range(name, value, low, high):
    """Raise ValueError unless a number, or all of an array, lies in [low, high]."""
    if not np.all((np.asarray(value) >= low) & (np.asarray(value) <= high)):
        raise ValueError(f"{name} must lie in [{low:g}, {high:g}], got {value}")


def _check_light(light):
    """Raise ValueError for a light whose numbers are impossible."""
    if isinstance(light, Sun):
        _check_range(f"irradiance of '{light.name}'", light.irradiance, 0.0, _MOST)
        _check_range(f"angle of '{light.name}'", light.angle, 0.0, np.pi)
        return
    _check_positions(f"position of '{light.name}'", light.position[None])
    _check_range(f"intensity of '{light.name}'", light.intensity, 0.0, _MOST)
    _check_range(f"radius of '{light.name}'", light.radius, 0.0, FARTHEST)
    if isinstance(light, Area):
        _check_positions(f"half_axes of '{light.name}'", light.half_axes)
        if not np.linalg.norm(np.cross(*light.half_axes)) > 0:
            raise ValueError(f"half_axes of '{light.name}' must enclose an area, got {light.half_axes.tolist()}")
    if isinstance(light, Spot):
        _check_range(f"blend of '{light.name}'", light.blend, 0.0, 1.0)


def _check_material(caster):
    """Raise ValueError for a caster whose material is impossible."""
    material = caster.material
    if isinstance(material, Glass):
        _check_range(f"eta of '{caster.name}'", material.eta, 1.0, 10.0)
        _check_range(f"sigma_a of '{caster.name}'", material.sigma_a, 0.0, FARTHEST)
        colours = {"reflects": material.reflects, "transmits": material.transmits}
    else:
        colours = {"f0": material.f0, "f90": material.f90}
    for name, colour in colours.items():
        _check_range(f"{name} of '{caster.name}'", colour, 0.0, 1.0)
