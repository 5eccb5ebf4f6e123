"""Pictures of maps beside their references, in one scale, and of the difference."""

from __future__ import annotations

import numpy as np

_BRIGHT = 5.0  # mean irradiances that are shown as white
_ASKED = 1e-2


def draw(case, path):
    """Draw a Case as Dapple bakes it, its reference and the difference, a row for each receiver."""
    from matplotlib import pyplot

    _, light, _ = case.bake(_ASKED)
    truth = case.reference.maps.light
    rows = list(zip(case.scene.receivers, case.images(light), case.images(truth), strict=True))
    figure, axes = pyplot.subplots(len(rows), 3, figsize=(9, 3.2 * len(rows)), squeeze=False)
    for row, (receiver, found, true) in zip(axes, rows, strict=True):
        white = _BRIGHT * true.mean() + 1e-12
        difference = np.clip(0.5 + (found - true).mean(2) / white, 0, 1)
        panels = (f"{receiver.name}: Dapple", _shown(found / white)), ("Mitsuba", _shown(true / white))
        for axis, (title, image) in zip(row, (*panels, ("difference", difference)), strict=True):
            axis.imshow(image, origin="lower", cmap="RdBu_r", vmin=0, vmax=1, interpolation="nearest")
            axis.set_title(title, fontsize=9)
            axis.axis("off")
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    pyplot.close(figure)


def _shown(image):
    """Linear light as sRGB shows it, by its power law."""
    return np.clip(image, 0, 1) ** (1 / 2.2)
