"""Checks of the arrays that the solvers are given."""

from __future__ import annotations


def check_shape(name, array, *tail):
    """Raise ValueError unless `array` is (n, *tail)."""
    if array.ndim != 1 + len(tail) or array.shape[1:] != tail:
        wanted = ", ".join(["n", *map(str, tail)])
        raise ValueError(f"{name} must have shape ({wanted}), got {array.shape}")


def check_index(name, index, count):
    """Raise ValueError unless all of `index` lies in [0, count)."""
    if len(index) and (index.min() < 0 or index.max() >= count):
        raise ValueError(f"{name} must lie in [0, {count}), got {index.min()} to {index.max()}")


def check_shaded(mesh):
    """Raise ValueError unless the arrays of a mesh with normals of its own fit each other."""
    check_shape("positions", mesh.positions, 3)
    check_shape("triangles", mesh.triangles, 3)
    check_shape("normals", mesh.normals, 3)
    check_shape("normal_triangles", mesh.normal_triangles, 3)
    check_index("triangles", mesh.triangles, len(mesh.positions))
    check_index("normal_triangles", mesh.normal_triangles, len(mesh.normals))
    if len(mesh.normal_triangles) != len(mesh.triangles):
        raise ValueError(f"normal_triangles must have shape {mesh.triangles.shape}, got {mesh.normal_triangles.shape}")
