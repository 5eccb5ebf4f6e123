"""Where photons land: on one plane, in closed form, or on the first of any surfaces, by rays.

Both keep the flux of every photon in bins, one per texel of the images and one per cause of loss, and hand over what
the texels own. A photon's texel is found from its landing point in float64, through each receiver triangle's affine
map from the world to texel coordinates.
"""

from __future__ import annotations

import numpy as np

from .photons import Forms, bend
from .rays import MISS

_PENDING = 1 << 19  # photons between two bincounts: their bins are larger than the cache
_FLAT = 1e-5  # texels: how far a receiver's corners may be from its plane's map


class Bins:
    """Flux per bin: `count` texels of images, then one bin for each name of `lost`."""

    def __init__(self, count, lost):
        self.count, self.lost = count, lost
        self._cell = np.empty(_PENDING, np.int64)
        self._flux = np.empty(_PENDING)
        self._filled = 0
        self._bins = np.zeros(count + len(lost))

    def add(self, cell, flux):
        """Add flux (n,) to bins cell (n,)."""
        if self._filled + len(cell) > _PENDING:
            self._flush()
        if len(cell) > _PENDING:
            self._bins += np.bincount(cell, flux, minlength=len(self._bins))
            return
        block = slice(self._filled, self._filled + len(cell))
        self._cell[block], self._flux[block] = cell, flux
        self._filled += len(cell)

    def take(self):
        """Flux of the texel bins (count,) and {cause: flux}; the bins start again from zero."""
        self._flush()
        bins, self._bins = self._bins, np.zeros_like(self._bins)
        return bins[: self.count], {name: float(bins[self.count + k]) for k, name in enumerate(self.lost)}

    def _flush(self):
        cell, flux = self._cell[: self._filled], self._flux[: self._filled]
        self._bins += np.bincount(cell, flux, minlength=len(self._bins))
        self._filled = 0


def texel_maps(receiver, resolution):
    """Affine maps (T, 3, 4) of a receiver's triangles: rows give the height above its plane [m] and the texel
    coordinates x, y of a world point (p, 1). Triangles without area get a height that no ray meets."""
    v = receiver.positions[receiver.triangles]
    e1, e2 = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    normal = np.cross(e1, e2)
    squared = (normal**2).sum(1)
    sound = squared > 0
    inverse = np.where(sound, 1 / np.where(sound, squared, 1), 0)[:, None]
    dual1, dual2 = np.cross(e2, normal) * inverse, np.cross(normal, e1) * inverse
    uv = receiver.uvs * resolution
    u1, u2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    rows = np.empty((len(v), 3, 4))
    rows[:, 0, :3] = normal * np.sqrt(inverse)
    for k in range(2):
        rows[:, 1 + k, :3] = u1[:, k : k + 1] * dual1 + u2[:, k : k + 1] * dual2
    rows[:, :, 3] = -(rows[:, :, :3] * v[:, 0, None]).sum(2)
    rows[:, 1:, 3] += uv[:, 0]
    return rows


class _Landing:
    """What both kinds share: the bins and the way from image texels to owned texels."""

    lost: tuple[str, ...] = ()

    def __init__(self, texels, eta):
        self.eta = eta
        self.resolution = texels[0].resolution if texels else 0
        self._homes = np.concatenate([t.home for t in texels]) if texels else np.zeros(0, np.int64)
        offset = np.cumsum([0, *(len(t.texel) for t in texels)])
        for k, t in enumerate(texels):
            part = self._homes[k * t.resolution**2 : (k + 1) * t.resolution**2]
            part[part >= 0] += offset[k]
        self._owned = int(offset[-1])
        self.bins = Bins(len(self._homes), self.lost)

    def take(self):
        """Flux per owned texel (K,) and per cause of loss; starts again from zero."""
        flux, lost = self.bins.take()
        at_home = self._homes >= 0
        lost["missed"] += float(flux[~at_home].sum())
        return np.bincount(self._homes[at_home], flux[at_home], minlength=self._owned), lost


