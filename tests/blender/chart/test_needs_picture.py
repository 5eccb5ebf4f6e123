"""The bars of what a scene needs: as long as the errors are large, in the colour that the tolerance gives them."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("bpy")

from dapple.operators.chart.needs_picture import draw


def bars(needs):
    """Orange and grey pixels of each row of the picture of (term, change) at a tolerance of 0.01."""
    made = [SimpleNamespace(term=term, change=change, seconds=0.1, of=1.0) for term, change in needs]
    pixels = np.array(Image.open(io.BytesIO(draw(made, "Title", "line", 0.01)))).astype(int)
    orange = np.abs(pixels - [214, 94, 0]).max(2) < 3
    grey = np.abs(pixels - [184, 184, 191]).max(2) < 3
    return orange.sum(1), grey.sum(1)


def test_what_is_needed_is_orange_and_the_rest_grey(empty_scene):
    orange, grey = bars([("fresnel", 1e-3), ("disc", 0.1), ("absorption", 0.0)])
    rows = np.flatnonzero(orange)
    assert len(rows) > 20
    assert np.ptp(rows) == len(rows) - 1  # one bar
    # 0.1 is six of seven powers of ten from the least, 0.001 four.
    assert orange.max() / grey.max() == pytest.approx(6 / 4, rel=0.01)
    assert np.flatnonzero(grey == grey.max()).min() > rows.max()


def test_a_change_beyond_the_axis_is_cut(empty_scene):
    orange, _ = bars([("occlusion", 5.0), ("some new term", 1e-12)])
    assert orange.max() == pytest.approx(500 * 1.5, abs=3)
