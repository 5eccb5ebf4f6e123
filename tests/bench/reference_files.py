"""References are made once and kept in a folder that git ignores, with the error that two replicas show."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .reference_mesh import by_mesh
from .reference_waves import by_waves

FOLDER = Path(__file__).parent / "references"
# cells along a texel's side, in two replicas that share no lattice
_WAVE_CELLS = 7.0, 7.6
_MESH_CELLS = 1.8, 2.2
_COARSE = 0.7  # of these cells over an uneven floor, where landing takes most of the time
_DISC_CELLS = 2.4
_DISC_DIRECTIONS = 64  # in each replica


@dataclass(frozen=True)
class Reference:
    """image (H,W) [W/m^2], the mean of two replicas; error: mean squared difference of the two over the mean square.
    That is four times the variance of the mean were they independent; they share a part of their bias."""

    image: np.ndarray
    error: float

    def judge(self, image):
        """Mean squared error of an image (H,W) over the reference's mean square, the same over its squared mean, and
        the relative error of the whole flux."""
        squared = ((image - self.image) ** 2).mean()
        mean = self.image.mean()
        return squared / (self.image**2).mean(), squared / mean**2, image.mean() / mean - 1


def of_waves(pond, resolution):
    """The Reference of the true waves of a Pond, averaged over its sun's disc."""
    cells = pond.side / pond.floor.side * resolution * _coarseness(pond)

    def replica(number):
        if not pond.angle:
            return pond_by_waves(pond, pond.direction, resolution, round(cells * _WAVE_CELLS[number]))
        directions = disc(pond.direction, pond.angle, _DISC_DIRECTIONS, number * 1.2)
        sizes = np.round(cells * _DISC_CELLS * (1 + 0.1 * np.arange(len(directions)) / len(directions))).astype(int)
        parts = zip(directions, sizes, strict=True)
        return sum(pond_by_waves(pond, one, resolution, size) for one, size in parts) / len(directions)

    return _kept(replica, "waves", resolution, pond, _WAVE_CELLS, _DISC_CELLS, _DISC_DIRECTIONS, _COARSE)


def pond_by_waves(pond, direction, resolution, cells):
    """`by_waves` of a Pond under light along one direction."""
    return by_waves(pond.waves, pond.depth, *pond.bounds, direction, pond.eta, pond.floor, resolution, cells)


def of_mesh(pond, water, resolution):
    """The Reference of a Water over a Pond's floor, as the mesh is."""
    corners, normals = water.positions[water.triangles], water.normals[water.normal_triangles]
    edge = pond.side / np.sqrt(len(corners) / 2) / pond.floor.side * resolution * _coarseness(pond)

    def replica(number):
        parts = max(2 + number, round(edge * _MESH_CELLS[number]))
        return by_mesh(corners, normals, pond.direction, pond.eta, pond.floor, resolution, parts)

    return _kept(replica, "mesh", resolution, pond, corners.tobytes(), normals.tobytes(), _MESH_CELLS, _COARSE)


def _coarseness(pond):
    return 1.0 if pond.floor.relief is None else _COARSE


def disc(direction, angle, count, turn):
    """`count` unit directions (count,3) spread evenly over a disc of diameter `angle` [rad] about a direction: a
    sunflower, turned by `turn` [rad]."""
    across = np.cross(direction, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    along = np.cross(direction, across)
    sine = np.sin(angle / 2) * np.sqrt((np.arange(count) + 0.5) / count)
    azimuth = np.arange(count) * np.pi * (3 - np.sqrt(5)) + turn
    sideways = sine[:, None] * (np.cos(azimuth)[:, None] * across + np.sin(azimuth)[:, None] * along)
    return sideways + np.sqrt(1 - sine**2)[:, None] * direction


def _kept(replica, kind, *key):
    """The Reference of replica(0) and replica(1): from its file where `key` and the code are those of the file."""
    digest = hashlib.sha256(repr(key).encode())
    for source in sorted(Path(__file__).parent.glob("reference_*.py")):
        digest.update(source.read_bytes())
    path = FOLDER / f"{kind}_{digest.hexdigest()[:16]}.npz"
    if not path.exists():
        first, second = replica(0), replica(1)
        image = (first + second) / 2
        error = ((first - second) ** 2).mean() / (image**2).mean()
        FOLDER.mkdir(exist_ok=True)
        np.savez(path, image=image, error=error)
    kept = np.load(path)
    return Reference(kept["image"], float(kept["error"]))
