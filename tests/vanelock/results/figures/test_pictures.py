"""Which curves and modes a sweep draws, and what it calls them."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.run_results import case_of, run_of
from vanelock import parse_study
from vanelock.analyses import campbell
from vanelock.input.cases.sweep import cases
from vanelock.input.measured.curve import Measured
from vanelock.input.measured.units import STRAIN
from vanelock.nonlinear import static_response
from vanelock.pipeline.progress import silent
from vanelock.report import Picture
from vanelock.results.figures.curves import _linear as linear_curves
from vanelock.results.figures.curves import curves
from vanelock.results.figures.pictures import _all_modes, draw
from vanelock.results.files.run_folder import OutputFiles
from vanelock.results.listing import preload_table
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.summary import Peak

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
    """(file, title, subtitle) of each mode picture."""
    heard = []

    def picture(run_data, each, field, *_):
        heard.append((field.name, field.title, field.subtitle))

    monkeypatch.setattr("vanelock.results.figures.pictures._picture", picture)
    monkeypatch.setattr("vanelock.results.figures.pictures._data", lambda *_: ())
    _all_modes(drawn)
    return heard


def test_each_distinct_limit_has_its_modes_drawn(monkeypatch):
    text = '[ring]\nsectors = 18\n[vane]\naerofoils = 3\nchord = "54 mm"\nthickness = "4.8 mm"\n'
    text += '[sweep]\n"excitation.engine_order" = [-1, 1]\n"excitation.force" = [10, 20]'
    drawn, _ = run_data(text, [found(17), found(17), found(1), found(1)])
    assert modes(monkeypatch, drawn) == [
        (
            f"mode_{which}_engine_order{order}",
            f"Mode 2 of {wave}, interlock {which}: {frequency} Hz",
            f"EO = {order}",
        )
        for order, wave in ((-1, "nodal diameter 1, backward wave"), (1, "nodal diameter 1"))
        for which, frequency in (("free", "250.00"), ("stuck", "280.00"))
    ]


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


def test_the_curves_are_drawn_again_where_a_measured_one_is_called_otherwise_or_is_a_strain():
    drawn, _ = run_data("")
    shows: list[Any] = []

    def drawing(name, shown, write, quick=False):
        shows.append(shown)
        return Path(name)

    files: Any = drawn.output_files
    files.draw = drawing
    one = Measured("rig", F, 1e-6 * F)
    for each in (one, replace(one, load=0.5), replace(one, quantity=STRAIN)):
        drawn.measured = (each,)
        curves(drawn)
    assert len({json.dumps(each) for each in shows}) == 6  # pictures and CSV files


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


def test_the_first_and_the_last_case_of_a_sweep_move(tmp_path, monkeypatch):
    text = (
        '[sweep]\n"joints.interlock.mu" = [0.1, 0.2, 0.3]\n[outputs]\nshow = ["shapes", "loops"]\n'
    )
    heard = []

    def noted(run_data, each, animated):
        heard.append((each.name, animated))
        return []

    for name in ("curves", "_stress", "contacts", "_mesh"):
        monkeypatch.setattr(
            f"vanelock.results.figures.pictures.{name}", lambda *_: Picture(Path(), "", "")
        )
    for name in ("preloads", "_all_modes", "loops", "_mesh_errors"):
        monkeypatch.setattr(f"vanelock.results.figures.pictures.{name}", lambda *_: [])
    monkeypatch.setattr("vanelock.results.figures.pictures._response", noted)

    every = ["mu=0.1", "mu=0.2", "mu=0.3"]

    def moving(text, cases_shown):
        peak = Peak(0, 250.0, 1e-6, False)
        peaks = [peak if name in cases_shown else None for name in every]
        drawn, _ = run_data(text, [found()] * 3, peaks=peaks)
        drawn.output_files = OutputFiles(tmp_path, silent)
        heard.clear()
        draw(drawn)
        return dict(heard)

    assert not any(moving(text, every).values())
    text = text.replace('"loops"', '"loops", "animations"')
    assert moving(text, every) == {"mu=0.1": True, "mu=0.2": False, "mu=0.3": True}
    assert moving(text, every[:1]) == {"mu=0.1": True}


def test_lines_that_samples_share_are_drawn_whichever_samples_have_pictures():
    """Once, with the circles of the first sample, whose peak is not among the three named."""
    drawn: list[str] = []
    lines = SimpleNamespace(free=np.ones(2), stuck=np.ones(2))
    diagram = SimpleNamespace(lines=lines)
    names = [f"sample={i}" for i in range(12)]
    run: Any = SimpleNamespace(cases={n: case_of(n, None, {"campbell.0": diagram}) for n in names})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campbell, "_picture", lambda run, case: drawn.append(case.name))
        list(campbell.CAMPBELL.run_pictures(run))
    assert drawn == ["sample=0"]


def test_cases_whose_engine_orders_meet_the_same_lines_elsewhere_have_diagrams_of_their_own():
    """As cases of several engine orders: which crossings are of interest differs."""
    both = [
        SimpleNamespace(free=np.ones(2), stuck=np.ones(2), interest=np.array(of))
        for of in ([True, False], [False, True])
    ]
    names = "engine_order=1", "engine_order=2"
    run: Any = SimpleNamespace(
        cases={
            name: case_of(name, None, {"campbell.0": SimpleNamespace(lines=lines)})
            for name, lines in zip(names, both, strict=True)
        }
    )
    drawn: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campbell, "_picture", lambda run, case: drawn.append(case.name))
        list(campbell.CAMPBELL.run_pictures(run))
    assert drawn == list(names)
