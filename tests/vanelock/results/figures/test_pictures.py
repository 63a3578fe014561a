"""Which curves and modes a sweep draws, what it calls them, and the data beside."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.run_results import case_of, run_of
from vanelock import nonlinear, parse_study
from vanelock.analyses import campbell
from vanelock.input.cases.sweep import cases
from vanelock.nonlinear import static_response
from vanelock.results.figures.contacts import (
    Loop,
)
from vanelock.results.figures.curves import _linear as linear_curves
from vanelock.results.figures.pictures import _all_modes
from vanelock.results.listing import preload_table
from vanelock.stages.response.limits import Limits

F = np.linspace(240.0, 300.0, 7)


def run_data(text, limits=(), linear=None, peaks=()):
    """Data of a run of cases with the given limits; its output files keep the events."""
    study = parse_study(text)
    events: list[Any] = []
    drawn = {"draw": lambda *_: None, "animate": lambda *_: None}
    output_files: Any = SimpleNamespace(listener=events.append, **drawn)
    swept = cases(study)[: len(limits)]
    products = [{"limits": each} for each in limits]
    parts = "vane", "casing"
    run = run_of(study, swept, peaks, None, products, output_files, components=parts)
    run.limits = linear or {}
    return run, events


def found(k=1, free=250.0):
    of_each = np.array([100, free]), np.array([120, 280.0])
    return Limits(k, 18, True, *of_each, 1, 1, 0.9, np.zeros(2), np.zeros(2))


def modes(monkeypatch, drawn):
    heard = []

    def picture(run_data, each, field, *_):
        heard.append((field.name, field.title, field.subtitle))

    monkeypatch.setattr("vanelock.results.figures.pictures._picture", picture)
    monkeypatch.setattr("vanelock.results.figures.pictures._data", lambda *_: ())
    _all_modes(drawn)
    return heard


def test_one_limit_needs_no_name_and_many_are_not_all_drawn(monkeypatch):
    drawn, _ = run_data('[sweep]\n"joints.interlock.mu" = [0.1, 0.3]', [found(), found()])
    assert [name for name, _, _ in modes(monkeypatch, drawn)] == ["mode_free", "mode_stuck"]
    values = [round(5 + 0.1 * i, 1) for i in range(9)]
    text = f'[sweep]\n"joints.hook.kn" = {values}'
    drawn, events = run_data(text, [found(free=250.0 + i) for i in range(9)])
    names = [name for name, _, _ in modes(monkeypatch, drawn)]
    assert names == [f"mode_{w}_kn{v}N_m" for v in ("5", "5.8") for w in ("free", "stuck")]
    assert "the first and the last of 9 linear limits" in events[0].text


def test_equal_linear_limits_are_one_curve_and_others_are_named():
    rising, other = (F, 1e-7 * F), (F, 2e-7 * F)
    linear = {
        ("engine_order=-1", "free"): rising,
        ("engine_order=1", "free"): (F, 1e-7 * F * (1 + 1e-12)),
        ("engine_order=2", "free"): other,
        ("engine_order=-1", "stuck"): other,
        ("engine_order=1", "stuck"): other,
        ("engine_order=2", "stuck"): other,
    }
    labels = [curve.label for curve in linear_curves(run_data("", (), linear)[0])]
    assert labels == ["linear, free: EO = -1 or 1", "linear, free: EO = 2", "linear, stuck"]


def test_an_open_joint_has_no_preload_and_no_friction_no_share_of_it(ring):
    gap = replace(ring, contacts=replace(ring.contacts, v0=np.array([1e-5, -1e-5])))
    rest = static_response(gap)
    rest.force[0, 0] = [[2, 0, 0], [4e-16, 1e-16, 0]]
    hook, interlock = preload_table("", gap.contacts.joint, rest).record()["rows"]
    assert (hook["closed"], hook["open"]) == (1, 0)
    assert (interlock["closed"], interlock["open"], interlock["slipped"]) == (0, 1, 0)
    assert (interlock["n_min"], interlock["n_max"], interlock["t_over_n"]) == (0, 0, None)
    assert hook["n_mean"] == 2
    smooth = replace(ring, contacts=replace(ring.contacts, mu=np.zeros(2)))
    rest = static_response(smooth)
    rest.force[0, 0, :, 1] = 1e-17
    rows = preload_table("", smooth.contacts.joint, rest).record()["rows"]
    assert [(row["closed"], row["slipped"], row["t_over_n"]) for row in rows] == [(1, 1, 0)] * 2


def test_lines_that_cases_share_are_drawn_once_and_other_crossings_by_themselves():
    """With the circles of the first sample; as cases of several engine orders, each its own."""

    def drawn(names, interest):
        found: list[str] = []
        lines = [SimpleNamespace(free=np.ones(2), stuck=np.ones(2), interest=i) for i in interest]
        diagrams = [{"campbell.0": SimpleNamespace(lines=each)} for each in lines]
        cases = {n: case_of(n, None, d) for n, d in zip(names, diagrams, strict=True)}
        run: Any = SimpleNamespace(cases=cases)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(campbell, "_picture", lambda run, case: found.append(case.name))
            list(campbell.CAMPBELL.run_pictures(run))
        return found

    samples = [f"sample={i}" for i in range(12)]
    assert drawn(samples, [np.array([True, False])] * 12) == ["sample=0"]
    orders = ["engine_order=1", "engine_order=2"]
    assert drawn(orders, [np.array([True, False]), np.array([False, True])]) == orders


def test_a_loop_knows_its_bounds(ring):
    hertz = np.array([250.0])
    for coupling in ("coupled", "constant-load"):
        response = nonlinear.frequency_response(
            ring, hertz, nonlinear.Options(1, coupling=coupling)
        )
        loop = Loop(response, 1, ("radial", "axial"))
        n = loop.history[1][:, 0]
        expected = n if coupling == "coupled" else np.full(len(n), response.force[0, 0, 1, 0].real)
        bound = np.asarray(loop.columns()["friction limit mu n (N)"])
        np.testing.assert_allclose(bound, 0.3 * expected)
