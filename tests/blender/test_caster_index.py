"""Index and Abbe number of casters: those of the material, or the object's own."""

import bpy
import pytest

from dapple.kernels.casters import Mirror
from dapple.tests.blender.glass_things import ball, dry_floor, material, read


@pytest.fixture
def scene(empty_scene, tmp_path):
    return dry_floor(empty_scene, tmp_path)


def test_impossible_index_blocks_and_is_said(scene):
    ball("Ball", material("Clear"))
    ball("Bubble", material("Air", IOR=0.75))
    found, (warning,) = read()
    assert [o.name for o in found.occluders] == ["Bubble"]
    assert "'Air' has IOR 0.75 and casts no caustics" in warning


def test_an_objects_own_index_and_abbe_number_take_the_place_of_its_materials(scene):
    clear = material("Clear")
    ball("Ball", clear)
    made = ball("Bubble", clear)
    made.dapple.ior, made.dapple.abbe = 1.0, 55.3
    found, warnings = read()
    assert [(c.name, c.material.eta, c.material.abbe) for c in found.casters] == [("Ball", 1.5, 0), ("Bubble", 1, 55.3)]
    assert warnings == []
    ball("Cup", material("Silver", Metallic=1.0, **{"Transmission Weight": 0.0})).dapple.ior = 1.2
    assert isinstance(read()[0].casters[2].material, Mirror)
    bpy.data.objects["Cup"].dapple.ior = 0.0


@pytest.mark.parametrize(
    ("values", "said"),
    [({"ior": 0.75}, "'Clear' has IOR 0.75 and casts no caustics"), ({"abbe": 0.5}, "impossible Abbe number 0.5")],
)
def test_an_objects_impossible_index_is_said(scene, values, said):
    ball("Ball", material("Other"))
    made = ball("Bubble", material("Clear"))
    for name, value in values.items():
        setattr(made.dapple, name, value)
    found, (warning,) = read()
    assert [o.name for o in found.occluders] == ["Bubble"] and said in warning


def test_an_objects_index_saves_what_its_material_gets_wrong(scene):
    ball("Bubble", material("Air", IOR=0.75)).dapple.ior = 1.0
    found, warnings = read()
    assert found.casters[0].material.eta == 1 and warnings == []
