"""The sample scenes are what their build scripts promise: water to the formula, casters, lightmaps without overlap."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.kernels.halfedges import build_twins  # noqa: E402
from dapple.operators.bake.bake import request_from_scene  # noqa: E402
from dapple.operators.read.extract import read_scene  # noqa: E402
from dapple.operators.read.mesh_arrays import TopologyCache  # noqa: E402

GRID = 1024
SUN = {
    "calm_pond": (0.45, 0.25, -1.0),
    "pool": (0.25, 0.1, -1.0),
    "ocean": (0.35, 0.45, -1.0),
    "glass": (0.62, 0.35, -0.75),
    "lagoon": (0.20, 0.80, -0.62),
}
RECEIVERS = {
    "calm_pond": {"Bed"},
    "pool": {"Floor", "Walls", "Steps"},
    "ocean": {"Bed"},
    "glass": {"Table"},
    "mirror_room": {"Floor", "Walls"},
    "lagoon": {"Bed", "Hull", "Fish 1", "Fish 2", "Fish 3"},
}
WATER = {"calm_pond", "pool", "ocean", "lagoon"}
CASTERS = {
    "glass": {"Ball": 1.5, "Diamond": 2.417, "Suzanne": 1.5, "Ring": None},
    "mirror_room": {"Ball": 1.5, "Star": None, "Mirror": None},
}


@pytest.fixture(params=sorted(RECEIVERS))
def name(request, empty_scene, root):
    """Open one of the scenes, with the add-on registered."""
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / f"{request.param}.blend"))
    return request.param


@pytest.fixture
def pool(empty_scene, root):
    """Open the pool, with the add-on registered."""
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / "pool.blend"))


def water_positions(frame):
    """Return the water's vertices (V,3) [m] in world space on `frame`."""
    bpy.context.scene.frame_set(frame)
    water = bpy.context.scene.dapple.water.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = water.to_mesh()
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    water.to_mesh_clear()
    matrix = np.array(water.matrix_world)
    return flat.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]


def five_sines(x, y, t):
    """Return the height [m] of the pool's water at t seconds, written out from its definition."""
    waves = (
        (0.020, 1.60, 20.0, 0.0, 2),
        (0.012, 0.90, 75.0, 1.3, 3),
        (0.010, 0.62, -40.0, 2.1, 3),
        (0.006, 0.37, 130.0, 0.7, 4),
        (0.004, 0.23, -100.0, 4.0, 5),
    )
    z = 1.5
    for amplitude, wavelength, degrees, phase, turns in waves:
        k, a = 2 * np.pi / wavelength, np.radians(degrees)
        z = z + amplitude * np.sin(k * (x * np.cos(a) + y * np.sin(a)) - turns * np.pi * t + phase)
    return z


@pytest.mark.parametrize("frame", [1, 13, 25])
def test_pool_water_is_the_five_sines(pool, frame):
    x, y, z = water_positions(frame).T
    assert len(z) == 129 * 129
    assert np.abs(z - five_sines(x, y, (frame - 1) / 24)).max() < 1e-5


def test_pool_water_loops_after_48_frames(pool):
    assert np.abs(water_positions(49) - water_positions(1)).max() < 1e-5
    assert np.abs(water_positions(48) - water_positions(1)).max() > 1e-3


def test_pool_water_is_smooth_and_reaches_into_the_walls(pool):
    water = bpy.context.scene.dapple.water
    assert all(face.use_smooth for face in water.data.polygons)
    assert np.allclose(np.abs(water_positions(1)[:, :2]).max(axis=0), 2.1)


def test_calm_pond_throws_no_two_paths_together(empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / "calm_pond.blend"))
    for frame in (1, 20):
        x, _, z = water_positions(frame).reshape(97, 97, 3).transpose(2, 0, 1)
        cell, eta = x[0, 1] - x[0, 0], 1.333
        bend = np.array([z[2:, 1:-1] + z[:-2, 1:-1], z[1:-1, 2:] + z[1:-1, :-2]]) - 2 * z[1:-1, 1:-1]
        # The image of a wave comes together where its curvature times this is 1.
        together = np.abs(bend).sum(0) / cell**2 * 0.6 * (eta - 1) / eta
        assert 0.05 < together.max() < 0.5


def test_ocean_moves_and_has_slopes(empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / "ocean.blend"))
    one, two, far = (water_positions(frame)[:, 2] for frame in (1, 2, 25))
    assert 0.01 < one.std() < 0.05
    assert 1e-4 < np.abs(two - one).mean() < np.abs(far - one).mean()


def test_files_are_small_and_ask_for_what_dapple_needs(name, root):
    scene = bpy.context.scene
    assert (root / "sample_blends" / f"{name}.blend").stat().st_size < 2e6
    assert (scene.dapple.water.name if scene.dapple.water else None) == ("Water" if name in WATER else None)
    assert {obj.name for obj in scene.dapple.receivers.all_objects} == RECEIVERS[name]
    assert scene.dapple.output == f"//{name}_caustics"
    assert (scene.frame_start, scene.frame_end, scene.render.fps) == (1, 48, 24)
    assert scene.camera is not None
    assert scene.render.engine.startswith("BLENDER_EEVEE")


@pytest.mark.parametrize("name", sorted(SUN))
def test_the_sun(name, empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / f"{name}.blend"))
    (sun,) = (obj for obj in bpy.data.objects if obj.type == "LIGHT")
    travel = np.array(sun.matrix_world.to_3x3())[:, 2] * -1.0
    wanted = np.array(SUN[name]) / np.linalg.norm(SUN[name])
    assert np.abs(travel - wanted).max() < 1e-6
    assert sun.data.type == "SUN"
    assert np.degrees(sun.data.angle) == pytest.approx(0.53, abs=1e-4)


