"""How much the vertices deserve to be smoothed, by generalised cross-validation [1].

V(lambda) = |z - A z|^2 / n / (1 - tr A / n)^2 estimates, without knowing the true water, the mean squared error of
predicting a vertex from the others, A being the fit to the vertices; its trace is taken with one random probe [2].
From much smoothing to little, lambda falls as long as a rung makes the prediction better by a twentieth, or several do
by three tenths. Noise that differs from vertex to vertex stops it at V's minimum. So does the error of interpolated
iso-surfaces, which follows the cells that they were made from: there V creeps down, taking that error for waves.

[1] Craven & Wahba 1978, Smoothing noisy data with spline functions.
[2] Girard 1989, A fast Monte-Carlo cross-validation procedure for large least squares problems with noisy data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bspline import Samples
from .fit import coarse_lattice, detrended, solve

LADDER = (0.6, 0.2, 0.06, 0.02, 0.006, 0.002)  # the last is right for vertices that lie on the surface
ON_THE_SURFACE = 0.006  # and so is this, or a little noise
_PAYS, _LEAPS = 0.95, 0.7  # of the predicted error, from one rung to the next, and to any
_ROUGHER = 1.5  # times the slopes' deviation
_WINDOW = 1500  # vertices that are looked at
_TOLERANCE = 1e-4, 1e-2  # of the fit to the vertices, and to the probe


@dataclass(frozen=True)
class Smoothing:
    """A lambda, None for one that is still to be chosen, and the roughness of the water that it was chosen on: the
    standard deviation of its slopes."""

    value: float | None = None
    roughness: float = 0.0

    def settled(self, points, slopes, distance):
        """The Smoothing for a frame with points (n,3) [m], slopes (2,n) there, and typical distance [m] of the points:
        this one, or on water that is rougher by half its own, since still water has nothing to choose it by."""
        window, roughness = _roughest(points[:, :2], slopes)
        if self.value is None or roughness > _ROUGHER * self.roughness:
            return Smoothing(choose_smoothing(points[window], distance), roughness)
        return self


def choose_smoothing(points, distance):
    """The lambda of `fit.fit` for points (n,3) [m], whose typical distance is `distance` [m]."""
    rest, _ = detrended(points)
    lattice = coarse_lattice(points[:, :2], distance).halved()
    samples = Samples(lattice, points[:, 0], points[:, 1])
    per_cell = len(rest) / (lattice.cells[0] * lattice.cells[1])
    probe = np.where(np.random.default_rng(0).random(len(rest)) < 0.5, -1.0, 1.0)
    errors = []
    c = of_probe = np.zeros(lattice.shape)
    for smoothing in LADDER:
        c = solve(samples, rest, smoothing * per_cell, c, _TOLERANCE[0])
        of_probe = solve(samples, probe, smoothing * per_cell, of_probe, _TOLERANCE[1])
        freedom = 1 - (probe @ samples.values(of_probe)) / len(rest)
        errors.append(np.sqrt(((rest - samples.values(c)) ** 2).mean()) / max(freedom, np.finfo(float).tiny))
    return LADDER[_last_that_pays(errors)]


def _last_that_pays(errors):
    """The rung at which to stop, by the errors predicted on all."""
    rung = 0
    for k, error in enumerate(errors):
        if error < errors[rung] * (_PAYS if k == rung + 1 else _LEAPS):
            rung = k
    return rung


def _roughest(plan, slopes):
    """Indices of about _WINDOW of the points plan (n,2), those of the box in which the slopes (2,n) vary most; and the
    slopes' standard deviation there."""
    boxes = max(1, round(np.sqrt(len(plan) / _WINDOW)))
    low, high = plan.min(0), plan.max(0)
    place = np.clip((plan - low) / np.maximum(high - low, np.finfo(float).tiny) * boxes, 0, boxes - 1).astype(int)
    box = place[:, 1] * boxes + place[:, 0]
    count = np.maximum(np.bincount(box), 1)
    varied = sum(np.bincount(box, s * s) - np.bincount(box, s) ** 2 / count for s in slopes)
    chosen = np.argmax(varied)
    return np.flatnonzero(box == chosen), float(np.sqrt(max(varied[chosen], 0.0) / count[chosen]))
