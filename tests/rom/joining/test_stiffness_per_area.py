"""Contact stiffness as a stiffness per area times the area of the vane's node."""

from types import SimpleNamespace

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.rom.component import Masters
from vanelock.rom.joining.connections import properties
from vanelock.stages.parts.segment import Joint

AREAS = {"hook_front": np.array([1e-6, 2e-6, 4e-6]), "hook_rear": np.array([3e-6])}


def side(name, areas):
    points = np.array([[1.0, 0, 0], [1, 0.1, 0], [1, 0.2, 0], [1, 0, 0.1]])
    frames = np.tile(np.eye(3), (4, 1, 1))
    return Masters(
        part=name,
        sectors=8,
        nodes=np.arange(4),
        points=points,
        node_sets={"hook_front": np.arange(3), "hook_rear": np.array([3]), "key": np.array([1])},
        frames={"hook_front": frames[:3], "hook_rear": frames[:1]},
        areas=areas,
    )


def stiffness(areas, **options):
    joint = Joint("hook", kn=7.0, kt=5.0, mu=0.3, interference=0.0, **options)
    vane, casing = side("vane", areas), side("casing", {})
    pairs = joint.pairs(SimpleNamespace(masters=vane), SimpleNamespace(masters=casing))
    return properties(list(pairs))


def test_each_pair_has_its_nodes_area():
    """The second node of the front hook is tied and has no contact."""
    found = stiffness(AREAS, kn_area=1e12)
    assert found.kn == pytest.approx([1e6, 4e6, 3e6], rel=1e-15)
    assert (found.kt == 5.0).all()
    found = stiffness(AREAS, kt_area=1e11)
    assert (found.kn == 7.0).all()
    assert found.kt == pytest.approx(np.array([[1e5] * 2, [4e5] * 2, [3e5] * 2]), rel=1e-15)


def test_sets_without_areas_are_refused():
    assert (stiffness({}).kn == 7.0).all()
    with pytest.raises(InputError, match='joint "hook": a stiffness per area needs contact sets'):
        stiffness({"hook_front": AREAS["hook_front"]}, kn_area=1e12)
