"""The lamp's disc: light that comes from a disc, not from a point, is spread over an ellipse on the receiver.

To first order a turn of the light by delta moves the point where a refracted ray lands by Q delta, with Q = tau B J: J
how the refracted ray turns, tau how far it goes, B the receiver's map to texels. So the map is that of the disc's
centre, convolved with the ellipse Q R, R half the disc's angle. What is convolved are the fluxes of cells of a grid,
finer than the texels where the ellipse is small; a cell's own extent is taken off the ellipse's second moments, so that
those of the result are exact. Where the ellipse changes over a chart, a few of them are blended. Light that would leave
its chart stays where it is, which keeps the energy and leaves even light even.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maps.coverage import edge_coverage
from ..optics import cosine_refracted, sun_frame
from .lander import texel_maps

_SIDES = 96  # of the polygon that stands for an ellipse
_CELLS = 1.2, 3.0  # half axis of the smallest receiver's largest ellipse, in cells, as the tolerance asks
# Measured on pools against hundreds of suns: error per variance of the map, of the grid for small ellipses (with half
# axes of R cells it falls as 1 + 2 R^3) and of taking all waves for their mean; within a factor of three.
_GRID_ERROR, _MEAN_ERROR = 5e-3, 5e-4
_SMALL = 0.3  # cells^2: smaller ellipses hardly leave their cell
_MATCHES = 4
_GRAIN = 3  # cells along a texel, at most
_LEAST = 0.1  # texels: smaller ellipses change nothing
_ALIKE = 0.1  # of the largest: ellipses this near to each other are one, and
_BLENDED = 0.25  # those of depths whose squares lie this near to each other are blended
_GOLDEN = (np.sqrt(5) - 1) / 2


class Disc:
    """What the disc of half angle `radius` [rad] does to the maps of receivers under a LitWater.

    texels: Texels of the receivers; eta: of the water; tolerance: relative mean squared error that is good enough.
    `seen` tells whether it does anything; `grain` is the number of cells along a texel that `blur` needs, `error` the
    relative mean squared error that it leaves, per variance of the map over its squared mean.
    """

    def __init__(self, lit, receivers, texels, eta, radius, tolerance):
        self.grain, self.error, self._texels = 1, 0.0, texels
        self.seen = radius > 0 and lit.area.any()
        if not self.seen:
            return
        n, middle, slope = _mean_plane(lit)
        ways = [
            (t, radius * dt, slope * bend) for t, dt, bend in (_refracted(lit.frame, n, eta), _reflected(lit.frame, n))
        ]
        self._ellipses = [_Ellipses(r, t, n, middle, ways) for r, t in zip(receivers, texels, strict=True)]
        sizes = [size for size in (e.size() for e in self._ellipses) if size > _LEAST]
        self.seen = bool(sizes)
        if self.seen:
            cells = np.clip(np.cbrt(_GRID_ERROR / tolerance), *_CELLS)
            self.grain = int(np.clip(np.ceil(cells / min(sizes)), 1, _GRAIN))
            self.error = _GRID_ERROR / (1 + 2 * (self.grain * min(sizes)) ** 3) + _MEAN_ERROR

    def blur(self, flux):
        """Flux (images * side^2,) of the texels, of flux (images * (grain side)^2,) of the cells."""
        side = self._texels[0].resolution
        if not self.seen:
            return flux
        images = flux.reshape(len(self._texels), self.grain * side, self.grain * side).copy()
        for image, texels, ellipses in zip(images, self._texels, self._ellipses, strict=True):
            _blur_image(image, texels, ellipses, self.grain)
        return images.reshape(-1, side, self.grain, side, self.grain).sum((2, 4)).ravel()


def within_disc(sun, count, rng):
    """Suns of no width, `count` of them, whose directions are stratified over the disc of a Sun."""
    across = sun_frame(sun.direction)[:2]
    ring = np.sqrt((np.arange(count) + rng.random(count)) / count) * np.tan(sun.angle / 2)
    turn = 2 * np.pi * (np.arange(count) * _GOLDEN + rng.random())
    directions = sun.direction + np.stack([ring * np.cos(turn), ring * np.sin(turn)], 1) @ across
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return [replace(sun, direction=direction, angle=0.0) for direction in directions]


class _Ellipses:
    """The ellipses of one receiver's texels: kind (K,) of each, covariance (kinds,2,2) [texel^2] of a kind at unit
    depth, and depth (K,) [m] of each texel from the water along the mean ray."""

    def __init__(self, receiver, texels, n, middle, ways):
        """Under a plane through `middle` (3,) of normal n (3,); ways: `_covariances` takes them, below it and above."""
        rise = texels.positions @ n - middle @ n
        maps = texel_maps(receiver, texels.resolution)
        self.kind, self.depth = np.zeros(len(rise), np.int64), np.zeros(len(rise))
        self.covariance = np.zeros((0, 2, 2))
        for own, way in zip((rise <= 0, rise > 0), ways, strict=True):
            if own.any():
                kind, covariance = _kinds(_covariances(maps, *way))
                self.kind[own] = len(self.covariance) + kind[texels.triangle[own]]
                self.covariance = np.concatenate([self.covariance, covariance])
                self.depth[own] = np.maximum(rise[own] / (way[0] @ n), 0)

    def size(self):
        """The largest half axis [texel] of all."""
        if not len(self.depth):
            return 0.0
        return 2 * np.sqrt(np.linalg.eigvalsh(self.covariance).max()) * self.depth.max()


def _mean_plane(lit):
    """Unit normal (3,) of the lit water on average, towards the light, a point (3,) of it, and how far normals lean in
    one direction, root mean square."""
    weight = lit.area / lit.area.sum()
    normals = lit.normals[lit.normal_triangles].mean(1)
    n = weight @ normals
    n /= np.linalg.norm(n)
    lean = weight @ ((normals - np.outer(normals @ n, n)) ** 2).sum(1) / 2
    return lit.frame.T @ n, lit.frame.T @ (weight @ lit.positions[lit.triangles].mean(1)), np.sqrt(lean)


def _refracted(frame, n, eta):
    """Direction t (3,) of light that is refracted at normal n, how it turns with the light, dt (3,2), and with n."""
    s, across = frame[2], frame[:2].T
    c = s @ n
    c_t = cosine_refracted(c, eta)
    turn = -(n @ across)  # of c
    gamma = c / eta - c_t
    return gamma * n - s / eta, across / eta + np.outer(n, (1 / eta - c / (c_t * eta * eta)) * turn), abs(gamma)


def _reflected(frame, n):
    """As `_refracted`, of light that is reflected."""
    s, across = frame[2], frame[:2].T
    return 2 * (s @ n) * n - s, across - 2 * np.outer(n, n @ across), 2 * (s @ n)


def _covariances(maps, t, dt, wander):
    """Covariance (T,2,2) [texel^2/m^2], at unit depth, of light t that turns by dt (3,2) over an even disc of radius 1,
    on the surfaces of texel maps (T,3,4).

    wander: how far waves turn the light to one side, root mean square: no more along a surface than that is it ever.
    """
    fall = maps[:, 0, :3] @ t
    fall = np.where(fall < 0, -1.0, 1.0) * np.sqrt(fall**2 + wander**2 + np.finfo(float).eps)
    slide = dt - t[:, None] * ((maps[:, 0, :3] @ dt) / fall[:, None])[:, None]
    q = maps[:, 1:, :3] @ slide
    return q @ q.transpose(0, 2, 1) / 4


def _kinds(covariance):
    """Kind (T,) of each covariance (T,2,2), alike ones of one kind, and their means (kinds,2,2)."""
    flat = covariance.reshape(-1, 4)
    scale = np.maximum(np.abs(flat).max(1, keepdims=True), np.finfo(float).tiny)
    alike = np.concatenate([flat / scale, np.log(scale)], 1) / _ALIKE
    _, kind = np.unique(np.round(alike), axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    sums = [np.bincount(kind, c) / np.bincount(kind) for c in flat.T]
    return kind, np.stack(sums, 1).reshape(-1, 2, 2)


def _blur_image(image, texels, ellipses, grain):
    """Blur the cells of one image (grain side, grain side) in place, chart by chart."""
    side = texels.resolution
    on = np.flatnonzero(texels.home >= 0)
    home = texels.home[on]
    chart = texels.chart[texels.triangle[home]]
    order = np.argsort(chart, kind="stable")
    for own in np.split(order, np.flatnonzero(np.diff(chart[order])) + 1):
        row, column = np.divmod(on[own], side)
        corner = row.min(), column.min()
        shape = row.max() - corner[0] + 1, column.max() - corner[1] + 1
        at = np.full(shape, -1)
        at[row - corner[0], column - corner[1]] = home[own]
        window = tuple(slice(c * grain, (c + n) * grain) for c, n in zip(corner, shape))
        image[window] = _blur_chart(image[window], at, ellipses, grain)


def _blur_chart(flux, home, ellipses, grain):
    """Blurred flux of the cells of one chart's window; home: the texel (rows, columns) of each, -1 off the chart."""
    on = home >= 0
    kind, depth = ellipses.kind[home], ellipses.depth[home]
    depths, kernels, parts = [], [], []
    for k in np.unique(kind[on]):
        for at, weight in _hats(depth, on & (kind == k)):
            depths.append(at)
            kernels.append(_kernel(ellipses.covariance[k] * (at * grain) ** 2))
            parts.append(flux * _cells(weight, grain))
    mask = _cells(on.astype(float), grain)
    blurred = mask * _convolved(parts, kernels)
    # What left the chart goes back to where such light comes from: as an ellipse of middle size tells, and the depth.
    middle = np.argsort([len(kernel) for kernel in kernels])[len(kernels) // 2]
    leaves = mask * flux * np.clip(1 - _convolved([mask], [kernels[middle]]), 0, 1)
    if len(kernels) > 1:
        leaves *= _cells(depth / max(depths[middle], np.finfo(float).tiny), grain)
    gone = (mask * flux).sum() - blurred.sum()
    if leaves.sum() > 0:
        blurred += leaves * (gone / leaves.sum())
    return np.where(mask > 0, blurred, flux)


def _cells(values, grain):
    """Of texels, repeated for their cells."""
    return np.repeat(np.repeat(values, grain, axis=0), grain, axis=1)


def _hats(depth, chosen):
    """Depths at which an ellipse is taken, and the weight of each at the texels chosen: linear in between in the square
    of the depth, so that the blend has the second moments of the depth between."""
    square = np.where(chosen, depth, 0.0) ** 2
    low, high = square[chosen].min(), square[chosen].max()
    if high - low <= _ALIKE * high:
        return [(np.sqrt((low + high) / 2), chosen.astype(float))]
    at = np.linspace(low, high, int(np.ceil((high - low) / (_BLENDED * high))) + 1)
    step = at[1] - at[0]
    return [(np.sqrt(a), chosen * np.maximum(1 - np.abs(square - a) / step, 0)) for a in at]


def _kernel(covariance):
    """Shares (2r+1, 2r+1) of the cells round one of what spreads from it over an even ellipse of this covariance (2,2)
    [cell^2].

    Cells sum what lies in them, so a kernel on cells changes a map as its own second moments say: those of the ellipse
    are asked of it. Ellipses that hardly leave their cell have a kernel of nine cells.
    """
    if np.linalg.eigvalsh(covariance)[1] < _SMALL:
        return _nine(covariance)
    asked = covariance - np.eye(2) / 12  # as a smooth distribution gains 1/12 in cells
    for _ in range(_MATCHES):
        kernel = _ellipse(asked)
        asked = asked + covariance - _moments(kernel)
    return kernel


def _nine(covariance):
    """The kernel (3,3) with second moments `covariance`, one step a way."""
    (xx, xy), (_, yy) = covariance
    slant = abs(xy)
    kernel = np.zeros((3, 3))
    kernel[1, [0, 2]] = (xx - slant) / 2
    kernel[[0, 2], 1] = (yy - slant) / 2
    kernel[[0, 2], [0, 2] if xy > 0 else [2, 0]] = slant / 2
    kernel[1, 1] = 1 - kernel.sum()
    return kernel


def _ellipse(covariance):
    """Shares (2r+1, 2r+1) of the cells in an even ellipse round the middle of one."""
    size, axes = np.linalg.eigh(covariance)
    half = axes * (2 * np.sqrt(np.maximum(size, _SMALL / 100))) @ axes.T
    angle = np.arange(_SIDES) * (2 * np.pi / _SIDES)
    rim = half @ np.stack([np.cos(angle), np.sin(angle)])
    reach = int(np.ceil(np.abs(rim).max() - 0.5))
    width = 2 * reach + 1
    rim += reach + 0.5
    area = edge_coverage(rim, np.roll(rim, -1, axis=1), np.ones((1, _SIDES)), (width, width))[0]
    return area / area.sum()


def _moments(kernel):
    """Second moments (2,2) of a kernel about its middle."""
    step = np.arange(len(kernel)) - len(kernel) // 2
    cross = step @ kernel @ step
    return np.array([[kernel.sum(0) @ step**2, cross], [cross, kernel.sum(1) @ step**2]])


def _convolved(images, kernels):
    """The sum of images, each convolved with its kernel, dark outside."""
    reach = max(len(kernel) for kernel in kernels) // 2
    rows, columns = images[0].shape
    shape = [_smooth(n + 2 * reach) for n in (rows, columns)]
    total = 0.0
    for image, kernel in zip(images, kernels, strict=True):
        middle = len(kernel) // 2
        centred = np.zeros(shape)
        centred[: len(kernel), : len(kernel)] = kernel
        factor = np.fft.rfft2(np.roll(centred, (-middle, -middle), axis=(0, 1)))
        total = total + np.fft.rfft2(image, shape) * factor
    return np.fft.irfft2(total, shape)[:rows, :columns]


def _smooth(n):
    """The least number from n on without prime factors above 5, where the transform is quick."""
    while True:
        rest = n
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return n
        n += 1
