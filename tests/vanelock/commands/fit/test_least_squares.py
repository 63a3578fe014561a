"""Least squares and residuals: known answers, SciPy's covariance, the theory of noise."""

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.stats import binom, kstest, t

from vanelock.commands.fit.least_squares import fit
from vanelock.commands.fit.parameters import FitParameter
from vanelock.commands.fit.solution import LEVEL, noise_tests
from vanelock.commands.fit.tables import doubts, fit_table, json_of, notes
from vanelock.common.errors import InputError

HERTZ = np.linspace(0.9, 1.1, 41)
TRUTH = np.array([2.0, 1.01, 0.02])
ONES = np.ones(41)


def resonance(f, height, place, ratio):
    return height * ratio / np.hypot(1 - (f / place) ** 2, 2 * ratio * f / place)


def predict(theta):
    return resonance(HERTZ, *theta)


def parameters(low=0.1, high=10.0, start=(1.0, 1.0, 0.05)):
    keys = ("height", "place", "damping.ratio")
    return [FitParameter(key, s, s * low, s * high) for key, s in zip(keys, start, strict=True)]


@pytest.mark.parametrize("given", [True, False])
def test_values_and_errors_are_scipy_s(given):
    """Relative standard errors of logarithms are those of the values over the values."""
    sigma = np.full(41, 0.02)
    data = predict(TRUTH) + sigma * np.random.default_rng(4).standard_normal(41)
    found = fit(predict, data, sigma if given else ONES, parameters(), sigma_known=given)
    value, covariance = curve_fit(
        resonance, HERTZ, data, TRUTH, sigma if given else None, absolute_sigma=given
    )
    np.testing.assert_allclose(found.value, value, rtol=1e-4)
    error = np.sqrt(np.diag(covariance)) / value * (found.scale if given else 1)
    np.testing.assert_allclose(found.deviation, error, rtol=0.02)
    related = covariance / np.outer(*2 * [np.sqrt(np.diag(covariance))])
    np.testing.assert_allclose(found.correlation, related, atol=0.02)
    left = data - resonance(HERTZ, *value)
    unit = 0.02 if given else 1.0
    assert found.after == pytest.approx(np.sqrt(np.mean(left**2)) / unit, rel=1e-4)
    assert found.undetermined == ()
    assert doubts(found) == []
    assert "correlation of errors: place and height " in "".join(notes(found))


def test_a_fit_in_small_units_goes_as_far_and_one_that_misses_has_larger_errors():
    """In metres residuals are of the order of 1e-7; a bump that no resonance has is a miss."""
    data = predict(TRUTH) + 0.02 * np.random.default_rng(4).standard_normal(41)
    found = fit(predict, data, ONES, parameters(), sigma_known=False)
    small = fit(lambda t: 1e-6 * predict(t), 1e-6 * data, ONES, parameters(), sigma_known=False)
    np.testing.assert_allclose(small.value, found.value, rtol=1e-4)
    sigma = np.full(41, 0.005)
    data = predict(TRUTH) * (1 + 0.3 * np.sin(40 * HERTZ))
    found = fit(predict, data, sigma, parameters())
    free = np.sum(((predict(found.value) - data) / sigma) ** 2) / (41 - 3)
    assert found.scale == pytest.approx(np.sqrt(free), rel=1e-6)
    assert any("THE MODEL MISSES THE DATA" in text for text in doubts(found))


def test_a_product_alone_is_determined():
    """The curve depends on height and load as their product: no data determine which one."""
    sigma = np.full(41, 0.02)

    def product(theta):
        return resonance(HERTZ, theta[0] * theta[1], 1.01, 0.02)

    data = product(TRUTH) + sigma * np.random.default_rng(0).standard_normal(41)
    starts = (("joints.interlock.mu", 1.0), ("force", 1.5))
    found = fit(product, data, sigma, [FitParameter(*each, 0.1, 10.0) for each in starts])
    (lost,) = found.undetermined
    assert abs(lost.along) == pytest.approx([0.5**0.5] * 2, abs=1e-3)
    assert lost.along[0] * lost.along[1] < 0
    assert found.value[0] * found.value[1] == pytest.approx(2.02, rel=0.02)
    (text,) = [text for text in doubts(found) if text.startswith("NOT DETERMINED")]
    assert all(words in text for words in ("interlock.mu", "force", "+10 %", "-9.1 %"))
    best = found.directions[0]
    assert best.along == pytest.approx([0.5**0.5] * 2, abs=1e-3)
    assert best.deviation < 0.01


def test_a_parameter_without_effect_and_a_bound_that_holds():
    data, sigma, wide = predict(TRUTH), np.full(41, 0.02), parameters()
    idle = [*wide, FitParameter("joints.hook.mu", 0.3, 0.03, 3.0)]
    found = fit(lambda theta: predict(theta[:3]), data, sigma, idle)
    (text,) = [text for text in doubts(found) if text.startswith("NOT DETERMINED")]
    assert text.startswith("NOT DETERMINED: hook.mu: standard error")
    assert "hardly depend on it" in text
    assert found.value[3] == pytest.approx(0.3)
    found = fit(predict, data, sigma, [FitParameter("height", 1.0, 0.5, 1.2), *wide[1:]])
    assert found.held == (True, False, False)
    assert any("height LIES ON A BOUND" in text for text in doubts(found))


def test_lost_points_do_not_count():
    data = predict(TRUTH)

    def with_holes(theta):
        return np.where((np.arange(41) > 4) & (np.arange(41) < 9), np.nan, predict(theta))

    found = fit(with_holes, data, np.full(41, 0.02), parameters())
    np.testing.assert_allclose(found.value, TRUTH, rtol=1e-3)
    assert found.lost == 4
    assert any("4 measured points have no converged response" in text for text in doubts(found))


