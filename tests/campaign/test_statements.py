"""Verdicts on the published statements, from peaks and planes made by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock.campaign import statements as module
from vanelock.campaign.evidence import Evidence
from vanelock.campaign.sheets import case_of, planned_sheets
from vanelock.study import parse_study
from vanelock.study.summary import Peak


@pytest.fixture
def evidence(plane):
    """Peaks that agree with every statement on Figures 12 to 16."""
    plan = planned_sheets(parse_study("[campaign]"), 0.01)
    peaks: dict[str, tuple[float, float]] = {}
    for name, case in plan.cases.items():
        lock, response = case.study.joints.interlock, case.study.response
        a = 70e-6 * (1 - lock.mu) * (1 - 1e5 * max(lock.interference, 0))
        a *= {1: 1.0, 3: 1.03, 5: 1.031}[response.harmonics]
        f = 250 + 10 * lock.mu
        if response.coupling != "coupled":
            a, f = 0.8 * a, f + 1
        peaks[name] = a, f
    state = np.zeros(1)

    def made(**changes: Any) -> Evidence:
        summaries = {
            name: SimpleNamespace(peak=Peak(0, f, a, False), friction_share=0.98, of_stuck=0.3)
            for name, (a, f) in peaks.items()
        }
        response = SimpleNamespace(force=np.ones((1, 1, 1, 3), complex))
        given: dict[str, Any] = dict.fromkeys(Evidence.__dataclass_fields__)
        given |= {
            "plan": plan,
            "summaries": summaries,
            "linear": {"free": Peak(0, 250.0, 110e-6, False)},
            "planes": {"interference": plane},
            "tops": dict.fromkeys(peaks, response),
            "statics": dict.fromkeys(peaks, response),
            "at_mean": {},
            "interlock": state == 0,
        }
        return Evidence(**given | changes)

    return SimpleNamespace(made=made, peaks=peaks, plan=plan)


def change(evidence, amplitude=1.0, shift=0.0, **case):
    name = case_of(evidence.plan, **case)
    a, f = evidence.peaks[name]
    evidence.peaks[name] = amplitude * a, f + shift


FIGURES = (
    module.friction,
    module.harmonics,
    module.interference,
    module.uncoupled_friction,
    module.constant_friction,
    module.uncoupled_interference,
    module.hooks_share,
)


def test_what_agrees_is_said_to(evidence):
    found = evidence.made()
    assert [state(found).agrees for state in FIGURES] == ["yes"] * len(FIGURES)


def test_a_peak_that_rises_again_makes_the_fall_partly_true(evidence):
    change(evidence, 3.0, mu=0.5)
    found = module.friction(evidence.made())
    assert found.agrees == "partly"
    assert "beyond the friction coefficient that damps best" in found.why


def test_a_frequency_or_an_amplitude_on_the_other_side_is_partly_true(evidence):
    change(evidence, shift=-3.0, mu=0.1, coupling="uncoupled")
    assert module.uncoupled_friction(evidence.made()).agrees == "partly"
    change(evidence, 2.0, mu=0.15, coupling="constant-load")
    found = module.constant_friction(evidence.made())
    assert found.agrees == "partly"
    assert "1.60" in found.found


def test_harmonics_are_judged_by_steps_of_their_own(evidence):
    # The plane's third harmonic adds 5 %, its fifth 0.2 %: both within their own bounds everywhere.
    found = module.harmonics(evidence.made())
    assert "on 100% of the map" in found.found
    change(evidence, 1.05, harmonics=5)
    assert module.harmonics(evidence.made()).agrees == "partly"


@pytest.mark.parametrize(("order", "diameter"), [(1, 1), (-1, 15), (12, 12)])
def test_orders_excite_the_folded_diameter(evidence, order, diameter):
    speed = 250 / abs(order)
    limits = SimpleNamespace(
        nodal_diameter=diameter,
        sectors=16,
        free_mode=1,
        free_frequency=250,
        stuck_frequency=280,
    )
    found = module.campbell(evidence.made(limits=limits, engine_order=order))
    assert found.agrees == "yes"
    assert f"nodal diameter {min(diameter, 16 - diameter)} is" in found.says
    assert f"at {60 * speed:.0f} rpm free" in found.found


def test_hooks_that_take_a_fifth_are_not_little(evidence):
    found = evidence.made()
    found.summaries[case_of(evidence.plan, mu=0.5)].friction_share = 0.8
    assert module.hooks_share(found).agrees == "no"


def test_the_conclusion_holds_where_the_map_says(evidence):
    found = module.conservative(evidence.made())
    assert found.agrees == "partly"  # uncoupled is higher beyond the optimum, constant-load always
    assert "67% of the map (uncoupled) and 0%" in found.found
