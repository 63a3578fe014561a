"""Runs without the stiffness that their meshes add: limits, response, Campbell diagram, fits."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import fem, parse_study, rom
from vanelock.commands.fit.refit_model import rejoined
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.stages.parts.components import recovery_step
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.response.limits import Limits

TEXT = """
[material.vane]
E = [[20, "200 GPa"], [620, "155 GPa"]]
[temperature]
vane = 420
[response]
harmonics = 1
"""


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Stages for all tests of the small ring."""
    return Stages(Cache(tmp_path_factory.mktemp("kept"), print), silent)


@pytest.fixture(scope="module")
def model(kept, ring_text):
    return rejoined(parse_study(ring_text("tetra10", COARSER) + TEXT), kept)


def test_limits_are_lower_by_what_the_mesh_adds_and_hold_it(golden):
    with h5py.File(golden("default").folder / "results.h5") as file:
        limits = Limits.load(file["limits/all"])
        response = Response.load(file["response/nominal"])
    # What the same vane has with elements of 8 mm, 0.9 % lower than with 16 mm.
    assert limits.free_frequency == pytest.approx(251.5, rel=0.01)
    assert limits.stuck_frequency == pytest.approx(282.2, rel=0.01)
    assert 0.07 < limits.stuck_lowered < limits.free_lowered < 0.1
    worst = np.nanmax([limits.free_error[:6], limits.stuck_error[:6]])
    assert 0 < worst < 1e-4  # of the reduction alone
    peak = response.frequency[response.amplitude.max(axis=(1, 2)).argmax()]
    assert limits.free_frequency < peak < limits.stuck_frequency


def test_a_fit_joins_the_structure_of_the_run(kept, model, ring_text):
    own = model.system({})
    expected = kept.get(planned_of(ring_text("tetra10", COARSER) + TEXT).system)
    for k, one in expected.diameters.items():
        scale = np.abs(one.K).max()
        np.testing.assert_allclose(own.at(k).K, one.K, atol=1e-12 * scale)


@pytest.fixture(scope="module")
def apart(kept, ring_text):
    """The step of what meshes add at nodal diameter 2, and the products that it takes."""
    study = parse_study(ring_text("tetra10", COARSER) + TEXT)
    excess = StudyStructure(study).mesh_excess(2)
    whole = kept.get(recovery_step(study, "vane"))
    return excess, [kept.get(each) for each in excess.needs], whole


def test_what_the_vanes_mesh_adds_is_known_at_other_nodal_diameters(apart):
    _, (system, vane, _, alone, _), whole = apart
    _, shapes = rom.linear_modes(system, 2, MODES)
    q, K = system.at(2).split(shapes)["vane"], vane.at(0).K
    energy = np.einsum("ij,ij->j", q.conj(), K @ q).real
    recovered = alone.at(q)
    direct = fem.excess_stiffness(whole.model, whole.displacement(q, 2))
    scale = np.sqrt(np.outer(energy, energy))
    assert np.abs((recovered - direct) / scale).max() < 1e-3  # of some 0.05 ... 0.3


def test_elements_whose_estimate_is_too_large_stay_as_they_are(apart):
    excess, (*products, whole), _ = apart
    part = replace(whole.model.part, cell_type="hexahedron20")
    bricks = replace(whole, problem=replace(whole.problem, model=replace(whole.model, part=part)))
    taken, left = (excess.compute(*products, each).diameters[2].parts for each in (whole, bricks))
    assert not left[1].any()
    np.testing.assert_array_equal(left[0], taken[0])
    assert taken[1].any()


def test_at_rest_the_answers_to_interference_lose_what_the_mesh_adds(kept, ring_text):
    text = ring_text("tetra10", COARSER) + TEXT
    plain, corrected = (
        kept.get(planned_of(each).system) for each in (text + '[mesh]\ncorrection = "none"\n', text)
    )
    for shape in rom.rest_shapes(plain, ("hook", "interlock")).T:
        before, after = (np.vdot(shape, each.at(0).K @ shape).real for each in (plain, corrected))
        assert 0.5 * before <= after < before
