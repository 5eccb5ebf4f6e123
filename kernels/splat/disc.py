"""The lamp's disc: light that comes from a disc, not from a point, is spread over an ellipse on the receiver.

To first order a turn of the light by delta moves the point where a refracted ray lands by Q delta, with Q = tau B J: J
how the refracted ray turns, tau how far it goes, B the receiver's map to texels. So the map is that of the disc's
centre, convolved with the ellipse Q R, R half the disc's angle. What is convolved are the fluxes of cells of a grid,
finer than the texels where the ellipse is small; a cell's own extent is taken off the ellipse's second moments, so that
those of the result are exact. Small ellipses are each texel's own; of larger ones that change over a chart a few are
blended. Light that would leave its chart stays where it is, which keeps the energy and leaves even light even.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

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
_NEAR = 0.95  # cells^2, both ways together: ellipses whose light the next cells can hold
_BLENDED, _ALIKE, _BLENDS = 0.3, 0.35, 4  # of the largest: between second moments on a lattice; less is one; at most
_ROUNDING = 1e-13  # of all flux
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
        self._covariances = [_covariance(r, t, n, middle, ways) for r, t in zip(receivers, texels, strict=True)]
        sizes = [2 * np.sqrt(c[:2].max(initial=0)) for c in self._covariances]
        sizes = [size for size in sizes if size > _LEAST]
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
        for image, texels, covariance in zip(images, self._texels, self._covariances, strict=True):
            _blur_image(image, texels, covariance, self.grain)
        return images.reshape(-1, side, self.grain, side, self.grain).sum((2, 4)).ravel()


def within_disc(sun, count, rng):
    """Suns of no width, `count` of them, whose directions are stratified over the disc of a Sun."""
    across = sun_frame(sun.direction)[:2]
    ring = np.sqrt((np.arange(count) + rng.random(count)) / count) * np.tan(sun.angle / 2)
    turn = 2 * np.pi * (np.arange(count) * _GOLDEN + rng.random())
    directions = sun.direction + np.stack([ring * np.cos(turn), ring * np.sin(turn)], 1) @ across
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return [replace(sun, direction=direction, angle=0.0) for direction in directions]


def _covariance(receiver, texels, n, middle, ways):
    """Second moments xx, yy, xy (3,K) [texel^2] of the ellipse of each texel, under a plane through `middle` (3,) of
    normal n (3,); ways: what `_at_unit_depth` takes, for texels below the plane and above it."""
    rise = texels.positions @ n - middle @ n
    maps = texel_maps(receiver, texels.resolution)
    covariance = np.zeros((3, len(rise)))
    for own, way in zip((rise <= 0, rise > 0), ways, strict=True):
        if own.any():
            depth = np.maximum(rise[own] / (way[0] @ n), 0)
            covariance[:, own] = _at_unit_depth(maps, *way)[:, texels.triangle[own]] * depth**2
    return covariance


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


def _at_unit_depth(maps, t, dt, wander):
    """Second moments xx, yy, xy (3,T) [texel^2/m^2], at unit depth, of light t that turns by dt (3,2) over
    an even disc, on the surfaces of texel maps (T,3,4).

    wander: how far waves turn the light to one side, root mean square: no more along a surface than that is it ever.
    """
    fall = maps[:, 0, :3] @ t
    fall = np.where(fall < 0, -1.0, 1.0) * np.sqrt(fall**2 + wander**2 + np.finfo(float).eps)
    slide = dt - t[:, None] * ((maps[:, 0, :3] @ dt) / fall[:, None])[:, None]
    q = maps[:, 1:, :3] @ slide
    return np.stack([(q[:, a] * q[:, b]).sum(1) for a, b in ((0, 0), (1, 1), (0, 1))]) / 4


def _blur_image(image, texels, covariance, grain):
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
        image[window] = _blur_chart(image[window], at, covariance, grain)


def _blur_chart(flux, home, covariance, grain):
    """Blurred flux of the cells of one chart's window; home: the texel (rows, columns) of each, -1 off the chart."""
    on = home >= 0
    moments = np.where(on, covariance[:, home], 0.0) * grain**2
    mask = _cells(on, grain)
    if (moments[0] + moments[1]).max() <= _NEAR:
        return _to_neighbours(flux, mask, moments, grain)
    return np.where(mask, _over_ellipses(np.where(mask, flux, 0.0), mask, on, moments, grain), flux)


def _to_neighbours(flux, mask, moments, grain):
    """Each cell gives its neighbours what has second moments xx, yy, xy (3,rows,columns) [cell^2] of its texel; nothing
    leaves the mask."""
    xx, yy, xy = moments
    slant = np.abs(xy)
    steps = (0, 1, (xx - slant) / 2), (1, 0, (yy - slant) / 2), (1, 1, np.maximum(xy, 0) / 2)
    blurred = flux.copy()
    for down, right, share in (*steps, (1, -1, np.maximum(-xy, 0) / 2)):
        if not share.any():
            continue
        given = flux * _cells(np.maximum(share, 0), grain)
        for there, here in (_shifted(down, right), _shifted(-down, -right)):
            moved = given[here] * mask[there]
            blurred[there] += moved
            blurred[here] -= moved
    return blurred


def _shifted(down, right):
    """Windows of an image: of the cells that lie (down, right) of a cell of it, and of those cells."""
    there = tuple(slice(max(d, 0), min(d, 0) or None) for d in (down, right))
    return there, tuple(slice(max(-d, 0), min(-d, 0) or None) for d in (down, right))


def _over_ellipses(flux, mask, on, moments, grain):
    """As `_to_neighbours`, over ellipses of any size: those on a lattice of second moments, blended."""
    kernels, parts = [], []
    for (xx, yy, xy), weight in _lattice(moments, on):
        kernels.append(_kernel(np.array([[xx, xy], [xy, yy]])))
        parts.append(flux * _cells(weight, grain))
    blurred = mask * _convolved(parts, kernels)
    blurred[blurred < _ROUNDING * flux.sum()] = 0  # what the transform leaves where no light is
    # What left the chart goes back to where such light comes from: as the largest ellipse tells, and each one's own.
    largest = max(range(len(kernels)), key=lambda k: len(kernels[k]))
    size = np.sqrt(moments[0] + moments[1])
    leaves = mask * flux * np.clip(1 - _convolved([mask.astype(float)], [kernels[largest]]), 0, 1)
    leaves *= _cells(size / size.max(), grain)
    gone = flux.sum() - blurred.sum()
    return blurred + leaves * (gone / leaves.sum()) if leaves.sum() > 0 else blurred


def _lattice(moments, on):
    """Second moments on a lattice, and the weights (rows, columns) of each for every texel that is `on`: the blend has
    the texel's own."""
    low, high = moments[:, on].min(1), moments[:, on].max(1)
    most = max(high[0], high[1])
    count = np.minimum(np.ceil((high - low) / (_BLENDED * most) - _ALIKE).astype(int), _BLENDS)
    axes = []
    for m, a, b, n in zip(moments, low, high, count, strict=True):
        at = np.linspace(a, b, n + 1) if n > 0 else np.array([m[on].mean()])
        step = (b - a) / n if n > 0 else np.inf
        axes.append([(point, np.maximum(1 - np.abs(m - point) / step, 0)) for point in at])
    for chosen in product(*axes):
        weight = on * chosen[0][1] * chosen[1][1] * chosen[2][1]
        if weight.any():
            yield tuple(point for point, _ in chosen), weight


def _cells(values, grain):
    """Of texels, repeated for their cells."""
    return np.repeat(np.repeat(values, grain, axis=0), grain, axis=1)


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
