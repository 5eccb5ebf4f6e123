"""Text that leaves nothing behind, axes, labels that keep apart, and pictures of odd charts."""

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

bpy = pytest.importorskip("bpy")

from dapple.kernels.chart.chart import Row, marked  # noqa: E402
from dapple.operators.chart.canvas import Canvas  # noqa: E402
from dapple.operators.chart.lettering import lettering  # noqa: E402
from dapple.operators.chart.picture import HEIGHT, SCALE, WIDTH, draw  # noqa: E402
from dapple.operators.chart.plot import Plot, plain, power, reach  # noqa: E402

KINDS = "objects", "curves", "fonts", "meshes"


def data():
    """What the file holds."""
    return {kind: {item.name for item in getattr(bpy.data, kind)} for kind in KINDS}


def test_letters_have_a_width_and_leave_nothing_in_the_file(empty_scene):
    before, canvas = data(), Canvas(200, 40)
    with lettering() as letters:
        assert letters.width("mm", 10) == pytest.approx(2 * letters.width("m", 10), rel=0.15)
        assert letters.width("m", 20) == pytest.approx(2 * letters.width("m", 10))
        assert letters.width("", 10) == 0.0
        letters.draw(canvas, 190, 10, "error", 12, (0, 0, 0), align=1.0)
        left = np.flatnonzero((canvas.pixels[..., 0] < 1).any(0)).min() / canvas.scale
        assert left == pytest.approx(190 - letters.width("error", 12), abs=1.5)
    assert data() == before
    with pytest.raises(RuntimeError), lettering():
        raise RuntimeError
    assert data() == before


def test_numbers_in_writing():
    assert [power(k) for k in (-5, -2, 0, 1, 3)] == ["10⁻⁵", "0.01", "1", "10", "10³"]
    assert [plain(v) for v in (0.02, 1.4e-5, 0.0011)] == ["0.02", "1 × 10⁻⁵", "0.001"]


def test_axes_reach_as_far_as_asked():
    low, high = reach([0.1], 30, 2.0)
    assert (high / low, low * high) == (pytest.approx(30), pytest.approx(0.01))
    assert reach([0.01, 100.0], 30, 2.0) == pytest.approx((0.005, 200.0))


def test_labels_keep_off_each_other_and_in_the_frame(empty_scene):
    with lettering() as letters:
        plot = Plot(Canvas(300, 200), letters, (50, 30, 290, 190), (0.01, 1.0), (1e-3, 1.0))
        assert plot.at(0.1, 1.0).tolist() == [pytest.approx(170), pytest.approx(190)]
        place = plot.at([0.9], [0.5])
        for text in ("one", "another", "a third"):
            plot.label(place, text, 11, (0, 0, 0))
        boxes = [taken[:4] for taken in plot._taken]
    assert len(boxes) == 3
    assert all(box[0] >= 50 and box[1] >= 30 and box[2] <= 290 and box[3] <= 190 for box in boxes)
    for k, (a, b, c, d) in enumerate(boxes):
        assert not any(a < right and left < c and b < top and low < d for left, low, right, top in boxes[:k])


def row(rung, seconds, error, **more):
    return Row(rung, "0.1", rung, None, seconds, 1, error, error, error, 0.0, **more)


@pytest.mark.parametrize(
    "rows",
    [
        [row("photon_splat", 0.5, 0.02)],
        [row("flat", 1e-4, np.inf), row("photon_splat", 100.0, 1e-12), row("auto", 1.0, 0.1)],
        [row("Cycles", 3.0, 0.4, peer=True), row("auto", 1.0, 0.0)],
    ],
    ids=["one", "extremes", "a peer and no rung"],
)
def test_odd_charts_are_drawn(empty_scene, rows):
    chart = SimpleNamespace(rows=marked(rows, 1e-6), reference=SimpleNamespace(error=1e-6))
    picture = np.array(Image.open(io.BytesIO(draw(chart, "A title", ["a line"]))))
    assert picture.shape == (round(HEIGHT * SCALE), round(WIDTH * SCALE), 3)
    assert (picture < 128).any()


def test_stars_that_touch_have_one_label(empty_scene, monkeypatch):
    said = []
    monkeypatch.setattr(Plot, "label", lambda plot, points, text, size, colour: said.append(text))
    near = [row("auto", 0.1, 0.01), row("auto", 0.101, 0.0101), row("auto", 5.0, 1e-4)]
    rows = [replace(one, label=name) for one, name in zip(near, ("Draft", "Preview", "Final"), strict=True)]
    draw(SimpleNamespace(rows=marked(rows, 1e-6), reference=SimpleNamespace(error=1e-6)), "", [])
    assert [text for text in said if "auto" in text] == ["auto, Draft + Preview", "auto, Final"]


def test_curves_say_what_part_of_the_light_they_have(empty_scene, monkeypatch):
    said = []
    monkeypatch.setattr(Plot, "label", lambda plot, points, text, size, colour: said.append(text))
    rows = [row("Cycles", 3.0, 0.4, peer=True), row("flat", 0.01, 0.1), row("caustic_map", 0.1, 0.2)]
    rows = [replace(one, energy=energy) for one, energy in zip(rows, (-0.36, 0.003, 0.12), strict=True)]
    draw(SimpleNamespace(rows=marked(rows, 1e-6), reference=SimpleNamespace(error=1e-6)), "", [])
    assert {"Cycles: 64 % of the light", "flat", "caustic_map: 112 % of the light"} <= set(said)
