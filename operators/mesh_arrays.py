"""Blender's evaluated meshes as world-space arrays, by bulk reads only.

Positions and corner tables are read as attributes, which Blender hands over in one copy; the same through
`mesh.vertices` takes ten times as long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.halfedges import build_twins


@dataclass(frozen=True)
class MeshArrays:
    """positions (V,3) float64 [m] world space; corners (T,3) int32 into the mesh's corners; triangles (T,3) int32 into
    positions, wound counter-clockwise seen from where the world-space normals point to."""

    positions: np.ndarray
    corners: np.ndarray
    triangles: np.ndarray


class TopologyCache:
    """Adjacency of the water, kept while its triangles stay the same from frame to frame."""

    def __init__(self):
        self._triangles = None
        self._twins = None

    def settle(self, triangles):
        """(triangles, twins (3T,)): the very arrays of the last call where the triangles are equal to those."""
        if self._triangles is None or not np.array_equal(self._triangles, triangles):
            self._triangles, self._twins = triangles, build_twins(triangles)
        return self._triangles, self._twins


def read_geometry(mesh, matrix):
    """MeshArrays of an evaluated mesh under a world matrix (4,4) float64.

    A mirroring matrix turns the triangles round, so that they agree with their normals again.
    """
    corners = _triangle_corners(mesh)
    if np.linalg.det(matrix[:3, :3]) < 0:
        corners = np.ascontiguousarray(corners[:, ::-1])
    corner_vertex = np.empty(len(mesh.loops), dtype=np.int32)
    if len(corner_vertex):
        mesh.attributes[".corner_vert"].data.foreach_get("value", corner_vertex)
    local = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    if len(local):
        mesh.attributes["position"].data.foreach_get("vector", local.ravel())
    positions = local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return MeshArrays(positions, corners, corner_vertex[corners])


def read_normals(mesh, matrix, arrays):
    """(normals (N,3) float64 unit, normal_triangles (T,3)) as the mesh is shaded: per vertex, face or corner.

    Smooth meshes get `arrays.triangles` itself as their normal_triangles, unless their normals are set by hand.
    """
    if mesh.normals_domain == "POINT" and not mesh.has_custom_normals:
        source, index = mesh.vertex_normals, arrays.triangles
    elif mesh.normals_domain == "FACE" and not mesh.has_custom_normals:
        polygon = np.empty(len(arrays.triangles), dtype=np.int32)
        mesh.loop_triangle_polygons.foreach_get("value", polygon)
        source, index = mesh.polygon_normals, np.repeat(polygon, 3).reshape(-1, 3)
    else:
        source, index = mesh.corner_normals, arrays.corners
    local = np.empty((len(source), 3), dtype=np.float32)
    source.foreach_get("vector", local.ravel())
    return turn_normals(local, matrix), index


def read_uvs(mesh, arrays):
    """UVs (T,3,2) float64 of the layer that is active for rendering, one per corner; None where there is no layer."""
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is None:
        return None
    uvs = np.empty((len(mesh.loops), 2), dtype=np.float32)
    if len(uvs):
        layer.uv.foreach_get("vector", uvs.ravel())
    return uvs.astype(np.float64)[arrays.corners]


def read_material_index(mesh, arrays):
    """Index (T,) int32 into the mesh's materials."""
    values = np.zeros(len(mesh.polygons), dtype=np.int32)
    layer = mesh.attributes.get("material_index")
    if layer is None or not len(values):
        return np.zeros(len(arrays.triangles), dtype=np.int32)
    layer.data.foreach_get("value", values)
    polygon = np.empty(len(arrays.triangles), dtype=np.int32)
    mesh.loop_triangle_polygons.foreach_get("value", polygon)
    return values[polygon]


def _triangle_corners(mesh):
    """Corners of Blender's triangulation: (T,3) int32. It depends on the positions too, hence one read per frame."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == len(mesh.polygons) and 3 * count == len(mesh.loops):
        return np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    corners = np.empty((count, 3), dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corners.ravel())
    return corners


def turn_normals(local, matrix):
    """Unit normals (N,3) into world space by the inverse transpose.

    The cofactors are that up to a factor, and exist where the object is scaled flat as well.
    """
    x, y, z = matrix[:3, :3].T
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=1)
    if np.linalg.det(matrix[:3, :3]) < 0:
        cofactors = -cofactors
    normals = local.astype(np.float64) @ cofactors.T
    length = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    return normals / np.maximum(length, np.finfo(np.float64).tiny)[:, None]
