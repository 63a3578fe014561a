"""Tests of residuals: their level for noise, by theory, and what they find when there is more."""

import numpy as np
import pytest
from scipy.stats import binom, kstest, t

from vanelock.commands.fit.least_squares import fit
from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.fit.solution import LEVEL, noise_tests
from vanelock.commands.fit.tables import doubts, fit_table, json_of

X = np.linspace(-1, 1, 30)
J = np.stack([np.ones(30), X, X**2], axis=1)
NAMES = [f"{i} Hz" for i in range(30)]


def examined(data, known=True, lengths=(30,)):
    """Tests of what a parabola leaves of data, by their names."""
    left = data - J @ np.linalg.lstsq(J, data)[0]
    return {each.name: each for each in noise_tests(left, J, lengths, known, NAMES)}


@pytest.fixture(scope="module")
def noise():
    draws = np.random.default_rng(5).standard_normal((300, 30))
    return [examined(each) for each in draws]


@pytest.mark.parametrize("name", ["neighbours", "size"])
def test_p_of_noise_is_uniform(noise, name):
    assert kstest([each[name].p for each in noise], "uniform").pvalue > 0.01


def test_noise_is_accused_as_rarely_as_the_level_says(noise):
    accused = sum(any(each.failed for each in tests.values()) for tests in noise)
    assert accused <= binom.ppf(0.99, len(noise), LEVEL)


def test_largest_is_the_t_of_a_prediction_from_the_others(noise):
    data = np.random.default_rng(7).standard_normal(30)
    data[11] += 5
    others = np.arange(30) != 11
    beta, square, *_ = np.linalg.lstsq(J[others], data[others])
    spread = J[11] @ np.linalg.inv(J[others].T @ J[others]) @ J[11]
    student = (data[11] - J[11] @ beta) / np.sqrt(square[0] / 26 * (1 + spread))
    found = examined(data)["largest"]
    assert found.statistic == pytest.approx(student)
    assert found.p == pytest.approx(2 * 30 * t.sf(student, 26))
    assert found.failed
    assert "at 11 Hz" in found.text


def test_signs_are_counted_within_curves():
    """Five changes in the first curve and none in the second; between them there is no pair."""
    left = np.array([1, -1, 1, -1, 1, -1, 1, 1, 1, 1.0])
    found, beside, *_ = noise_tests(left, np.ones((10, 1)), (6, 4), True, NAMES)
    assert (found.name, found.statistic) == ("signs", 5)
    assert found.p == pytest.approx(sum(binom.pmf(k, 8, 0.5) for k in range(6)))
    assert "from 6 Hz to 9 Hz" in found.text
    # Five steps of 2 among eight pairs: a scatter of √(20 / 8 / 2) beside sizes of 1.
    assert beside.text.startswith(f"residuals are {1 / np.sqrt(1.25):.2g} times as large")
    # Curves without any point left are none.
    again, *_ = noise_tests(left, np.ones((10, 1)), (0, 6, 0, 4, 0), True, NAMES)
    assert again == found


@pytest.mark.parametrize("known", [True, False])
def test_what_is_smooth_is_not_noise(known):
    data = np.random.default_rng(3).standard_normal(30) + 3 * np.sin(6 * X)
    found = examined(data, known)
    assert found["neighbours"].failed
    assert ("size" in found) == known


def test_what_is_within_the_given_scatter_is_passed_over():
    """It can move no value by one of its standard errors."""
    assert examined(0.1 * np.sin(6 * X)) == {}
    assert examined(0.1 * np.sin(6 * X), known=False)["neighbours"].failed


PAIR = [FitParameter("joints.interlock.mu", 1.0, 0.1, 10.0), FitParameter("force", 1.0, 0.1, 10.0)]


def test_a_miss_withholds_standard_errors():
    data = 1 + X**2 + 0.01 * np.random.default_rng(0).standard_normal(30)
    names = [[f"{250 + i} Hz" for i in range(30)]]
    line = J[:, :2] * [1, 0.1]
    found = fit(line.__matmul__, data, np.ones(30), PAIR, known=False, curves=names)
    assert {each.name for each in found.missed} >= {"signs", "neighbours"}
    texts = doubts(found)
    assert any(
        text.startswith("THE MODEL MISSES THE DATA: residuals change sign 2 times between 29")
        for text in texts
    )
    assert any(text.startswith("STANDARD ERRORS ARE WITHHELD") for text in texts)
    for row in fit_table(found, "rig").rows:
        assert row[4:7] == (None, None, None)
    record = json_of(found)
    assert record["correlation"] is None
    assert record["parameters"][0]["two_sigma"] is record["parameters"][0]["relative_error"] is None


def test_a_jump_beside_a_point_carries_no_standard_error():
    """The jump of the model crosses a point within a difference's step, and no further."""
    jump = 1 + 1e-4
    start = [FitParameter("place", jump, 0.5, 2.0), FitParameter("force", 1.0, 0.1, 10.0)]
    hertz = np.linspace(0.5, 1.5, 31)

    def step(theta):
        return theta[1] * np.where(hertz < theta[0], 1.0, 0.2)

    data = step([jump, 1.0]) + 0.02 * np.random.default_rng(1).standard_normal(31)
    found = fit(step, data, np.full(31, 0.02), start)
    assert found.deviation[0] < 1e-4  # that of linear theory: the data allow 3 %, to the next point
    assert not found.missed
    assert found.flat == (0,)
    (text,) = [text for text in doubts(found) if text.startswith("LINEAR THEORY DOES NOT HOLD")]
    assert "one standard error of place (0.00" in text
    assert not found.carried
