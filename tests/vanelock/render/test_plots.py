"""Curves, errors against cost and Haigh diagrams: peaks, lost points, how curves are told apart."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure

from vanelock import render
from vanelock.common.errors import InputError
from vanelock.render import (
    Curve,
    MarkedPeak,
    response_curves,
    style,
)
from vanelock.render.plots.curve import peak
from vanelock.render.plots.haigh import _line

F = np.linspace(240.0, 260.0, 41)


def resonance(at, height, ratio=0.005):
    """Amplitude of an oscillator, scaled to `height` at its natural frequency."""
    return height * 2 * ratio * at**2 / np.hypot(at**2 - F**2, 2 * ratio * at * F)


def labels(figure):
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    return [text.replace("\N{NO-BREAK SPACE}", " ") for text in texts]


def crosses(axes):
    """Flagged points: (colour, x, y) of all crosses."""
    lines = [line for line in axes.lines if line.get_marker() == "x" and len(line.get_xdata())]
    return [(line.get_color(), list(line.get_xdata()), list(line.get_ydata())) for line in lines]


def test_peak_is_the_largest_converged_point(figures):
    amplitude = resonance(250.0, 40e-6)
    assert peak(Curve(F, amplitude)) == MarkedPeak(250.0, amplitude.max(), False)
    without = peak(Curve(F, amplitude, converged=F != 250.0))
    assert without is not None
    assert without.amplitude == amplitude[[19, 21]].max()
    assert abs(without.frequency - 250.0) == 0.5
    response_curves("x.png", [Curve(F, F * 1e-7)])
    assert labels(figures[0]) == ["response\n26.0 µm at 260.0 Hz, end of range"]


def test_the_legend_has_case_and_peak(figures):
    made = [
        Curve(F, resonance(245.0, 130e-6), kind="free"),
        Curve(F, resonance(255.0, 230e-6), kind="stuck"),
        Curve(F, resonance(250.0, 70e-6), "μ = 0.15", 3),
    ]
    response_curves("x.png", made, "Title", "vane output 1, radial", engine_order=2)
    assert labels(figures[0]) == [
        "linear, free\n130 µm at 245.0 Hz",
        "linear, stuck\n230 µm at 255.0 Hz",
        "μ = 0.15, H = 3\n70.0 µm at 250.0 Hz",
    ]
    texts = [text.get_text() for text in figures[0].texts]
    assert texts == ["Title", "Monitored: vane output 1, radial"]
    (axes,) = figures[0].axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("excitation frequency (Hz)", "amplitude (µm)")
    speed = axes.child_axes[0]
    figures[0].canvas.draw()
    assert speed.get_xlabel() == "rotor speed at EO 2 (rpm)"
    assert speed.get_xlim() == pytest.approx((240 * 30, 260 * 30))


def test_points_that_did_not_converge_are_crossed_out_and_break_the_line(figures):
    amplitude, converged = resonance(250.0, 40e-6), np.ones(41, bool)
    converged[[10, 11, 20]] = False
    amplitude[11] = np.nan
    response_curves("x.png", [Curve(F, amplitude, "μ = 0.3", 3, converged)])
    (axes,) = figures[0].axes
    drawn = axes.lines[0]
    assert list(np.flatnonzero(np.isnan(drawn.get_ydata()))) == [10, 11, 20]
    placed, foot = crosses(axes)
    assert placed[1] == [F[10], F[20]]
    np.testing.assert_allclose(placed[2], 1e6 * amplitude[[10, 20]])
    assert foot[1] == [F[11]]
    assert 0 < foot[2][0] < 0.1  # in fractions of the axes' height
    assert labels(figures[0])[1] == "3 points not converged\n(at the foot: no amplitude)"
    low, high = axes.get_ylim()
    assert low <= min(placed[2])
    assert max(placed[2]) <= high


def test_a_figure_needs_a_curve(tmp_path):
    with pytest.raises(InputError, match="curves: none given"):
        response_curves(tmp_path / "x.png", [])
    with pytest.raises(InputError, match="none given"):
        render.convergence_picture(tmp_path / "none.png", [], "x")


def test_nothing_of_the_callers_matplotlib_changes(tmp_path):
    before = dict(mpl.rcParams)
    response_curves(tmp_path / "x.png", [Curve(F, F * 1e-7)])
    assert dict(mpl.rcParams) == before


def test_lines_are_solid_where_stable_dashed_where_unstable_and_grey_between(tmp_path, figures):
    verdict = np.zeros(len(F), int)
    verdict[15:25] = 1
    verdict[30] = 2
    curve = Curve(F, resonance(250.0, 40e-6), "a", verdict=verdict)
    found = [(code, run.start, run.stop) for code, run in curve.pieces]
    assert found == [
        (0, 0, 15),
        (2, 14, 16),
        (1, 15, 25),
        (2, 24, 26),
        (0, 25, 30),
        (2, 29, 32),
        (0, 31, 41),
    ]
    assert curve.outcome == "unstable"
    response_curves(tmp_path / "a.png", [curve])
    (axes,) = [each for each in figures[0].axes if each.lines]
    drawn = [line for line in axes.lines if len(line.get_xdata()) > 1]
    grey = [same_color(line.get_color(), style.GREY) for line in drawn]
    assert grey == [code == 2 for code, *_ in found]
    assert [line.is_dashed() for line in drawn] == [code == 1 for code, *_ in found]
    assert labels(figures[0]) == ["a\n40.0 µm at 250.0 Hz, unstable"]


@pytest.mark.parametrize("n", [1.0, 2.5])
def test_line_ends_at_the_strengths_over_the_reserve(n):
    axes = Figure().add_subplot()
    axes.set_xlim(-50, 1000)
    _line(axes, 250e6, 900e6, n)
    (line,) = axes.lines
    x, y = (np.asarray(each) for each in line.get_data())
    assert (x[1], y[1]) == pytest.approx((0, 250 / n))
    assert (x[2], y[2]) == pytest.approx((900 / n, 0))
    assert y[0] == y[1]  # flat in compression
