"""Right, reported or wrong: what each method makes of a construction, against what is expected.

Right: every texel within the stated tolerance. Reported: not right, but each texel that is off carries a status that
says why, or a sentence in `left_out` does. Wrong: off, and silent.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings
from dapple.kernels.status import Status

METHODS = {
    "auto": Settings(method="auto", tolerance=1e-3),
    "beams": Settings(method="photon_splat", tolerance=1e-4),
    "points": Settings(method="photon_splat", tolerance=1e-3, points=True),
    "all roots": Settings(method="conic_walk", tolerance=1e-3),
    "first root": Settings(method="conic_walk", first_root=True),
}
RUNGS = {
    "flat": Settings(method="flat"),
    "sun map": Settings(method="sun_map"),
    "caustic map": Settings(method="caustic_map", grid=128),
}  # methods that make do with less, and say by how much they may be off
RUNG_TOLERANCE = 1e-2  # that of Preview
_DOUBT = 4  # times what a rung says of its error: more is wrong
COMPLETE = ("auto", "beams", "points", "all roots")  # methods that are to find all of the light
EVERY = (*COMPLETE, "first root")
SAMPLED = ("auto", "points", "all roots")  # as exact as the tolerance that they are asked for
_POINTS = 8
ONE_PATH = r"every path to a texel but the first"
NOT_MEANS = r"the mean over the texel"
TWICE = r"meets the water twice"
WOUND = r"wound against their neighbours"
EXPLAINING = (
    Status.NO_WATER,
    Status.OFF_THE_RIM,
    Status.NO_ROOT,
    Status.BLOCKED,
    Status.TORN,
    Status.LOST,
    Status.INCOMPLETE,
)


@dataclass(frozen=True)
class Verdict:
    """outcome: right, reported or wrong; why: the error found, the statuses or the sentence; error: mean squared
    error of all texels, over the squared mean by `judge`, over the mean square by `judge_rung`."""

    outcome: str
    why: str
    error: float


def run(scene, resolution, method, surface="mesh"):
    """Solution of a Scene by one of METHODS, by the water's mesh or the smooth water ("auto") that it samples.

    The first root knows points only: its map is the mean over 8 x 8 points a texel, with the most
    telling status.
    """
    settings = replace({**METHODS, **RUNGS}[method], surface=surface)
    points = _POINTS if settings.first_root else 1
    texels = [rasterise(receiver, resolution * points, settings.padding) for receiver in scene.receivers]
    answer = solve(scene, texels, settings)
    if points == 1:
        return answer
    shape = (resolution, points, resolution, points)
    images = tuple(i.reshape(*shape, 3).mean((1, 3)) for i in answer.images)
    return replace(answer, images=images, status=tuple(s.reshape(shape).max((1, 3)) for s in answer.status))


def judge(images, statuses, left_out, expected, tolerance, worst, sentences=()):
    """Verdict on the images (H,W,3) and statuses (H,W) of a Solution and the sentences of its `left_out`.

    expected: `photons.Expected`; tolerance: mean squared error over the squared mean, beyond the expectation's noise;
    worst: how far a single texel may be off, as a part of what is expected there, or of the mean where that is more,
    beyond four standard errors; sentences: regular expressions, one of which `left_out` must match where statuses do
    not tell.
    """
    image = np.concatenate([i[..., 0].ravel() for i in images])
    status = np.concatenate([s.ravel() for s in statuses])
    wanted, noise = (np.concatenate([i.ravel() for i in part]) for part in (expected.images, expected.errors))
    owned = status != Status.EMPTY
    image, status, wanted, noise = image[owned], status[owned], wanted[owned], noise[owned]
    assert (np.isfinite(image) & (image >= 0)).all(), "light that is negative or no number is never right"
    mean = wanted.mean() or 1.0
    # Two draws tell the noise of a texel roughly, that of all texels together well: take the larger of both.
    noise = np.maximum(noise, np.sqrt((noise**2).mean()) * np.sqrt(np.maximum(wanted, mean) / mean))
    squared = (image - wanted) ** 2 - noise**2
    error = squared.mean() / mean**2
    off = np.abs(image - wanted) > worst * np.maximum(wanted, mean) + 4 * noise
    if error <= tolerance and not off.any():
        return Verdict("right", f"{max(error, 0):.1e}", error)
    told = np.isin(status, EXPLAINING)
    if told.any() and not (off & ~told).any() and squared[~told].sum() <= tolerance * mean**2 * len(image):
        names = ", ".join(f"{(status == s).sum()} {s.name.lower()}" for s in EXPLAINING if (status == s).any())
        return Verdict("reported", f"status of texels: {names}", error)
    for sentence in sentences:
        for said in left_out:
            if re.search(sentence, said):
                return Verdict("reported", f"left out: {said}", error)
    return Verdict("wrong", f"error {error:.1e}, {off.sum()} of {len(off)} texels off and silent", error)


def judge_rung(answer, expected):
    """Verdict on a Solution by one of RUNGS: right within RUNG_TOLERANCE; reported where its estimated error says how
    far it is off, within a factor of 4, or that it is of no use, or where water wound against itself is said."""
    image = np.concatenate([i[..., 0].ravel() for i in answer.images])
    owned = np.concatenate([s.ravel() for s in answer.status]) != Status.EMPTY
    wanted, noise = (np.concatenate([i.ravel() for i in part])[owned] for part in (expected.images, expected.errors))
    assert (np.isfinite(image) & (image >= 0)).all(), "light that is negative or no number is never right"
    error = ((image[owned] - wanted) ** 2 - noise**2).mean() / ((wanted**2).mean() or 1.0)
    if error <= RUNG_TOLERANCE:
        return Verdict("right", f"{max(error, 0):.1e}", error)
    estimate = answer.diagnostics.estimated_error
    if estimate is not None and (estimate >= 1 or error <= RUNG_TOLERANCE + _DOUBT * estimate):
        return Verdict("reported", "its estimated error", error)
    for said in answer.diagnostics.left_out:
        if re.search(WOUND, said):
            return Verdict("reported", f"left out: {said}", error)
    return Verdict("wrong", f"error {error:.1e}, estimated {estimate}", error)
