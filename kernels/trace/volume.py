"""The box that bounds the casters: whether points lie in it, and by which face rays leave it."""

from __future__ import annotations

import numpy as np

_EDGE = 1e-9  # of the box: what lies on a face is inside


class Box:
    """The cube [-1, 1]^3 in the world, from a `scene.Volume`; culling (6,) bool per face, -x, +x, -y, +y, -z, +z."""

    def __init__(self, volume):
        self.culling = np.asarray(volume.culling, bool)
        self._inverse = np.linalg.inv(np.asarray(volume.matrix, float))[:3]

    def contains(self, points):
        """Whether (k,) points (3,k) lie in the box."""
        return (np.abs(self._inverse[:, :3] @ points + self._inverse[:, 3:]) <= 1 + _EDGE).all(0)

    def touches(self, soup):
        """Whether (T,) the bounds of triangles (T,3,3), in the box's own axes, overlap it."""
        local = soup @ self._inverse[:, :3].T + self._inverse[:, 3]
        return ((local.max(1) >= -1) & (local.min(1) <= 1)).all(1)

    def leaves(self, origin, direction):
        """Distance (k,) at which rays from within leave, and the face (k,) by which they do."""
        local = self._inverse[:, :3] @ origin + self._inverse[:, 3:]
        along = self._inverse[:, :3] @ direction
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.where(along == 0, np.inf, (np.sign(along) - local) / along)
        axis = far.argmin(0)
        pick = axis, np.arange(far.shape[1])
        return np.maximum(far[pick], 0), 2 * axis + (along[pick] > 0)
