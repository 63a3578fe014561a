"""Nodal diameters reduced one after the other, against all at once."""

from dataclasses import replace

import numpy as np
import pytest

from tests.rom.block_in_rim import HOOK, LOCK, RIM
from vanelock import rom
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, frequency_response
from vanelock.stages.parts.segment import Segment

JOINTS = HOOK, LOCK
BAND = 1e4


@pytest.fixture(scope="module")
def one_by_one(ring_scene):
    """Systems at the nodal diameters 2, 0 and 1, the casing prepared once."""
    model = ring_scene.casing_model
    prepared = rom.prepare(model, RIM)
    systems = []
    for k in (2, 0, 1):
        casing = rom.reduce(model, RIM, nodal_diameters=[k], band=BAND, prepared=prepared)
        systems.append(Segment(JOINTS, 1, 30.0, damping_ratio=0.003).join(ring_scene.vane, casing))
    return systems


def test_a_prepared_part_reduces_as_an_unprepared_one(ring_scene, one_by_one):
    alone = rom.reduce(ring_scene.casing_model, RIM, nodal_diameters=[2], band=BAND)
    system = Segment(JOINTS, 1, 30.0, damping_ratio=0.003).join(ring_scene.vane, alone)
    for name in ("K", "M", "own", "next", "output"):
        expected, found = getattr(system.at(2), name), getattr(one_by_one[0].at(2), name)
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


def test_united_diameters_respond_as_those_reduced_together(ring_scene, one_by_one):
    united = rom.united(one_by_one)
    assert sorted(united.diameters) == [0, 1, 2]
    sizes = {len(found.K) for found in united.diameters.values()}
    assert len(sizes) > 1  # or this shows less than it says
    hertz = [1110.0, 1140.0]  # on both sides of the first two resonances
    found = frequency_response(united, hertz, Options(2))
    expected = frequency_response(ring_scene.system, hertz, Options(2))
    # Both are within the same accuracy of reduction, 1e-4 at most.
    np.testing.assert_allclose(found.amplitude, expected.amplitude, rtol=1e-4)


def test_the_load_comes_with_its_own_diameter(one_by_one):
    united = rom.united(one_by_one)
    assert len(united.force[1].vector) == len(united.at(1).K)
    assert not rom.united(one_by_one[:2]).force


def test_systems_of_different_scenes_do_not_unite(one_by_one):
    first, second, third = one_by_one
    with pytest.raises(InputError, match="nodal diameter 2 comes twice"):
        rom.united([first, third, first])
    with pytest.raises(InputError, match="differ in engine_order"):
        rom.united([first, second, replace(third, engine_order=2)])
    with pytest.raises(InputError, match="no systems given"):
        rom.united([])


def test_another_model_or_other_masters_were_not_prepared(ring_scene):
    prepared = rom.prepare(ring_scene.casing_model, RIM)
    with pytest.raises(InputError, match="give the same model, masters and averaged sets"):
        rom.reduce(
            ring_scene.casing_model, RIM[:2], modes=2, nodal_diameters=[0], prepared=prepared
        )
