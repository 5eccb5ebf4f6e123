"""Blender's evaluated meshes as world-space arrays, by bulk reads only.

Positions and corner tables are read as attributes, which Blender hands over in one copy; the same through
`mesh.vertices` takes ten times as long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...kernels.halfedges import build_twins
from ..errors import DappleError

LAYER = "Dapple"  # the UV map that is made for lightmaps
_VECTORS = {"FLOAT2": 2, "FLOAT_VECTOR": 3}
_BY_HAND = 0.01  # rad: by how much a normal set by hand differs from smooth shading, at least


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
    positions = _positions(mesh).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return MeshArrays(positions, corners, _corner_vertices(mesh)[corners])


def check_mesh(what, arrays):
    """Raise DappleError for MeshArrays without faces or with vertices that are not numbers."""
    if not len(arrays.triangles):
        raise DappleError(f"{what} has no faces after its modifiers; check them, or pick another object.")
    broken = np.count_nonzero(~np.isfinite(arrays.positions).all(axis=1))
    if broken:
        raise DappleError(
            f"{what} has coordinates that are not numbers at {broken} of its {len(arrays.positions)} vertices; "
            "check its modifiers, drivers and cache for divisions by zero."
        )


def read_normals(mesh, matrix, arrays):
    """(normals (N,3) float64 unit, normal_triangles (T,3)) as the mesh is shaded: per vertex, face or corner.

    Smooth meshes get `arrays.triangles` itself as their normal_triangles. So do those whose normals are set by hand, as
    caches set them, but are no other than smooth shading would make them.
    """
    if mesh.has_custom_normals:
        local, smooth = _floats(mesh.corner_normals), _smooth_normals(mesh)
        vertices = _corner_vertices(mesh)
        if np.abs(local - smooth[vertices]).max(initial=0) > _BY_HAND:
            return turn_normals(local, matrix), arrays.corners
        return turn_normals(smooth, matrix), arrays.triangles
    if mesh.normals_domain == "POINT":
        source, index = mesh.vertex_normals, arrays.triangles
    elif mesh.normals_domain == "FACE":
        polygon = np.empty(len(arrays.triangles), dtype=np.int32)
        mesh.loop_triangle_polygons.foreach_get("value", polygon)
        source, index = mesh.polygon_normals, np.repeat(polygon, 3).reshape(-1, 3)
    else:
        source, index = mesh.corner_normals, arrays.corners
    return turn_normals(_floats(source), matrix), index


def _smooth_normals(mesh):
    """Normals (V,3) of smooth shading, without those set by hand: the faces' means by their corners' angles.

    From the positions alone, for where normals are set by hand Blender's own of faces and vertices follow them.
    """
    start, count = np.empty((2, len(mesh.polygons)), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", start)
    mesh.polygons.foreach_get("loop_total", count)
    before, after = np.arange(len(mesh.loops)) - 1, np.arange(len(mesh.loops)) + 1
    before[start], after[start + count - 1] = start + count - 1, start
    vertices = _corner_vertices(mesh)
    corners = _positions(mesh).astype(np.float64)[vertices]
    back, forth = corners[before] - corners, corners[after] - corners
    across = np.cross(forth, back)
    angle = np.arctan2(np.linalg.norm(across, axis=1), (back * forth).sum(1))
    normal = _unit(np.add.reduceat(across, start) if len(start) else across)
    weighted = np.repeat(normal, count, axis=0) * angle[:, None]
    return _unit(np.stack([np.bincount(vertices, w, len(mesh.vertices)) for w in weighted.T], axis=1))


def _unit(vectors):
    """Vectors (N,3) at length one, zero where they have none."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(np.float64).tiny)[:, None]


def _floats(vectors):
    """Values (N,3) of a collection of normals."""
    values = np.empty((len(vectors), 3), dtype=np.float32)
    vectors.foreach_get("vector", values.ravel())
    return values


def _positions(mesh):
    """Positions (V,3) float32 of the vertices in the mesh's own space."""
    local = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    if len(local):
        mesh.attributes["position"].data.foreach_get("vector", local.ravel())
    return local


def _corner_vertices(mesh):
    """Vertex (L,) int32 of each corner."""
    vertices = np.empty(len(mesh.loops), dtype=np.int32)
    if len(vertices):
        mesh.attributes[".corner_vert"].data.foreach_get("value", vertices)
    return vertices


def lightmap_layer(mesh):
    """The name of the UV map that lays out a mesh's lightmap: our own, else the one that renders, else a vector that
    geometry nodes stored under a usual name; empty where there is none."""
    if LAYER in mesh.uv_layers:
        return LAYER
    renders = [layer.name for layer in mesh.uv_layers if layer.active_render] or [
        layer.name for layer in mesh.uv_layers
    ]
    vectors = (mesh.attributes.get(name) for name in (LAYER, "UVMap"))
    stored = [a.name for a in vectors if a and a.data_type in _VECTORS and a.domain in ("CORNER", "POINT")]
    return next(iter(renders + stored), "")


def read_uvs(mesh, arrays):
    """UVs (T,3,2) float64 of the layer `lightmap_layer`, one per corner; None where there is none."""
    name = lightmap_layer(mesh)
    if not name:
        return None
    if name in mesh.uv_layers:
        uvs, index = np.empty((len(mesh.loops), 2), dtype=np.float32), arrays.corners
        if len(uvs):
            mesh.uv_layers[name].uv.foreach_get("vector", uvs.ravel())
    else:
        stored = mesh.attributes[name]
        uvs = np.empty((len(stored.data), _VECTORS[stored.data_type]), dtype=np.float32)
        stored.data.foreach_get("vector", uvs.ravel())
        index = arrays.corners if stored.domain == "CORNER" else arrays.triangles
    return uvs[:, :2].astype(np.float64)[index]


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
    return _unit(local.astype(np.float64) @ cofactors.T)
