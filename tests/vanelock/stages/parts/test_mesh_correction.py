"""Runs without the stiffness that their meshes add: limits, response, Campbell diagram, fits."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from tests.vanelock.stages.campbell.test_campbell import DIAGRAM, HOT
from vanelock import fem, parse_study, rom, run_study
from vanelock.commands.fit.fit import rejoined
from vanelock.nonlinear import Response, System
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.rom.joining.mesh_excess import MODES
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.parts.components import casing_step, rom_step
from vanelock.stages.parts.recoveries import recovery_step
from vanelock.stages.parts.systems import excess_steps
from vanelock.stages.response.limits import Limits

CORRECTED = HOT.replace('correction = "none"', 'correction = "modal"')


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corrected")
    run_study(parse_study(CORRECTED + DIAGRAM), folder, silent)
    return folder


@pytest.fixture(scope="module")
def found(folder):
    with h5py.File(folder / "results.h5") as file:
        return {
            "diagram": Campbell.load(file["campbell/nominal"]),
            "limits": Limits.load(file["limits/all"]),
            "response": Response.load(file["response/nominal"]),
            "system": System.load(file["system"]),
        }


@pytest.fixture(scope="module")
def model(folder):
    return rejoined(parse_study(CORRECTED), Stages(Cache(folder / "cache", print), silent))


def test_limits_are_lower_by_what_the_mesh_adds_and_hold_it(found):
    limits = found["limits"]
    assert 0.035 < limits.free_lowered < 0.05  # the coarse mesh's error, docs/geometry.md
    assert 0.025 < limits.stuck_lowered < limits.free_lowered
    worst = np.nanmax([limits.free_error[:6], limits.stuck_error[:6]])
    assert 0 < worst < 1e-4  # of the reduction alone
    peak = found["response"].frequency[found["response"].amplitude.max(axis=(1, 2)).argmax()]
    assert limits.free_frequency < peak < limits.stuck_frequency


def test_the_diagram_is_of_the_same_structure(found):
    lines, limits = found["diagram"].lines, found["limits"]
    for stuck, expected in ((False, limits.free_frequency), (True, limits.stuck_frequency)):
        (own,) = np.flatnonzero(lines.interest & (lines.is_stuck == stuck))
        rel = 1e-4 if not stuck else 1e-2  # the parts are warmer where the stuck line is met
        assert lines.frequency[own] == pytest.approx(expected, rel=rel)
    assert lines.diameters.tolist() == [1, 2]


def test_a_fit_joins_the_structure_of_the_run(found, model):
    system, *_ = model.system({})
    for k, one in found["system"].diameters.items():
        scale = np.abs(one.K).max()
        np.testing.assert_allclose(system.at(k).K, one.K, atol=1e-12 * scale)


def test_parts_of_another_modulus_have_as_much_more_to_be_taken_off(model):
    E = {f"material.{part}.E": 2 * 170e9 for part in ("vane", "casing")}
    one, two = (model.system(values)[0].at(1).K for values in ({}, E))
    ratio = np.vdot(one, two) / np.vdot(one, one)
    np.testing.assert_allclose(two, ratio * one, atol=1e-9 * np.abs(two).max())
    assert ratio.real > 1.5


@pytest.fixture(scope="module")
def apart(folder):
    """The step of what meshes add at nodal diameter 2, and the products that it takes."""
    study = parse_study(CORRECTED.replace("[mesh]", 'speed = "15000 rpm"\n[mesh]'))
    stages = Stages(Cache(folder / "cache", print), silent)
    vane = rom_step(study, "vane", ())
    (excess,) = excess_steps(study, vane, [casing_step(study, 2)])
    whole = stages.get(recovery_step(study, "vane", vane))
    return excess, [stages.get(each) for each in excess.needs], whole


def test_what_the_vanes_mesh_adds_is_known_at_other_nodal_diameters(apart):
    _, (system, vane, casing, alone, _), whole = apart
    _, shapes = rom.linear_modes(system, 2, MODES)
    q, K = rom.split(vane, casing, shapes)[0], vane.at(0).K
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


def test_at_rest_the_answers_to_interference_lose_what_the_mesh_adds(found, folder):
    study = parse_study(CORRECTED.replace('correction = "modal"', 'correction = "none"'))
    run_study(study, folder / "as it is", silent)
    with h5py.File(folder / "as it is" / "results.h5") as file:
        plain = System.load(file["system"])
    for shape in rom.rest_shapes(plain, ("hook", "interlock")).T:
        before, after = (
            np.vdot(shape, each.at(0).K @ shape).real for each in (plain, found["system"])
        )
        assert 0.5 * before <= after < before
