"""Two million triangles: right, and in memory that a workstation has."""

import subprocess
import sys

import numpy as np
from waves import OBLIQUE, five_sines

from dapple.tests.stability.judge import COMPLETE, METHODS, NOT_MEANS, ONE_PATH, SAMPLED, judge
from dapple.tests.stability.photons import Expected, refract

SIDE = 16
MOST = 2.0  # GiB
_RUN = """
import pathlib, sys
import numpy as np
sys.path.insert(0, sys.argv[1] + "/tests")
import conftest
from dapple.tests.stability.judge import run
from waves import pool

scene = pool(quads=1000)
answer = run(scene, 16, sys.argv[2])
np.savez(sys.argv[3], image=answer.images[0], status=answer.status[0])
# Not getrusage, in which a child's peak begins with that of the process that started it.
status = pathlib.Path("/proc/self/status")
lines = status.read_text().splitlines() if status.exists() else ["VmHWM: 0"]
peak = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:")) / 2**20
print(len(scene.water.triangles), peak, sep="\\n")
for sentence in answer.diagnostics.left_out:
    print(sentence)
"""


def true_waves(resolution, count=1400, side=4.0, width=4.8):
    """Expected under the true waves, no mesh: photons stratified over the water, two draws."""
    d = np.array(OBLIQUE) / np.linalg.norm(OBLIQUE)
    images = []
    for seed in (0, 1):
        i, j = np.indices((count, count))
        x, y = ((k + np.random.default_rng([seed, n]).random(i.shape)).ravel() for n, k in enumerate((i, j)))
        x, y = (v * width / count - width / 2 for v in (x, y))
        height, slope_x, slope_y = five_sines(x, y)
        n = np.stack([-slope_x, -slope_y, np.ones_like(x)], 1)
        t, passed = refract(d, n, 1.333)
        flux = passed * -(n @ d) * (width / count) ** 2 / (side / resolution) ** 2
        down = -(1.5 + height) / t[:, 2]
        cell = [np.floor((v + down * t[:, k]) / side * resolution + resolution / 2) for k, v in enumerate((x, y))]
        inside = np.all([(c >= 0) & (c < resolution) for c in cell], axis=0)
        flat = (cell[1] * resolution + cell[0])[inside].astype(int)
        images.append(np.bincount(flat, flux[inside], resolution**2).reshape(resolution, resolution))
    return Expected(((images[0] + images[1]) / 2,), (np.abs(images[0] - images[1]) / 2,))


def test_two_million_triangles(row, root, tmp_path):
    """The pool's waves on two million triangles

    Photons that know the waves in closed form, no mesh: the mesh has no error left to speak of. Each method runs in a
    process of its own, which may take 2 GiB at most.
    """
    expected = true_waves(SIDE)
    tolerance, worst = 2e-3, 0.1
    row.tolerance = f"{tolerance:g}, {worst:g}; {MOST:g} GiB"
    memory, bad = {}, []
    for method in METHODS:
        path = tmp_path / "answer.npz"
        done = subprocess.run(
            [sys.executable, "-c", _RUN, str(root), method, str(path)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        triangles, peak, *left_out = done.stdout.splitlines()
        assert int(triangles) == 2_000_000
        memory[method] = float(peak)
        allowed = (tolerance + 4e-3, 0.5) if method in SAMPLED else (tolerance, worst)
        with np.load(path) as answer:
            verdict = judge(
                [answer["image"]],
                [answer["status"]],
                left_out,
                expected,
                *allowed,
                [ONE_PATH, NOT_MEANS],
            )
        row.cells[method] = verdict
        if verdict.outcome == "wrong" or (verdict.outcome == "reported" and method in COMPLETE):
            bad.append(f"{method}: {verdict.outcome}, {verdict.why}")
    assert not bad, "; ".join(bad)
    assert max(memory.values()) < MOST, memory
