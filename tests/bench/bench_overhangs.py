"""How far the normals of overhanging waves are off, as meshed and reconstructed: for docs/surface.md.

Run as `.venv/bin/python tests/bench/bench_overhangs.py`; it prints the table as it goes and writes it to
docs/surface_overhangs.md. Errors are root mean squares, in milliradians, at the vertices of 3 x 3 parts of the mesh's
triangles, half a metre from the water's rim.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent))

from bench_stages import ROOT, Table, load_dapple, machine

PARTS, SIDE, RIM = 3, 4.8, 0.5
QUADS = (64, 96, 128, 192)
BANDS = (("underside", -1.0, -0.2), ("upright", -0.2, 0.5), ("leaning", 0.5, 0.9), ("level", 0.9, 1.01))
COMMAND = "`.venv/bin/python tests/bench/bench_overhangs.py`"


def rows(name, wave, quads):
    """Rows of the table: one per band of the normal's z."""
    import numpy as np
    from overhangs import angles, meshed, parameters, straight

    from dapple.kernels.surface.smoothing import Smoothing
    from dapple.kernels.surface.splines import Splines
    from dapple.kernels.surface.tessellate import Tessellation

    mesh = meshed(wave, quads, SIDE)
    start = time.process_time()
    splines = Splines(mesh, Smoothing())
    seconds = time.process_time() - start
    everything = np.ones(len(mesh.triangles), bool)
    parts = Tessellation(mesh.triangles, mesh.twins, len(mesh.positions), everything, PARTS)
    groups = zip((parts.ends, parts.inner), parts.shares(), strict=True)
    points = [np.stack([splines.positions, splines.normals])[..., None]]
    points += [np.stack(splines.between(ends, shares)) for ends, shares in groups]
    positions, normals = (np.concatenate([p[k].reshape(3, -1) for p in points], 1).T for k in (0, 1))
    flat = straight(mesh, PARTS)
    start_at = parameters(quads, SIDE, PARTS)
    exact = wave.normals(flat.positions, start_at)
    raw = angles(flat, exact)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = np.linalg.norm(normals - wave.normals(positions, start_at), axis=1)
    inside = np.maximum(np.abs(start_at), np.abs(flat.positions[:, 1])) < SIDE / 2 - RIM
    for band, low, high in BANDS:
        here = inside & (exact[:, 2] >= low) & (exact[:, 2] < high)
        if here.any():
            one, other = (1e3 * np.sqrt((v[here] ** 2).mean()) for v in (raw, found))
            yield name, quads, band, f"{one:.2g}", f"{other:.2g}", f"{one / other:.1f}", f"{seconds:.2f}"


def main():
    load_dapple()
    from overhangs import Breaking, Trochoid

    table = Table()
    table.head("wave", "quads along a side", "where", "mesh [mrad]", "reconstructed [mrad]", "ratio", "CPU [s]")
    for name, wave in (("leaning crest", Breaking()), ("trochoids past their cusps", Trochoid())):
        for quads in QUADS:
            for row in rows(name, wave, quads):
                table.add(*row)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "surface_overhangs.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    main()
