"""Sweeps of many cases: which of them are looked into, and how their curves are on the page."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.run_results import run_of
from vanelock import cases, parse_study
from vanelock.quantities.run_result import looked_into_names, named
from vanelock.report import Page, Section, write_page
from vanelock.report.plots import figure
from vanelock.results.figures.pictures import _detailed
from vanelock.results.page_sections.curves import response_plot
from vanelock.stages.response.summary import Peak

SWEEP = f'[sweep]\n"joints.interlock.mu" = {[round(0.1 + 0.01 * i, 2) for i in range(10)]}'
F = np.linspace(240.0, 300.0, 7)
SAMPLES = """
[scatter]
samples = {}
[scatter.keys]
"joints.interlock.kt" = {{ uniform = [1e6, 2e6] }}
"""


def run_data(text, own_limits=False, folder=None):
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
    many, _ = run_data(SAMPLES.format(30))
    peaks = many.peaks
    order = sorted(peaks, key=lambda name: peaks[name].amplitude)
    assert set(looked_into_names(many)) == {order[0], order[15], order[-1]}
    assert looked_into_names(many) == [each.name for each in named(many)]
    many, _ = run_data(SWEEP)
    assert looked_into_names(many) == ["mu=0.1", "mu=0.12", "mu=0.18", "mu=0.19"]
    assert [each.name for each in named(many)] == ["mu=0.1", "mu=0.19"]


@pytest.mark.parametrize("text", [SAMPLES.format(10), SWEEP])
def test_of_equal_largest_peaks_the_page_has_one_that_is_looked_into(text):
    many, _ = run_data(text)
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
    many, events = run_data(f"{SAMPLES.format(30)}\n[outputs]\n{wanted}")
    _detailed(many)
    expected = "pictures of {} for the lowest, the middle and the largest peak of 30"
    assert [event.text for event in events] == [expected.format(each) for each in said]


def plot(made, folder):
    made.output_files.folder = folder
    return response_plot(made)


def test_many_samples_are_shaded_as_in_the_picture(tmp_path):
    made, _ = run_data(SAMPLES.format(30), own_limits=True)
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
