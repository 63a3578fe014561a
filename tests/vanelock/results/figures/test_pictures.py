"""Which curves and modes a sweep draws, what it calls them, and the data beside."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.run_results import case_of, run_of
from vanelock import cases, nonlinear, parse_study
from vanelock.analyses import campbell
from vanelock.nonlinear import static_response
from vanelock.quantities.run_result import looked_into_names, named
from vanelock.report import Page, Section, write_page
from vanelock.report.plots import figure
from vanelock.results.figures.contacts import (
    Loop,
)
from vanelock.results.figures.curves import _linear as linear_curves
from vanelock.results.figures.pictures import _all_modes, _detailed
from vanelock.results.listing import preload_table
from vanelock.results.page_sections.curves import response_plot
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


SWEEP = f'[sweep]\n"joints.interlock.mu" = {[round(0.1 + 0.01 * i, 2) for i in range(10)]}'
SAMPLES = """
[scatter]
samples = {}
[scatter.keys]
"joints.interlock.kt" = {{ uniform = [1e6, 2e6] }}
"""


def sweep_of(text, own_limits=False, folder=None):
    """Cases whose peaks go down and up again, with limits of their own or shared."""
    study = parse_study(text)
    peaks, curves = list[Any](), list[Any]()
    limits: dict[Any, Any] = {}
    swept = cases(study)
    for i, case in enumerate(swept):
        height = 1e-6 * (1 + (2 + 4 * i) % 5 + 0.01 * i)
        peaks.append(Peak(3, 270.0, height, False))
        curves.append((F, height / (1 + abs(F - 270)), np.ones(7, bool)))
        for which in ("free", "stuck"):
            name = case.name if own_limits else ""
            limits[name, which] = (F, 1e-5 * (1 + i * own_limits) * np.ones(7))
    events: list[Any] = []
    output_files: Any = SimpleNamespace(folder=folder, listener=events.append)
    run = run_of(study, swept, peaks, curves, output_files=output_files)
    if own_limits:
        run.cases = {name: replace(case, linear_name=name) for name, case in run.cases.items()}
    run.limits = limits
    return run, events


def test_samples_looked_into_are_those_with_pictures_and_of_a_sweep_ends_and_extremes():
    many, _ = sweep_of(SAMPLES.format(30))
    peaks = many.peaks
    order = sorted(peaks, key=lambda name: peaks[name].amplitude)
    assert set(looked_into_names(many)) == {order[0], order[15], order[-1]}
    assert looked_into_names(many) == [each.name for each in named(many)]
    many, _ = sweep_of(SWEEP)
    assert looked_into_names(many) == ["mu=0.1", "mu=0.12", "mu=0.18", "mu=0.19"]
    assert [each.name for each in named(many)] == ["mu=0.1", "mu=0.19"]


@pytest.mark.parametrize("text", [SAMPLES.format(10), SWEEP])
def test_of_equal_largest_peaks_the_page_has_one_that_is_looked_into(text):
    many, _ = sweep_of(text)
    peaks = many.peaks
    for name in list(peaks)[2:8:2]:  # three, each larger than all others
        case, peak = many.cases[name], replace(peaks[name], amplitude=1e-3)
        many.cases[name] = replace(case, summary=replace(case.summary, peak=peak))
    most = many.largest
    assert most is not None
    assert most.case in looked_into_names(many)
    assert many.peaks[most.case].amplitude == 1e-3


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ("", ["loops and shapes"]),
        ("show = ['shapes', 'report']", ["shapes"]),
        ("show = ['loops', 'report']", ["loops"]),
        ("show = ['report']", []),
    ],
)
def test_pictures_of_a_few_are_announced_where_there_are_any(wanted, said):
    many, events = sweep_of(f"{SAMPLES.format(30)}\n[outputs]\n{wanted}")
    _detailed(many)
    expected = "pictures of {} for the lowest, the middle and the largest peak of 30"
    assert [event.text for event in events] == [expected.format(each) for each in said]


def plot(made, folder):
    made.output_files.folder = folder
    return response_plot(made)


def test_many_samples_are_shaded_as_in_the_picture(tmp_path):
    made, _ = sweep_of(SAMPLES.format(30), own_limits=True)
    shown = plot(made, tmp_path)
    outer, inner, middle = shown.traces[:3]
    assert [t.name for t in (outer, inner, middle)] == [
        "5 to 95 % of 30 samples",
        "25 to 75 % of 30 samples",
        "median of 30 samples",
    ]
    assert (outer.fill, inner.fill, middle.fill) == (0.15, 0.3, 0)
    np.testing.assert_array_equal(outer.x, np.append(F, F[::-1]))
    heights = 1e6 * np.array([case.drawn[1] for case in made.cases.values()])
    low, high = np.percentile(heights, [5, 95], axis=0)
    np.testing.assert_allclose(outer.y, np.append(low, high[::-1]))
    drawn = figure(shown)["data"][0]
    assert (drawn["fill"], drawn["fillcolor"]) == ("toself", "rgba(0,114,178,0.15)")
    page = Page("Many", "today", [Section("Curves", [shown])])
    written = write_page(tmp_path / "page.html", page).read_text("utf-8")
    assert 'fill-opacity="0.15"' in written
    assert sum("linear" in t.name for t in shown.traces) == 6  # of the three samples alone
