"""Parts and what joins them: mesh correction, patches, modes of a vane alone."""

import h5py
import numpy as np
import pytest

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import parse_study, rom
from vanelock.commands.fit.fit import rejoined
from vanelock.common.errors import InputError
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.parts.components import averaged
from vanelock.stages.parts.ring_modes import vane_modes_step
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


def test_at_rest_the_answers_to_interference_lose_what_the_mesh_adds(kept, ring_text):
    text = ring_text("tetra10", COARSER) + TEXT
    plain, corrected = (
        kept.get(planned_of(each).system) for each in (text + '[mesh]\ncorrection = "none"\n', text)
    )
    for shape in rom.rest_shapes(plain, ("hook", "interlock")).T:
        before, after = (np.vdot(shape, each.at(0).K @ shape).real for each in (plain, corrected))
        assert 0.5 * before <= after < before


def test_a_study_says_what_its_contacts_act_on():
    hooks, interlock = ("hook_front", "hook_rear"), ("interlock_left", "interlock_right")
    for text, vane, casing in (
        ("", hooks + interlock, hooks),
        ("joints.interlock = false", hooks, hooks),
        ("joints.interlock = true", hooks + interlock, hooks),
        ('joints.patch = "node"', (), ()),
    ):
        study = parse_study(text)
        assert averaged(study, "vane") == vane
        assert averaged(study, "casing") == casing
    with pytest.raises(InputError, match=r'joints.patch = "face"'):
        parse_study('joints.patch = "face"')


RIGID = 6
"""Modes of a body that nothing holds."""


def test_modes_of_a_vane_alone_are_all_its_stiffness(stages, ring_text):
    """Σ g k gᵀ of all of them is what (1 + δ)² times the modulus adds, over (1 + δ)² - 1."""
    text, deviation = ring_text("tetra10", COARSER) + '[mesh]\ncorrection = "none"\n', 0.03
    modulus = parse_study(text).material.vane.E
    stiffer = f"[material.vane]\nE = {modulus * (1 + deviation) ** 2!r}\n"
    planned, other = planned_of(text), planned_of(text + stiffer)
    whole = planned.structure.whole
    vane = stages.get(planned.part("vane", 0))
    modes = stages.get(vane_modes_step(planned, whole, vane.size - RIGID))
    system, changed = stages.get(whole), stages.get(other.structure.whole)
    for k in range(7):
        g = modes.rows[k]
        added = changed.at(k).K - system.at(k).K
        found = ((1 + deviation) ** 2 - 1) * (g.conj().T * modes.stiffness) @ g
        np.testing.assert_allclose(found, added, atol=1e-7 * np.abs(added).max())
