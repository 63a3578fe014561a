"""Percentiles of peaks, where the distribution of the peaks is known in closed form."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from vanelock import cases, parse_study
from vanelock.analyses.scatter import (
    PERCENT,
    _correlations,
    _percentile_table,
    _percentiles,
    _sensitivity_table,
    scattered,
    spacing,
)
from vanelock.common.tables import Table
from vanelock.nonlinear import linear_response
from vanelock.results.page_sections.inputs import inputs
from vanelock.rom import Contacts, Diameter, Force, System
from vanelock.stages.response.summary import Peak, peak_of

ZETA = 0.01
FORCE = stats.lognorm(np.sqrt(np.log(1 + 0.3**2)), scale=30 / np.sqrt(1 + 0.3**2))
STIFFNESS = stats.norm(1e6, 1e5)
STUDY = """
[scatter]
samples = {count}
[scatter.keys]
"excitation.force" = {{ lognormal = [30, 9] }}
"joints.interlock.kt" = {{ normal = [1e6, 1e5] }}
"""


def oscillator(force, stiffness):
    matrices = Diameter(
        K=np.zeros((1, 1)),
        M=np.eye(1),
        own=np.array([[[0.0], [1.0], [0.0]]]),
        next=None,
        output=np.array([[[1.0], [0.0], [0.0]]]),
    )
    contacts = Contacts(
        np.array([1e6]), np.array([[stiffness, 1.0]]), np.array([0.3]), np.array([1e-5]), ("c",)
    )
    return System(1, 1, {0: matrices}, contacts, {1: Force(np.array([force + 0j]))}, ("o",), ZETA)


def peak(force, stiffness):
    """Of the oscillator, solved over frequencies about its own."""
    near = np.sqrt(stiffness) / (2 * np.pi) * np.linspace(0.999, 1.001, 21)
    found = linear_response(oscillator(force, stiffness), near, np.array([True]))
    return peak_of(found, found.amplitude[:, 0, 0])


@pytest.fixture(scope="module")
def oscillators():
    every = cases(parse_study(STUDY.format(count=300)))
    found = [SimpleNamespace(case=case.name, peak=peak(*case.values.values())) for case in every]
    return every, scattered(every, found)  # type: ignore[arg-type]


def test_percentiles_are_those_of_the_closed_form(oscillators):
    """The frequency is sqrt(k) / 2π times sqrt(1 - 2ζ²), so its percentiles are those of k."""
    _, found = oscillators
    k = STIFFNESS.ppf(np.array(PERCENT) / 100)
    expected = np.sqrt(k) / (2 * np.pi) * np.sqrt(1 - 2 * ZETA**2)
    np.testing.assert_allclose(found.frequency_percentile[:, 0], expected, rtol=1e-3)
    assert np.all(found.frequency_percentile[:, 1] < expected)
    assert np.all(expected < found.frequency_percentile[:, 2])


def test_amplitudes_follow_their_distribution(oscillators):
    """The peak is F / (2ζk sqrt(1-ζ²)), with percentiles by a million draws of F and k."""
    _, found = oscillators
    random = np.random.default_rng(5)
    force, k = FORCE.rvs(1_000_000, random), STIFFNESS.rvs(1_000_000, random)
    expected = np.percentile(force / (2 * ZETA * k * np.sqrt(1 - ZETA**2)), PERCENT)
    middle, low, high = found.amplitude_percentile.T
    assert np.all((low < expected) & (expected < high))
    np.testing.assert_allclose(middle, expected, rtol=0.05)


def test_what_the_scatter_comes_from(oscillators):
    """Of the amplitude's logarithm, var(ln F) = 0.0862 of 0.0862 + 0.01 is the force's."""
    _, found = oscillators
    of_force, of_stiffness = found.amplitude_correlation
    assert of_force[0] == pytest.approx(np.sqrt(0.0862 / 0.0962), abs=0.03)
    assert of_stiffness[1] < -np.sqrt(0.01 / 0.0962) < of_stiffness[2]
    assert found.frequency_correlation[1, 0] == pytest.approx(1)
    assert found.frequency_correlation[0, 1] < 0 < found.frequency_correlation[0, 2]


def test_limits_hold_as_often_as_they_say():
    random = np.random.default_rng(2)
    law = stats.gumbel_r(3, 2)
    expected = law.ppf(np.array(PERCENT) / 100)
    hits = np.zeros(5)
    for _ in range(300):
        _, low, high = _percentiles(law.rvs(100, random_state=random)).T
        hits += (low <= expected) & (expected <= high)
    assert np.all(hits / 300 >= 0.92)
    random = np.random.default_rng(3)
    inside = 0
    for _ in range(300):
        x, y = random.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 60).T
        ((_, low, high),) = _correlations(x[:, None], y)
        inside += low <= 6 / np.pi * np.arcsin(0.3) <= high  # Spearman's of a normal pair
    assert 0.91 <= inside / 300 <= 0.99


def sampled(count: int, apart: float = 1.0) -> tuple[Any, list[Any]]:
    """Samples whose peaks lie so many Hz apart, each larger than the one before."""
    every = cases(parse_study(STUDY.format(count=count)))
    peaks = [Peak(0, 250 + apart * i, 1e-5 * (i + 1), False) for i in range(count)]
    named = zip(every, peaks, strict=True)
    return every, [SimpleNamespace(case=case.name, peak=peak) for case, peak in named]


def test_few_samples_give_no_limits_and_fewer_nothing():
    every, found = sampled(12)
    percentiles = scattered(every, found[:11])
    assert percentiles is not None
    assert np.isnan(percentiles.amplitude[11])
    table = _percentile_table(percentiles, "o")
    assert table.shown[0][2] is None  # nothing lies below the 5th percentile for sure
    assert table.shown[2][1] == pytest.approx(60)
    assert "left out: 1 sample without a peak" in table.notes
    assert [row[0] for row in _sensitivity_table(percentiles).rows] == list(every[0].values)
    assert scattered(every, found[:9]) is None


def test_frequencies_on_a_coarse_grid_have_a_note():
    """Peaks at 250 to 250.9 Hz: 0.1 Hz apart they need no note, 1 Hz apart they do."""
    every, found = sampled(10, 0.1)
    for apart, notes in ((0.1, 0), (1.0, 1)):
        percentiles = scattered(every, found, [apart] * 10)
        assert percentiles is not None
        coarse = [note for note in _percentile_table(percentiles, "o").notes if "located" in note]
        assert len(coarse) == notes
    assert coarse[0].startswith("frequencies are resolved to 1 Hz alone")
    assert spacing(np.array([10.0, 11, 13, 13.5]), 1) == 2
    assert spacing(np.array([13.5, 13, 11, 10]), 0) == 0.5
    assert spacing(np.array([250.0]), 0) == 0


def tables(text):
    blocks = inputs(parse_study(text)).blocks
    return {block.title.split()[0]: block for block in blocks if isinstance(block, Table)}


def test_the_page_lists_what_scatters_or_varies_together_and_not_as_fixed():
    shown = tables(STUDY.format(count=100) + 'vane.thickness = { uniform = ["4 mm", 0.005] }')
    assert shown["Scattering:"].rows == [
        ("excitation.force", "radial force per node", "lognormal, mean 30 N, deviation 9 N"),
        ("joints.interlock.kt", "tangential stiffness", "normal, mean 1 N/µm, deviation 0.1 N/µm"),
        ("vane.thickness", "thickness of an aerofoil at mid-chord", "uniform, low 4 mm, high 5 mm"),
    ]
    fixed = [row[0] for row in shown["Main"].rows]
    assert "joints.interlock.mu" in fixed
    assert not {"excitation.force", "joints.interlock.kt"} & set(fixed)
    assert "Set" not in shown  # the number of samples is the default
    shown = tables('[rows]\n"joints.interlock.mu" = [0.1, 0.2]\n"excitation.force" = [10, 20]')
    assert [row[2] for row in shown["Varied"].rows] == ["0.1, 0.2", "10, 20 N"]
    constant = {row[0] for row in shown["Main"].rows}
    assert not {"joints.interlock.mu", "excitation.force"} & constant
