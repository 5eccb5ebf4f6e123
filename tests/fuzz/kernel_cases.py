"""Small scenes, sound and unsound, for every method: what `methods.solve` must answer or refuse in a sentence."""

from functools import partial

import numpy as np
from hypothesis import strategies as st

from dapple.kernels.casters import Caster, Glass, Mirror, Volume
from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, solve
from dapple.kernels.scene import SURFACES, Occluder, Point, Receiver, Scene, Settings, Spot, Sun, Water
from dapple.tests.waves import grid

BAD = (np.nan, np.inf, -np.inf, 1e300, -1e300, 1e30, 1e-300, 0.0, -1.0)
NUMBERS = st.one_of(st.sampled_from(BAD), st.floats(-3, 3), st.floats(allow_nan=True, allow_infinity=True))


def rarely(good, otherwise=NUMBERS, of=30):
    """A good value, or one time in so many something else."""
    return st.integers(0, of - 1).flatmap(lambda k: otherwise if k == 3 else st.just(good))


SPOILS = ("none",) * 16 + (
    "value",
    "normal",
    "flat",
    "line",
    "huge",
    "tiny",
    "far",
    "shuffled",
    "twice",
    "turned",
    "empty",
)
BOOKS = {"photon_splat": 1e-6}  # methods whose light adds up, and how exactly


@st.composite
def meshes(draw, level=1.0, spoils=SPOILS):
    """positions, triangles and normals of a small mesh near a height, often spoilt."""
    seed = draw(st.integers(0, 2**16))
    rng = np.random.default_rng(seed)
    kind = draw(st.sampled_from(("grid", "one", "soup", "body")))
    if kind == "grid":
        x, y, triangles = grid(draw(st.integers(1, 5)), 2.0)
        positions = np.stack([x, y, level + draw(st.sampled_from((0, 0.05, 0.5))) * rng.standard_normal(len(x))], 1)
    elif kind == "body":
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        positions = corners * rng.uniform(0.1, 1, 3) + (0, 0, level)
        faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    else:
        count = 1 if kind == "one" else draw(st.integers(2, 12))
        positions = rng.uniform(-1, 1, (3 * count, 3)) + np.array([0, 0, level])
        triangles = np.arange(3 * count).reshape(-1, 3)
    return spoilt(draw, rng, positions, triangles, spoils)


def spoilt(draw, rng, positions, triangles, spoils):
    """positions, triangles and normals after a spoil that is drawn."""
    spoil = draw(st.sampled_from(spoils))
    if spoil == "value":
        positions[rng.integers(len(positions)), rng.integers(3)] = draw(NUMBERS)
    elif spoil == "flat":
        positions[:, draw(st.integers(0, 2))] = draw(st.sampled_from((0.0, 1.0)))
    elif spoil == "line":
        positions[:, :2] = 0.0
    elif spoil in ("huge", "tiny"):
        positions = positions * 10.0 ** draw(st.integers(3, 12) if spoil == "huge" else st.integers(-12, -3))
    elif spoil == "far":
        positions = positions + 10.0 ** draw(st.integers(2, 9))
    elif spoil == "shuffled":
        triangles = rng.integers(0, len(positions), triangles.shape)
    elif spoil == "twice":
        triangles = np.concatenate([triangles, triangles, triangles[:, [1, 0, 2]]])
    elif spoil == "turned":
        triangles = triangles[:, ::-1]
    elif spoil == "empty":
        triangles = triangles[:0]
    with np.errstate(all="ignore"):
        v = positions[triangles]
        facet = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
        normals = np.zeros_like(positions)
        for k in range(3):
            np.add.at(normals, triangles[:, k], facet)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    if spoil == "normal":
        normals[rng.integers(len(normals))] = [draw(NUMBERS) for _ in range(3)]
    return positions, triangles, normals


@st.composite
def receivers(draw, name):
    """A Receiver at the bottom, or another mesh, whose UVs may be spoilt."""
    # Not far smaller than the water: that is refused, or takes minutes where glass stands between.
    positions, triangles, _ = draw(meshes(0.0, [spoil for spoil in SPOILS if spoil != "tiny"]))
    seed = draw(st.integers(0, 2**16))
    rng = np.random.default_rng(seed)
    layout = draw(rarely("cells", st.sampled_from(("plan", "one_point", "outside", "values"))))
    if layout == "plan":
        with np.errstate(all="ignore"):
            uvs = (positions[:, :2] / 2 + 0.5)[triangles]
    else:
        side = int(np.ceil(np.sqrt(max(len(triangles), 1))))
        cell = np.stack(np.divmod(np.arange(len(triangles)), side), 1)
        uvs = (cell[:, None] + np.array([[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]])) / side
    if layout == "one_point":
        uvs = np.full_like(uvs, 0.5)
    elif layout == "outside":
        uvs = uvs * draw(st.sampled_from((2.0, -1.0, 1e6)))
    elif layout == "values" and uvs.size:
        uvs[rng.integers(len(uvs)), rng.integers(3), rng.integers(2)] = draw(NUMBERS)
    return Receiver(name, positions, triangles, uvs)