class Rays(_Landing):
    """Photons land on the first surface that their ray meets."""

    lost = ("missed", "occluded", "shadowed", "reflected")

    def __init__(self, scene, texels, lit, shadowed, tracer):
        super().__init__(texels, scene.eta)
        self._maps = np.concatenate([np.zeros((0, 3, 4)), *(texel_maps(r, self.resolution) for r in scene.receivers)])
        self._maps = np.ascontiguousarray(self._maps.reshape(-1, 12).T)
        sizes = [len(r.triangles) for r in scene.receivers]
        self._base = np.repeat(np.arange(len(sizes)), sizes) * self.resolution**2
        self._tracer, self._shadowed, self._sun = tracer, shadowed, lit.frame[2]
        self._forms = Forms(lit, lit.frame.T, lit.frame.T)  # positions and normals back in the world

    def add(self, triangles, points, flux):
        """Land one batch of `photons.batches`."""
        values, squared = self._forms.at(triangles, points)
        origin, normal, along_sun = values[:3], values[3:6], values[6]
        g, passed = bend(along_sun, squared, self.eta)
        direction = normal * g - (self._sun / self.eta)[:, None]
        flux = np.repeat(flux, points.shape[1])
        end = len(self._homes)
        cell = self._land(origin, direction)
        shaded = np.repeat(self._shadowed[triangles], points.shape[1])
        if shaded.any():
            shaded = np.flatnonzero(shaded)
            towards = np.broadcast_to(self._sun, (len(shaded), 3))
            shaded = shaded[self._tracer.blocked(origin[:, shaded].T, towards)]
            cell[shaded] = end + 2
            passed[shaded] = 1.0
        through = flux * passed
        self.bins.add(cell, through)
        self.bins.add(np.full(1, end + 3), np.array([(flux - through).sum()]))

    def _land(self, origin, direction):
        """Bin (n,) of photons from origin (3,n) along direction (3,n)."""
        hit = self._tracer.first(origin.T, direction.T)
        end = len(self._homes)
        on_receiver = (hit != MISS) & (hit < len(self._base))
        cell = np.where(hit == MISS, end, end + 1)
        triangle = np.where(on_receiver, hit, 0)
        if not len(self._base):
            return cell
        height = self._along(0, triangle, origin)
        fall = self._along(0, triangle, direction, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            tau = -height / fall
        landed = origin + tau * direction
        x, y = self._along(1, triangle, landed), self._along(2, triangle, landed)
        return np.where(on_receiver, self._cell(x, y) + np.take(self._base, triangle), cell)

    def _along(self, row, triangle, vectors, homogeneous=1):
        """One row of each photon's texel map, applied to vectors (3,n)."""
        maps = self._maps[4 * row : 4 * row + 4]
        value = np.take(maps[0], triangle) * vectors[0]
        value += np.take(maps[1], triangle) * vectors[1]
        value += np.take(maps[2], triangle) * vectors[2]
        return value + np.take(maps[3], triangle) if homogeneous else value

    def _cell(self, x, y):
        """Flat texel (n,) of texel coordinates, clipped into the image."""
        top = self.resolution - 1
        i = np.clip(np.nan_to_num(x), 0, top).astype(np.int64)
        j = np.clip(np.nan_to_num(y), 0, top).astype(np.int64)
        return j * self.resolution + i


class Plane(_Landing):
    """Photons land on the only receiver, a plane with one affine UV map: no ray is needed."""

    lost = ("missed", "reflected")

    @classmethod
    def of(cls, scene, texels, lit):
        """The Plane of a scene that is one planar receiver with whole texels and nothing in the way, else None."""
        if len(scene.receivers) != 1 or scene.occluders:
            return None
        receiver, own = scene.receivers[0], texels[0]
        maps = texel_maps(receiver, own.resolution)
        widest = maps[np.argmax(np.abs(maps[:, 0, :3]).sum(1))]
        v = receiver.positions[receiver.triangles].reshape(-1, 3)
        image = v @ widest[:, :3].T + widest[:, 3]
        per_metre = np.linalg.norm(widest[1, :3])
        off = np.abs(image[:, 1:] - receiver.uvs.reshape(-1, 2) * own.resolution).max(initial=0)
        if max(off, np.abs(image[:, 0]).max(initial=0) * per_metre) > _FLAT * own.resolution:
            return None
        return cls(texels, scene.eta, lit, widest) if own.whole[own.texel].all() else None

    def __init__(self, texels, eta, lit, plane):
        super().__init__(texels, eta)
        own = texels[0]
        self._homes[~own.whole] = -1  # the first ring past the border is off the receiver here
        local = plane[:, :3] @ lit.frame.T
        self._offset = plane[:, 3]
        self._fall = -local[:, 2] / eta  # of d / eta, since light travels along -z
        self._forms = Forms(lit, local, local)

    def add(self, triangles, points, flux):
        """Land one batch of `photons.batches`."""
        (height, x, y, fall, dx, dy, along_sun), squared = self._forms.at(triangles, points)
        g, passed = bend(along_sun, squared, self.eta)
        fall *= g
        fall += self._fall[0]
        tau = -(height + self._offset[0]) / fall
        x += self._offset[1] + tau * (dx * g + self._fall[1])
        y += self._offset[2] + tau * (dy * g + self._fall[2])
        side = self.resolution
        inside = (x >= 0) & (x < side) & (y >= 0) & (y < side) & (tau > 0)
        cell = y.astype(np.int64) * side + x.astype(np.int64)
        end = len(self._homes)
        cell[~inside] = end
        passed = passed.reshape(len(triangles), -1)
        through = passed * flux[:, None]
        self.bins.add(cell, through.ravel())
        lost = flux.sum() * points.shape[1] - through.sum()
        self.bins.add(np.full(1, end + 1), np.array([lost]))