def test_losing_the_worst_points_does_not_pay():
    """Far off, where half of the points would be missed most, they are lost instead."""
    data, sigma = predict(TRUTH), np.full(41, 0.02)

    def shy(theta):
        values = predict(theta)
        off = np.abs(values - data)
        values[(off > np.median(off)) & (off > 0.1)] = np.nan
        return values

    rough = fit(shy, data, sigma, parameters())
    np.testing.assert_allclose(rough.value, TRUTH, rtol=1e-3)
    # What the start lost counts as the worst that it kept.
    begun = [each.start for each in parameters()]
    off, kept = np.abs(predict(np.array(begun)) - data), ~np.isnan(shy(np.array(begun)))
    assert 0 < kept.sum() < 41
    counted = np.where(kept, off, off[kept].max())
    assert rough.before == pytest.approx(np.sqrt(np.mean(counted**2)) / 0.02)


def test_further_starts_find_what_the_first_does_not():
    """Far from the resonance nothing pulls towards it; equal misfits elsewhere are reported."""
    data = predict(TRUTH)
    start = [FitParameter("height", 2.0, 1.0, 4.0), FitParameter("place", 3.0, 0.5, 3.1)]

    def two(theta):
        return resonance(HERTZ, theta[0], theta[1], 0.02)

    one = fit(two, data, np.full(41, 0.02), start)
    many = fit(two, data, np.full(41, 0.02), start, 4)
    assert one.after > 1
    assert many.after < 0.1
    np.testing.assert_allclose(many.value, TRUTH[:2], rtol=1e-3)
    assert len(many.starts) == 4


def test_two_fits_as_good_as_each_other():
    """The sign of a gap that only its square shows: said, and the interval holds both."""
    pair = [FitParameter("joints.interlock.interference", 1e-6, -5e-6, 5e-6)]
    x = np.linspace(0, 1, 9)
    data = 1 + x * 4.0
    found = fit(lambda theta: 1 + x * (1e6 * theta[0]) ** 2, data, np.full(9, 0.1), pair, 6)
    assert abs(found.value[0]) == pytest.approx(2e-6, rel=1e-4)
    assert any(text.startswith("ANOTHER FIT IS AS GOOD") for text in doubts(found))
    error = found.deviation[0] * 5e-6
    slope = 2 * 1e12 * abs(found.value[0]) * x / 0.1
    assert error == pytest.approx(1 / np.sqrt(np.sum(slope**2)), rel=1e-3)
    assert len(found.as_good()) >= 1
    low, high = found.interval(0)
    assert low < -2e-6 < 2e-6 < high


def test_too_few_points():
    with pytest.raises(InputError, match="3 measured points for 3 parameters"):
        fit(predict, np.ones(3), np.ones(3), parameters())
    nothing = np.full(41, np.nan)
    with pytest.raises(InputError, match="no solution at any start"):
        fit(lambda theta: nothing, predict(TRUTH), ONES, parameters())


def test_slopes_take_the_place_of_differences():
    """The same values and errors, fewer evaluations; what is not known is found by differences."""
    sigma = np.full(41, 0.02)
    data = predict(TRUTH) + sigma * np.random.default_rng(4).standard_normal(41)
    asked = []

    def slopes(theta):
        asked.append(tuple(theta))
        _, place, ratio = theta
        f, detuned = HERTZ / place, 1 - (HERTZ / place) ** 2
        square = detuned**2 + (2 * ratio * f) ** 2
        by_place = (-4 * f**2 * detuned + 8 * ratio**2 * f**2) / (2 * square)
        by_ratio = 1 - 4 * ratio**2 * f**2 / square
        found = np.column_stack([np.ones(41), by_place, by_ratio]) * predict(theta)[:, None]
        return found

    plain = fit(predict, data, sigma, parameters())
    found = fit(predict, data, sigma, parameters(), slopes=slopes)
    np.testing.assert_allclose(found.value, plain.value, rtol=1e-4)
    np.testing.assert_allclose(found.deviation, plain.deviation, rtol=1e-3)
    assert 2 * found.starts[0].evaluations < plain.starts[0].evaluations
    assert len(asked) == len(set(asked))  # the search's last place is that of the errors

    def partly(theta):
        known = slopes(theta)
        known[:, 1] = np.nan
        return known

    mixed = fit(predict, data, sigma, parameters(), slopes=partly)
    np.testing.assert_allclose(mixed.value, plain.value, rtol=1e-4)


X = np.linspace(-1, 1, 30)
J = np.stack([np.ones(30), X, X**2], axis=1)
NAMES = [f"{i} Hz" for i in range(30)]


def examined(data, sigma_known=True, lengths=(30,)):
    """Tests of what a parabola leaves of data, by their names."""
    left = data - J @ np.linalg.lstsq(J, data)[0]
    return {each.name: each for each in noise_tests(left, J, lengths, sigma_known, NAMES)}


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
    assert examined(0.1 * np.sin(6 * X), sigma_known=False)["neighbours"].failed


PAIR = [FitParameter("joints.interlock.mu", 1.0, 0.1, 10.0), FitParameter("force", 1.0, 0.1, 10.0)]


def test_a_miss_withholds_standard_errors():
    data = 1 + X**2 + 0.01 * np.random.default_rng(0).standard_normal(30)
    names = [[f"{250 + i} Hz" for i in range(30)]]
    line = J[:, :2] * [1, 0.1]
    found = fit(line.__matmul__, data, np.ones(30), PAIR, sigma_known=False, curves=names)
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
