"""The one door to embreex: which triangle a ray meets first, and whether anything stands in its way.

Embree works in float32. Coordinates are moved to the middle of the mesh before they are rounded, and what is wanted
exactly - the point of the hit - is computed again in float64 by the caller from the triangle that is returned.

Where embreex has no wheel or does not load, `tree_rays.py` serves in its place; SLOW then says why, else it is empty.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .facets import used
from .tree_rays import MISS, TreeScene

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except (ImportError, OSError) as error:  # not installed, or a library of it that this system refuses
    SLOW = f"embreex does not load here ({error})"
else:
    SLOW = ""

_FAR = 1e30
_SHORT_OF_LENGTH, _SHORT_OF_EXTENT = 2e-6, 2e-5  # float32 rounding of a ray's length and of the mesh
_AT_EDGE = 1e-6  # of the way there: a hit so near an edge may be the neighbour's, by the order of the search


class Tracer:
    """Rays against one triangle soup: positions (V,3), triangles (T,3). No triangle at all is a scene that all miss.

    about (n,3): where it is to be exact, by which its centre and extent go; else all that triangles use.
    """

    def __init__(self, positions, triangles, about=None):
        self.count = len(triangles)
        if not self.count:
            return
        corners = (used(positions, triangles) if about is None else about).T.copy()
        low, high = corners.min(1), corners.max(1)
        self.centre, self.extent = (low + high) / 2, float(np.linalg.norm(high - low))
        self._positions, self._triangles = positions, triangles
        self._scene = _scene(self._rounded(positions), np.ascontiguousarray(triangles, np.int32))

    def first(self, origins, directions):
        """Index (n,) of the first triangle that rays from origins (n,3) along directions (n,3) meet, MISS for none."""
        if not self.count or not len(origins):
            return np.full(len(origins), MISS, np.int32)
        return self._scene.run(self._rounded(origins), _single(directions))

    def hits(self, origins, directions):
        """As `first`; how far (n,) float32 it is along unit directions, without end where nothing is met; and whether
        (n,) that lies so near an edge that a search in another order might find another triangle. Only by embree."""
        if not self.count or not len(origins):
            none = len(origins)
            return np.full(none, MISS, np.int32), np.full(none, np.inf, np.float32), np.zeros(none, bool)
        directions = _single(directions)
        found = self._scene.run(self._rounded(origins), directions, output=True)
        triangle, u, v, far, across = (found[name] for name in ("primID", "u", "v", "tfar", "Ng"))
        least = np.minimum(np.minimum(u, v), 1 - u - v)
        least *= np.abs(sum(across[:, k] * directions[:, k] for k in range(3)))
        longest = np.take(self._longest, triangle)
        met = triangle != MISS
        return triangle, np.where(met, far, np.float32(np.inf)), met & (least <= _AT_EDGE * (far + longest) * longest)

    @cached_property
    def _longest(self):
        """The longest edge (T,) [m] of each triangle, float32."""
        corners = self._positions[self._triangles]
        return np.sqrt(((corners - np.roll(corners, 1, axis=1)) ** 2).sum(2).max(1)).astype(np.float32)

    def blocked(self, origins, directions, distances=np.inf):
        """Whether (n,) a triangle lies within `distances` along unit directions from origins.

        The far end is pulled in by the rounding of float32, so that the surface a ray ends on does not block it.
        """
        if not self.count or not len(origins):
            return np.zeros(len(origins), bool)
        far = np.broadcast_to(distances, len(origins)) * (1 - _SHORT_OF_LENGTH) - _SHORT_OF_EXTENT * self.extent
        far = np.clip(far, 0, _FAR).astype(np.float32)
        return self._scene.run(self._rounded(origins), _single(directions), dists=far, query="OCCLUDED") != MISS

    def _rounded(self, points):
        return _single(points, self.centre)


def _single(vectors, less=(0.0, 0.0, 0.0)):
    """Vectors (n,3), less another one, in single precision: by columns, which may be rows in memory."""
    rounded = np.empty(vectors.shape, np.float32)
    for k in range(3):
        np.subtract(vectors[:, k], less[k], out=rounded[:, k], casting="same_kind")
    return rounded


def _scene(positions, triangles):
    """What answers for rays that meet triangles (T,3) of positions (V,3)."""
    if SLOW:
        return TreeScene(positions, triangles)
    scene = EmbreeScene()
    TriangleMesh(scene, positions, triangles)
    return scene


_last = ()  # what `solid` was asked for last: planner and method want the same


def solid(meshes):
    """(positions (V,3), triangles (T,3), Tracer) of meshes joined; of the same arrays as the last time the same."""
    global _last
    arrays = [array for mesh in meshes for array in (mesh.positions, mesh.triangles)]
    if not _last or len(arrays) != len(_last[0]) or any(a is not b for a, b in zip(arrays, _last[0], strict=True)):
        joined = soup(meshes)
        _last = arrays, (*joined, Tracer(*joined))
    return _last[1]


def soup(meshes):
    """Join meshes with `positions` and `triangles` into one: (positions, triangles)."""
    meshes = tuple(meshes)
    if not meshes:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    base = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, base, strict=False)]
    return np.concatenate([mesh.positions for mesh in meshes]), np.concatenate(triangles)
