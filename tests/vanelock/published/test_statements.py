"""Verdicts on the published statements, from peaks and planes made by hand."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vanelock import parse_study
from vanelock.published import statements as module
from vanelock.published.checks import Difference
from vanelock.published.evidence import Evidence
from vanelock.published.sheets import case_of, planned_sheets
from vanelock.stages.response.summary import Peak, WaveVerdict


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
    waves: dict[str, WaveVerdict] = {}

    def made(**changes: Any) -> Evidence:
        summaries = {
            name: SimpleNamespace(
                peak=Peak(0, f, a, False),
                friction_share=0.98,
                of_stuck=0.3,
                wave=waves.get(name),
            )
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

    return SimpleNamespace(made=made, peaks=peaks, plan=plan, waves=waves)


def change(evidence, amplitude=1.0, shift=0.0, **case):
    name = case_of(evidence.plan, **case)
    a, f = evidence.peaks[name]
    evidence.peaks[name] = amplitude * a, f + shift


def test_what_becomes_of_the_waves_of_a_statement_is_reported(evidence):
    cases = module.friction(evidence.made()).cases
    assert len(cases) == 4
    assert module.waves_of(evidence.made(), cases) == ""
    for name in cases:
        evidence.waves[name] = WaveVerdict("stable", 0.99, 1, 0, ())
    assert module.waves_of(evidence.made(), cases) == "stable"
    evidence.waves[cases[-1]] = WaveVerdict("unstable", 1.8, 7, 2, ())
    assert module.waves_of(evidence.made(), cases) == "3 stable, 1 unstable"
    constant = module.constant_friction(evidence.made()).cases
    assert constant == cases  # the coupled peaks that the others are compared with


def test_a_peak_that_rises_again_makes_the_fall_partly_true(evidence):
    change(evidence, 3.0, mu=0.5)
    found = module.friction(evidence.made())
    assert found.agrees == "partly"
    assert "beyond the optimum friction coefficient" in found.why


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


def _limits(free=250.0, stuck=280.0, diameter=1):
    return SimpleNamespace(
        nodal_diameter=diameter,
        sectors=16,
        free_mode=1,
        free_frequency=free,
        stuck_frequency=stuck,
        rise=stuck / free - 1,
    )


def _loops(opened=(0.0, 0.3, 0.0), energy=1e-6):
    titles = ("in phase", "partial lift-off", "out of phase")
    return tuple(
        SimpleNamespace(title=title, energy=energy, marched=1e-6, opened=share)
        for title, share in zip(titles, opened, strict=True)
    )


def _of_stuck(found, ratio):
    for summary in found.summaries.values():
        summary.of_stuck = ratio
    return found


def _hooks_take(found, share):
    for summary in found.summaries.values():
        summary.friction_share = 1 - share
    return found


def _times(evidence, plane, factors, name="amplitude"):
    """Peaks, or seconds, of the map: each method's times a factor of the first one's."""
    values = getattr(plane, name)[..., :1] * np.array(factors)
    return evidence.made(planes={"interference": replace(plane, **{name: values})})


def _rising(evidence, **key):
    """Each of a figure's peaks higher than the one before."""
    (name, values), *_ = key.items()
    fixed = {"mu": evidence.plan.base.campaign.mu[-1]} if name == "interference" else {}
    for i, value in enumerate(values):
        change(evidence, 10.0 ** (i + 1), **fixed, **{name: value})
    return evidence.made()


def _other_way(evidence, coupling):
    """Peaks by another coupling lower in frequency and higher in amplitude than coupled ones."""
    for name, case in evidence.plan.cases.items():
        if case.study.response.coupling == coupling:
            a, f = evidence.peaks[name]
            evidence.peaks[name] = 2 * a, f - 2
    return evidence.made()


def _few_times(evidence, plane):
    change(evidence, 0.5, harmonics=3)
    change(evidence, 2.0, harmonics=5)
    return evidence.made()