@pytest.mark.parametrize("name", sorted(RECEIVERS))
@pytest.mark.parametrize("frame", [1, 14])
def test_casters_are_closed_bodies_of_the_promised_glass_and_metal(name, frame, empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / f"{name}.blend"))
    bpy.context.scene.frame_set(frame)
    request = request_from_scene(bpy.context.scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    scene, warnings = read_scene(depsgraph, request.water, request.receivers, TopologyCache(), request.volume)
    assert warnings == []
    assert {c.name: getattr(c.material, "eta", None) for c in scene.casters} == CASTERS.get(name, {})
    for caster in scene.casters:
        if caster.name != "Mirror":
            edges, twins = len(caster.triangles) * 3, build_twins(caster.triangles)
            assert caster.name == "Star" or np.count_nonzero(twins >= 0) == edges, f"{caster.name} has holes"
        if scene.volume is not None:
            inside = np.c_[caster.positions, np.ones(len(caster.positions))] @ np.linalg.inv(scene.volume.matrix).T
            assert np.abs(inside[:, :3]).max() < 1, f"{caster.name} sticks out of the volume"


def test_glass_bounds_its_work(empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / "glass.blend"))
    settings = bpy.context.scene.dapple
    assert (settings.volume.name, settings.culling) == ("Caustics Volume", {"+Z"})


def test_mirror_room_moves_light_camera_and_geometry(empty_scene, root):
    bpy.ops.wm.open_mainfile(filepath=str(root / "sample_blends" / "mirror_room.blend"))
    places = {}
    for frame in (1, 13, 49):
        bpy.context.scene.frame_set(frame)
        for moved in ("Lamp", "Room", "Ball", "Star"):
            places[moved, frame] = np.array(bpy.data.objects[moved].matrix_world)
    for moved in ("Lamp", "Room", "Ball", "Star"):
        assert np.abs(places[moved, 1] - places[moved, 13]).max() > 0.05
        loops = np.abs(places[moved, 1] - places[moved, 49]).max()
        assert (loops < 1e-6) == (moved != "Star")  # a fifth of a turn looks the same


def uv_quads(obj):
    """Return the UVs (F,4,2) of a mesh of quads."""
    layer = next(layer for layer in obj.data.uv_layers if layer.active_render)
    flat = np.empty(2 * len(obj.data.loops), np.float32)
    layer.data.foreach_get("uv", flat)
    assert len(obj.data.loops) == 4 * len(obj.data.polygons)
    return flat.reshape(-1, 4, 2).astype(float)


def times_covered(quads):
    """Return how many of the quads cover the centre of each cell of a GRID x GRID raster of the unit square."""
    centres = (np.arange(GRID) + 0.5) / GRID
    count = np.zeros((GRID, GRID), int)
    for quad in quads:
        low, high = np.searchsorted(centres, quad.min(axis=0)), np.searchsorted(centres, quad.max(axis=0))
        x, y = np.meshgrid(centres[low[0] : high[0]], centres[low[1] : high[1]])
        inside = np.ones(x.shape, bool)
        for (ax, ay), (bx, by) in zip(quad, np.roll(quad, -1, axis=0), strict=True):
            inside &= (bx - ax) * (y - ay) > (by - ay) * (x - ax)
        count[low[1] : high[1], low[0] : high[0]] += inside
    return count


def test_lightmaps_stay_inside_and_do_not_overlap(name):
    for obj in bpy.context.scene.dapple.receivers.all_objects:
        quads = uv_quads(obj)
        assert quads.min() >= 0.0
        assert quads.max() <= 1.0
        a, b = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
        areas = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
        assert areas.min() > 0.0, f"{obj.name}: a mirrored or empty face"
        count = times_covered(quads)
        assert count.max() == 1, f"{obj.name}: faces overlap"
        assert count.mean() == pytest.approx(areas.sum(), abs=0.005)


def test_the_overlap_check_can_fail():
    square = np.array([[[0.1, 0.1], [0.6, 0.1], [0.6, 0.6], [0.1, 0.6]]])
    assert times_covered(square).max() == 1
    assert times_covered(np.concatenate([square, square + 0.2])).max() == 2


def test_pool_charts_have_one_scale_and_keep_apart(pool):
    for obj in bpy.context.scene.dapple.receivers.all_objects:
        quads = uv_quads(obj)
        flat = np.linalg.norm(quads - np.roll(quads, -1, axis=1), axis=-1).ravel()
        places = np.array([v.co for v in obj.data.vertices]).reshape(-1, 4, 3)
        real = np.linalg.norm(places - np.roll(places, -1, axis=1), axis=-1).ravel()
        assert np.ptp(flat / real) < 1e-5 * (flat / real).max()
        covered = times_covered(quads) > 0
        starts, ends = (np.diff(covered.astype(int), axis=1) == step for step in (1, -1))
        for line_starts, line_ends in zip(starts, ends, strict=True):
            gaps = np.subtract.outer(np.flatnonzero(line_starts), np.flatnonzero(line_ends))
            # A gap of one cell is a centre that lies on the edge of two faces; two paddings of 4 texels are 16 cells.
            assert gaps[gaps > 1].min(initial=GRID) >= 16, f"{obj.name}: charts closer than 8 texels of 512"
