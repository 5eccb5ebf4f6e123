"""What temporal reuse does to a still, a slow and a fast pool: error, flicker and lag, for docs/temporal.md.

Run as `.venv/bin/python tests/bench/bench_temporal.py`; it pins itself to one core, prints the table as it goes and
writes it to docs/temporal_tables.md, with a picture of one frame. References are beams of a tolerance of 1e-6 on the
same mesh. Points have another seed in every frame, as noise without reuse would.
"""

from __future__ import annotations

import os
import sys
from datetime import date
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent))

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_temporal.py`"
RESOLUTION, QUADS, FRAMES, WARM, RATE = 256, 128, 24, 10, 24.0
FLIPPED = 12, 18, 23  # frames that FLIP is evaluated on
SPEEDS = {"still": 0.0, "slow (a 20th)": 0.05, "true speed": 1.0}
METHODS = {"beams": {"tolerance": 1e-2}, "points": {"tolerance": 0.3, "points": True}}
SHARES = (0.0, 0.5, 0.8)
TITLES = ("waves", "method", "share", "error", "MAE", "FLIP", "flicker", "lag [frames]")


def at(seconds):
    """`shape(x, y)` of the pool's waves after some seconds, by the dispersion of deep water."""
    import numpy as np
    from waves import AMPLITUDE, HEADING, PHASE, WAVELENGTH

    k = 2 * np.pi / WAVELENGTH

    def shape(x, y):
        phase = k * (x[..., None] * np.cos(HEADING) + y[..., None] * np.sin(HEADING)) + PHASE
        phase = phase - np.sqrt(9.81 * k) * seconds
        slope = AMPLITUDE * k * np.cos(phase)
        height = (AMPLITUDE * np.sin(phase)).sum(-1)
        return height, (slope * np.cos(HEADING)).sum(-1), (slope * np.sin(HEADING)).sum(-1)

    return shape


def sequence(speed, **words):
    """Yield (Scene, Texels, Solution) of each frame."""
    from waves import floor, pool

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Settings

    texels = (rasterise(floor(), RESOLUTION),)
    for k in range(FRAMES):
        scene = pool(at(k * speed / RATE), quads=QUADS)
        yield scene, texels, solve(scene, texels, Settings(surface="mesh", seed=k, **words))


def kept(frames, share):
    """Images (FRAMES,H,W) of frames with a share of reuse."""
    import numpy as np

    from dapple.kernels.reuse import Reuse

    reuse = Reuse(share)
    return np.stack([reuse.apply(*frame).images[0][..., 0] for frame in frames])


def measures(images, truth):
    """Error over the mean square; mean absolute error over the mean; HDR-FLIP; flicker, the mean absolute second
    difference in time over the mean; lag, by how many frames' motion the pictures trail: what of the error lies along
    the way back to the frame before."""
    import flip_evaluator
    import numpy as np

    off = (images - truth)[WARM:]
    back = (truth[WARM - 1 : -1] - truth[WARM:]) if (truth[1:] != truth[:-1]).any() else None
    flicker = np.abs(np.diff(images[WARM:], 2, axis=0)).mean() / truth.mean()
    lag = float((off * back).sum() / (back**2).sum()) if back is not None else float("nan")
    mean = np.abs(off).mean() / truth[WARM:].mean()
    pairs = [[np.repeat(i[k][..., None], 3, 2).astype(np.float32) for i in (truth, images)] for k in FLIPPED]
    flip = np.mean([flip_evaluator.evaluate(*pair, "HDR")[1] for pair in pairs])
    return (off**2).mean() / (truth[WARM:] ** 2).mean(), mean, flip, flicker, lag


def measure(rows):
    """Print and add to `rows` a row for each speed, method and share; returns images for the picture."""
    pictures = {}
    for waves, speed in SPEEDS.items():
        truth = kept(list(sequence(speed, tolerance=1e-6)), 0.0)
        rows.add(waves, "reference", "", "", "", "", f"{measures(truth, truth)[3]:.3g}", "")
        for method, words in METHODS.items():
            frames = list(sequence(speed, **words))
            for share in SHARES:
                images = kept(frames, share)
                error, mean, flip, flicker, lag = measures(images, truth)
                cells = (
                    f"{error:.2g}",
                    f"{mean:.3g}",
                    f"{flip:.3f}",
                    f"{flicker:.3g}",
                    f"{lag:.2f}" if lag == lag else "",
                )
                rows.add(waves, method, f"{share:g}", *cells)
                pictures[waves, method, share] = images[-1]
        pictures[waves] = truth[-1]
    return pictures


def draw(pictures, path):
    """One frame of each speed: the reference, points without and with reuse, beams with."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    columns = {"reference": (), "points": ("points", 0.0), "points, 0.8": ("points", 0.8), "beams, 0.8": ("beams", 0.8)}
    figure, axes = plt.subplots(len(SPEEDS), len(columns), figsize=(10, 7.6), layout="constrained")
    for row, waves in zip(axes, SPEEDS, strict=True):
        for ax, (title, key) in zip(row, columns.items(), strict=True):
            image = pictures[waves, *key] if key else pictures[waves]
            ax.imshow(image[:128, :128], origin="lower", cmap="gray", vmin=0, vmax=4)
            ax.set(xticks=[], yticks=[], title=title if waves == "still" else "")
        row[0].set_ylabel(waves)
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    os.sched_setaffinity(0, {os.sched_getaffinity(0).pop()})
    load_dapple()
    rows = Table()
    rows.head(*TITLES)
    pictures = measure(rows)
    head = f"Measured on {date.today()} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "temporal_tables.md").write_text("\n".join([head, *rows.lines[1:], ""]), encoding="utf-8")
    draw(pictures, ROOT / "docs" / "images" / "temporal.png")
