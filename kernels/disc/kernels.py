"""What spreads from a cell of a grid over an even ellipse, and the few ellipses that stand for those of all texels."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..maps.coverage import edge_coverage

_SIDES = 96  # of the polygon that stands for an ellipse
_SMALL = 0.3  # cells^2: smaller ellipses hardly leave their cell
_MATCHES = 4
_APART, _ALIKE, _MOST = 0.3, 0.35, 4  # of the largest: between second moments; less is one; steps at most
_EVEN = 1e-9  # of the largest: moments that differ by less are the same


def kernel(moments):
    """Shares (2r+1, 2r+1) of the cells round one of what spreads from it over an even ellipse of second moments xx, yy,
    xy [cell^2].

    Cells sum what lies in them, so a kernel on cells changes a map as its own second moments say: those of the ellipse
    are asked of it. Ellipses that hardly leave their cell have a kernel of nine cells.
    """
    xx, yy, xy = moments
    covariance = np.array([[xx, xy], [xy, yy]])
    if np.linalg.eigvalsh(covariance)[1] < _SMALL:
        return _nine(xx, yy, xy)
    asked = covariance - np.eye(2) / 12  # as a smooth distribution gains 1/12 in cells
    for _ in range(_MATCHES):
        shares = _ellipse(asked)
        asked = asked + covariance - second_moments(shares)
    return shares


def second_moments(shares):
    """Second moments (2,2) of a kernel about its middle."""
    step = np.arange(len(shares)) - len(shares) // 2
    cross = step @ shares @ step
    return np.array([[shares.sum(0) @ step**2, cross], [cross, shares.sum(1) @ step**2]])


def _nine(xx, yy, xy):
    """The kernel (3,3) with these second moments, and with the mixed fourth one of an even ellipse as far as that goes:
    4/6 of what its second moments make of a normal distribution."""
    least = max(min(xx, yy), 0.0)
    xy = np.clip(xy, -least, least)
    mixed = np.clip((xx * yy + 2 * xy * xy) * 2 / 3, abs(xy), least)
    shares = np.zeros((3, 3))
    shares[1, [0, 2]], shares[[0, 2], 1] = (max(xx, 0) - mixed) / 2, (max(yy, 0) - mixed) / 2
    shares[[0, 2], [0, 2]], shares[[0, 2], [2, 0]] = (mixed + xy) / 4, (mixed - xy) / 4
    shares[1, 1] = 1 - shares.sum()
    return shares


def _ellipse(covariance):
    """Shares (2r+1, 2r+1) of the cells in an even ellipse of this covariance (2,2) round the middle of one."""
    size, axes = np.linalg.eigh(covariance)
    half = axes * (2 * np.sqrt(np.maximum(size, _SMALL / 100))) @ axes.T
    angle = np.arange(_SIDES) * (2 * np.pi / _SIDES)
    rim = half @ np.stack([np.cos(angle), np.sin(angle)])
    reach = int(np.ceil(np.abs(rim).max() - 0.5))
    width = 2 * reach + 1
    rim += reach + 0.5
    area = edge_coverage(rim, np.roll(rim, -1, axis=1), np.ones((1, _SIDES)), (width, width))[0]
    area = np.maximum(area, 0.0)
    return area / area.sum()


def representatives(moments):
    """Second moments (3,) that stand for those of n texels, moments (3,n), and the weights (n,) of each, or 1: the
    blend has a texel's own. They lie on a lattice along the directions in which the moments vary."""
    if not moments.size:
        return
    largest = moments[:2].max()
    if np.ptp(moments, axis=1).max() <= _EVEN * largest:
        yield moments.mean(1), 1.0
        return
    middle = moments.mean(1)
    off = moments - middle[:, None]
    directions = np.linalg.eigh(off @ off.T)[1].T
    along = directions @ off
    axes = []
    for place in along:
        low, high = place.min(), place.max()
        steps = int(min(np.ceil((high - low) / (_APART * largest) - _ALIKE), _MOST))
        if steps < 1:
            axes.append([(0.0, 1.0)])
            continue
        width = (high - low) / steps
        nodes = low + width * np.arange(steps + 1)
        axes.append([(node, np.maximum(1 - np.abs(place - node) / width, 0)) for node in nodes])
    for chosen in product(*axes):
        weight = np.ones(moments.shape[1]) * chosen[0][1] * chosen[1][1] * chosen[2][1]
        if weight.any():
            yield middle + np.array([node for node, _ in chosen]) @ directions, weight
