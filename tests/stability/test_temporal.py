"""In time: what stands still stays, what travels shifts, and slow waves do not flicker."""

import hashlib
import subprocess
import sys

import numpy as np
from waves import AMPLITUDE, HEADING, PHASE, WAVELENGTH, pool

from dapple.tests.stability.judge import METHODS, Verdict, run

SIDE = 32
TEXEL = 4.0 / SIDE
_HASH = """
import hashlib, sys
sys.path.insert(0, sys.argv[1] + "/tests")
import conftest
from dapple.tests.stability.judge import METHODS, run
from waves import pool

scene = pool(quads=48)
for method in METHODS:
    print(hashlib.sha256(run(scene, 32, method).images[0].tobytes()).hexdigest())
"""


def test_a_static_scene_gives_the_same_bits(row, root):
    """A static scene, baked again in the same process and in fresh ones

    Nothing moves, so no bit may differ: no seed, clock, address or order of threads is in the answer.
    """
    row.tolerance = "0"
    scene = pool(quads=48)
    here = [[hashlib.sha256(run(scene, SIDE, m).images[0].tobytes()).hexdigest() for m in METHODS] for _ in range(2)]
    fresh = [
        subprocess.run([sys.executable, "-c", _HASH, str(root)], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    row.cells = {m: Verdict("right", "", 0.0) for m in METHODS}
    assert here[0] == here[1] == fresh[0].split() == fresh[1].split()


def waves_at(time=0.0, shift=0.0):
    """The pool's waves after `time` s, moved by `shift` m along x: height and slopes of (x, y)."""
    k = 2 * np.pi / WAVELENGTH

    def shape(x, y):
        phase = k * ((x[..., None] - shift) * np.cos(HEADING) + y[..., None] * np.sin(HEADING)) + PHASE
        phase = phase - np.sqrt(9.81 * k) * time
        slope = AMPLITUDE * k * np.cos(phase)
        return (AMPLITUDE * np.sin(phase)).sum(-1), (slope * np.cos(HEADING)).sum(-1), (slope * np.sin(HEADING)).sum(-1)

    return shape


def relative(a, b):
    """Relative mean squared error of a against b."""
    return float(((a - b) ** 2).mean() / b.mean() ** 2)


def shifted(first, second):
    """Two maps (H,W), the second of waves one texel further along x, cut to the texels that both know."""
    return first[1:-1, 1:-2], second[1:-1, 2:-1]
