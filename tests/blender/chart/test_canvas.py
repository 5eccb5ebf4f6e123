"""Shapes cover what geometry says, whichever way round they go, and PNG files hold what was drawn."""

import io

import numpy as np
import pytest
from PIL import Image

from dapple.operators.chart.canvas import Canvas

BLACK = (0.0, 0.0, 0.0)


def ink(canvas):
    """How much of the canvas is black [square units]."""
    return (1 - canvas.pixels[..., 0]).sum() / canvas.scale**2


@pytest.mark.parametrize("turn", [1, -1])
def test_a_triangle_covers_its_area(turn):
    canvas = Canvas(20, 10)
    canvas.fill([np.array([[1.3, 1.1], [9.2, 2.7], [4.4, 8.9]])[::turn]], BLACK)
    assert ink(canvas) == pytest.approx(abs(7.9 * 7.8 - 3.1 * 1.6) / 2)


def test_what_overlaps_counts_once_and_what_sticks_out_is_cut():
    canvas = Canvas(10, 10)
    square = np.array([[2.0, 2.0], [6.0, 2.0], [6.0, 6.0], [2.0, 6.0]])
    canvas.fill([square, square], BLACK)
    assert ink(canvas) == pytest.approx(16)
    canvas.box(8, 8, 5, 5, BLACK)
    assert ink(canvas) == pytest.approx(20)
    canvas.box(20, 20, 5, 5, BLACK)
    assert ink(canvas) == pytest.approx(20)


def test_alpha_and_colour():
    canvas = Canvas(4, 4, scale=1)
    canvas.box(1, 1, 2, 2, (1.0, 0.0, 0.0), alpha=0.5)
    assert canvas.pixels[1, 1].tolist() == [1.0, 0.5, 0.5]


def test_lines_have_their_width_and_dashes_their_share():
    canvas = Canvas(60, 10)
    canvas.line([(5, 5), (55, 5)], BLACK, 2.0, dash=(3, 2))
    assert ink(canvas) == pytest.approx(2 * 30, rel=0.02)
    canvas = Canvas(60, 10)
    canvas.line([(5, 5), (55, 5)], BLACK, 2.0)
    assert ink(canvas) == pytest.approx(2 * 50 + np.pi, rel=0.01)


def test_discs_and_stars():
    canvas = Canvas(20, 20)
    canvas.disc(10, 10, 6, BLACK)
    assert ink(canvas) == pytest.approx(np.pi * 36, rel=0.01)
    canvas = Canvas(20, 20)
    canvas.star(10, 10, 8, BLACK)
    assert ink(canvas) == pytest.approx(5 * 8 * 0.42 * 8 * np.sin(np.pi / 5), rel=1e-6)


def test_png_is_what_was_drawn_the_right_way_up():
    canvas = Canvas(6, 4, scale=1)
    canvas.box(0, 3, 1, 1, (0.0, 0.5, 1.0))
    picture = np.array(Image.open(io.BytesIO(canvas.png())))
    assert picture.shape == (4, 6, 3)
    assert picture[0, 0].tolist() == [0, 128, 255]
    assert (picture[1:] == 255).all()