DIFFERENT = Difference(vibration=0.2, mean=0.3, frequency=1.0, amplitude=0.1, slipping=4)
SAME = Difference(vibration=1e-14, mean=5e-4, frequency=0.0, amplitude=0.0, slipping=0)
COUPLED_LOWER, COUPLED_HIGHER = (1, 1.1, 1.2, 1, 1), (1, 0.9, 0.8, 1, 1)
VERDICTS = {
    module.campbell: (
        lambda e, p: e.made(limits=_limits(), engine_order=1),
        lambda e, p: e.made(limits=_limits(260.0, diameter=2), engine_order=1),
        "15000 rpm free and 16800 rpm stuck; response with friction peaks at 15180 rpm",
    ),
    module.hysteresis: (
        lambda e, p: e.made(conditions=_loops()),
        lambda e, p: e.made(conditions=_loops((0.1, 0.3, 0.0), 1.1e-6)),
        "open 30 % of the period",
    ),
    module.hooks_alone: (
        lambda e, p: e.made(hooks=SAME),
        lambda e, p: e.made(hooks=DIFFERENT),
        "differs by 1e-14 of the peak; 0 hook contacts slip",
    ),
    module.hooks_share: (
        lambda e, p: _hooks_take(e.made(), 0.05),
        lambda e, p: _hooks_take(e.made(), 0.15),
        "at most 5.0%",
    ),
    module.stiffer: (
        lambda e, p: e.made(limits=_limits()),
        lambda e, p: e.made(limits=_limits(stuck=240.0)),
        "250.00 to 280.00 Hz, +12.0 %",
    ),
    module.coincident: (
        lambda e, p: e.made(stuck={"uncoupled": SAME}, small=0.01),
        lambda e, p: e.made(stuck={"uncoupled": SAME, "constant-load": DIFFERENT}, small=0.01),
        "at 0.01 of the load: harmonics h >= 1 differ by 1e-14",
    ),
    module.below_stuck: (
        lambda e, p: _of_stuck(e.made(), 0.4),
        lambda e, p: _of_stuck(e.made(), 1.2),
        "0.4 to 0.4 of it",
    ),
    module.friction: (
        lambda e, p: e.made(),
        lambda e, p: _rising(e, mu=e.plan.base.campaign.mu),
        "0.458, 0.433, 0.356, 0.255 of the linear free peak",
    ),
    module.harmonics: (
        lambda e, p: e.made(),
        _few_times,
        "+3.0% from H = 1 to 3, +0.10% from 3 to 5",
    ),
    module.costs_harmonics: (
        lambda e, p: _times(e, p, (1, 1, 1, 3, 5), "seconds"),
        lambda e, p: _times(e, p, (1, 1, 1, 1.5, 2.5), "seconds"),
        "H = 3: 3.0; H = 5: 5.0 times that of one harmonic, 1000 ms",
    ),
    module.interference: (
        lambda e, p: e.made(),
        lambda e, p: _rising(e, interference=e.plan.base.campaign.interference),
        "of the linear free peak",
    ),
    module.uncoupled_friction: (
        lambda e, p: e.made(),
        lambda e, p: _other_way(e, "uncoupled"),
        "shifted by +1.00",
    ),
    module.constant_friction: (
        lambda e, p: e.made(),
        lambda e, p: _other_way(e, "constant-load"),
        "amplitudes times 0.80",
    ),
    module.uncoupled_interference: (
        lambda e, p: e.made(),
        lambda e, p: _other_way(e, "uncoupled"),
        "amplitudes times 0.80",
    ),
    module.constant_interference: (
        lambda e, p: e.made(),
        lambda e, p: _other_way(e, "constant-load"),
        "shifted by +1.00",
    ),
    module.conservative: (
        lambda e, p: _times(e, p, COUPLED_HIGHER),
        lambda e, p: _times(e, p, COUPLED_LOWER),
        "100% of the map (uncoupled) and 100% (constant-load)",
    ),
    module.costs_coupling: (
        lambda e, p: _times(e, p, (1, 0.8, 1, 3, 5), "seconds"),
        lambda e, p: _times(e, p, (1, 1, 1, 3, 5), "seconds"),
        "1.25 times the uncoupled one's",
    ),
}


@pytest.mark.parametrize("state", module.STATEMENTS)
def test_every_statement_can_agree_and_disagree(evidence, plane, state):
    agreeing, disagreeing, words = VERDICTS[state]
    found = state(agreeing(evidence, plane))
    assert found.agrees == "yes"
    assert words in found.found
    assert state(disagreeing(evidence, plane)).agrees == "no"