@st.composite
def lights(draw, number):
    """What makes a light, mostly one that shines down."""
    power = np.array([draw(rarely(1.0)) for _ in range(3)])
    kind = draw(st.sampled_from(("sun", "sun", "point", "spot")))
    if kind == "sun":
        direction = np.array(
            [draw(st.floats(-1, 1)), draw(st.floats(-1, 1)), -draw(st.sampled_from((1.0, 0.1, 0.0, -1.0)))]
        )
        length = np.linalg.norm(direction)
        direction = direction / length if length > 1e-6 else np.array([0, 0, -1.0])
        return partial(Sun, f"Sun {number}", direction, power, draw(rarely(draw(st.sampled_from((0.0, 0.0093))))))
    place = np.array([draw(st.floats(-2, 2)), draw(st.floats(-2, 2)), draw(rarely(4.0))])
    if kind == "point":
        return partial(Point, f"Point {number}", place, power, draw(rarely(0.0)))
    return partial(
        Spot,
        f"Spot {number}",
        place,
        power,
        0.0,
        half_angle=draw(rarely(0.5)),
        blend=draw(rarely(0.15)),
    )


@st.composite
def casters(draw, number):
    """What makes glass or a mirror between the water and the floor, or above."""
    positions, triangles, normals = draw(meshes(draw(st.sampled_from((0.5, 2.0)))))
    if draw(st.booleans()):
        material = Glass(draw(rarely(1.5)), np.full(3, draw(rarely(0.0))))
    else:
        material = Mirror(np.full(3, draw(rarely(0.9))), np.ones(3))
    return partial(Caster, f"Caster {number}", positions, triangles, normals, triangles, material)


@st.composite
def settings(draw):
    """Settings of a quick solve, of which one or another may be out of range."""
    return Settings(
        method=draw(rarely(draw(st.sampled_from(("auto", *METHODS))), st.just("nothing"))),
        tolerance=draw(rarely(draw(st.sampled_from((0.1, 0.1, 0.03, 1.0))))),
        points=draw(st.sampled_from((False, False, False, True))),
        first_root=draw(st.sampled_from((False, False, False, True))),
        surface=draw(rarely(draw(st.sampled_from(SURFACES)), st.just("ice"))),
        dispersion=draw(rarely(0.0)),
        match_cycles=draw(st.booleans()),
        bounces=draw(rarely(draw(st.sampled_from((1, 2, 3, 6))), st.sampled_from((0, -1)))),
    )


@st.composite
def cases(draw):
    """What a frame is made of, not yet put together: a dict of parts, and of Settings, resolution and padding."""
    parts = {"water": draw(meshes()), "floor": draw(receivers("Floor")), "settings": draw(settings())}
    parts["lights"] = tuple(draw(lights(k)) for k in range(draw(st.sampled_from((1, 1, 1, 2, 0)))))
    parts["casters"] = tuple(draw(casters(k)) for k in range(draw(st.sampled_from((0, 0, 0, 1, 2)))))
    parts["others"] = tuple(draw(meshes(0.5))[:2] for _ in range(draw(st.sampled_from((0, 0, 1)))))
    parts["eta"] = draw(rarely(1.333))
    parts["sigma_a"] = np.array([draw(rarely(draw(st.sampled_from((0.0, 0.0, 0.5))))) for _ in range(3)])
    box = np.diag([draw(rarely(3.0)) for _ in range(3)] + [1.0])
    parts["volume"] = draw(st.sampled_from((None, None, box)))
    parts["resolution"] = draw(rarely(draw(st.sampled_from((8, 12, 16, 1))), st.sampled_from((0, -4))))
    parts["padding"] = draw(rarely(draw(st.sampled_from((0, 1, 4))), st.just(-1)))
    return parts


def run(parts):
    """What becomes of a case: "answered", or the sentence that it is refused by. Raises for all that is neither."""
    try:
        with np.errstate(all="ignore"):
            answer, scene = answered(parts)
    except ValueError as error:
        sentence = str(error)
        assert len(sentence.split()) >= 4, f"no sentence: {sentence!r}"
        for word in (
            "broadcast",
            "operand",
            "NaN",
            "zero-size",
            "cannot convert",
            "array length",
            "reshape",
            "argm",
            "dimension",
        ):
            assert word not in sentence, f"not for people: {sentence!r}"
        return sentence
    check(answer, scene, parts["settings"])
    return "answered"


def answered(parts):
    """(Solution, Scene) of a case."""
    positions, triangles, normals = parts["water"]
    water = Water("Water", positions, triangles, normals, triangles, build_twins(triangles))
    others = tuple(Occluder(f"Other {k}", *mesh) for k, mesh in enumerate(parts["others"]))
    scene = Scene(
        water,
        (parts["floor"],),
        others,
        tuple(make() for make in parts["lights"]),
        parts["eta"],
        parts["sigma_a"],
        tuple(make() for make in parts["casters"]),
        None if parts["volume"] is None else Volume(parts["volume"]),
    )
    texels = tuple(rasterise(r, parts["resolution"], parts["padding"]) for r in scene.receivers)
    return solve(scene, texels, parts["settings"]), scene


def check(answer, scene, settings):
    """Images of numbers that are no less than none, and books that close."""
    for image in answer.images:
        assert np.isfinite(image).all(), "an image that is not finite"
    work = answer.diagnostics
    inward = np.asarray(work.flux_in)
    received = sum(work.flux_received.values(), np.zeros(3))
    lost = sum((np.asarray(flux) for flux in work.flux_lost.values()), np.zeros(3))
    assert np.isfinite(inward).all() and np.isfinite(received).all() and np.isfinite(lost).all(), (
        "books without numbers"
    )
    if work.method in BOOKS:
        off = np.abs(inward - received - lost)
        assert (off <= BOOKS[work.method] * inward + 1e-12).all(), f"books do not close: {inward} {received} {lost}"
