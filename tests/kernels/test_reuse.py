"""What texels keep from frame to frame: the average in closed form, what is rejected, and the books."""

from dataclasses import replace

import numpy as np
import pytest
from waves import floor, pool, quad

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.reuse import Reuse
from dapple.kernels.scene import Diagnostics, Settings, Solution
from dapple.kernels.status import Status

SIDE, SHARE = 16, 0.8


def frame(receiver, value):
    """A Scene with one receiver, its Texels, and a Solution of irradiance `value` on it."""
    scene, own = pool(receivers=[receiver], quads=2), rasterise(receiver, SIDE)
    light = np.full((len(own.texel), 3), float(value))
    work = Diagnostics("test", "", flux_received={receiver.name: own.area @ light}, estimated_error=0.01)
    status = np.where(own.image(light)[..., 0] > 0, Status.LIT, Status.DARK).astype(np.uint8)
    return scene, (own,), Solution((own.image(light),), (status,), work)


def test_a_step_decays_as_the_share_to_the_frames_since():
    reuse = Reuse(SHARE)
    reuse.apply(*frame(floor(), 1.0))
    for k in range(1, 6):
        answer = reuse.apply(*frame(floor(), 0.0))
        np.testing.assert_allclose(answer.images[0], SHARE**k, rtol=1e-12)
        assert (answer.status[0] == Status.LIT).all()
    assert "trail" in answer.diagnostics.left_out[-1]


def test_books_and_estimate_take_in_what_was_kept():
    reuse = Reuse(SHARE)
    reuse.apply(*frame(floor(), 3.0))
    work = reuse.apply(*frame(floor(), 1.0)).diagnostics
    np.testing.assert_allclose(work.flux_received["Floor"], 16 * (0.8 * 3 + 0.2), rtol=1e-12)
    np.testing.assert_allclose(work.flux_received["Floor"] + work.flux_lost["reused"], 16, rtol=1e-12)
    assert work.estimated_error == pytest.approx((0.1 + 1.6) ** 2)  # it is off by 1.6 of a mean of 1
    assert work.texels == {"lit": SIDE**2}


def test_nothing_is_kept_with_a_share_of_0():
    reuse = Reuse(0.0)
    reuse.apply(*frame(floor(), 1.0))
    given = frame(floor(), 0.5)
    assert reuse.apply(*given) is given[2]


def moved(x=0.0, z=0.0, tilt=0.0):
    """The floor, moved and tilted about the y axis."""
    half, rise = 2 * np.cos(tilt), 2 * np.sin(tilt)
    low, high = (x - half, z - rise), (x + half, z + rise)
    return quad("Floor", [[low[0], -2, low[1]], [high[0], -2, high[1]], [high[0], 2, high[1]], [low[0], 2, low[1]]])


RADIUS = 4 / SIDE / np.sqrt(np.pi)  # of a texel


@pytest.mark.parametrize(
    ("after", "kept"),
    [
        (moved(x=0.9 * RADIUS), True),
        (moved(x=1.1 * RADIUS), False),
        (moved(z=0.9 * RADIUS), True),
        (moved(z=1.1 * RADIUS), False),
        (replace(moved(), name="Other"), False),
    ],
    ids=["slides a little", "slides off", "sinks a little", "sinks", "another"],
)
def test_what_is_not_where_it_was_starts_anew(after, kept):
    reuse = Reuse(SHARE)
    reuse.apply(*frame(moved(), 1.0))
    image = reuse.apply(*frame(after, 0.0)).images[0]
    np.testing.assert_allclose(image, SHARE if kept else 0.0, atol=1e-12)


@pytest.mark.parametrize(("cosine", "kept"), [(0.91, True), (0.89, False)])
def test_what_has_turned_starts_anew(cosine, kept):
    """On the axis that it turns about a texel is where it was: its normal alone decides."""
    reuse = Reuse(SHARE)
    reuse.apply(*frame(moved(), 1.0))
    image = reuse.apply(*frame(moved(tilt=np.arccos(cosine)), 0.0)).images[0][:, SIDE // 2]
    np.testing.assert_allclose(image, SHARE if kept else 0.0, atol=1e-12)


def test_noise_falls_to_the_variance_of_the_average():
    """Of independent frames of one still scene: by (1 - share) / (1 + share), and the mean stays."""
    scene = pool(quads=24)
    texels, reuse = (rasterise(floor(), 32),), Reuse(SHARE)
    truth = solve(scene, texels, Settings(tolerance=1e-5, surface="mesh")).images[0]
    single, kept = [], []
    for k in range(40):
        new = solve(scene, texels, Settings(tolerance=0.3, points=True, seed=k, surface="mesh"))
        single.append(((new.images[0] - truth) ** 2).mean())
        kept.append(((reuse.apply(scene, texels, new).images[0] - truth) ** 2).mean())
    assert np.mean(kept[20:]) / np.mean(single) == pytest.approx((1 - SHARE) / (1 + SHARE), rel=0.25)


@pytest.mark.parametrize("share", [-0.1, 1.0])
def test_an_impossible_share_is_told(share):
    with pytest.raises(ValueError, match="reuse must be a share"):
        Reuse(share)
