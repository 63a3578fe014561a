"""Curves, errors against cost and Haigh diagrams: peaks, lost points, how curves are told apart."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import same_color, to_rgb
from matplotlib.figure import Figure

from vanelock import render
from vanelock.common.errors import InputError
from vanelock.render import (
    Curve,
    Envelope,
    MarkedPeak,
    Named,
    response_curves,
    style,
)
from vanelock.render.plots import convergence
from vanelock.render.plots.curve import peak
from vanelock.render.plots.haigh import _line, _marks

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


def drawn(figure):
    """Lines of whole curves."""
    return [line for line in figure.axes[0].lines if len(line.get_xdata()) == len(F)]


@pytest.mark.parametrize(
    ("more", "styles"),
    [
        (lambda i: {"harmonics": (1, 3)[i]}, ["--", "-", "--", "-"]),
        (lambda i: {"variant": ("coupled", "uncoupled")[i]}, ["-", "--", "-", "--"]),
    ],
)
def test_colours_show_friction_and_line_styles_harmonics_or_variants(figures, more, styles):
    made = [
        Curve(F, resonance(250.0 + mu, 1e-5), f"μ = {mu}", **more(i))
        for mu in (0.1, 0.3)
        for i in (0, 1)
    ]
    response_curves("x.png", made)
    lines = drawn(figures[0])
    assert [line.get_linestyle() for line in lines] == styles
    colours = [line.get_color() for line in lines]
    assert same_color(*colours[:2])
    assert same_color(*colours[2:])
    assert not same_color(colours[0], colours[2])
    if "variant" in more(0):
        assert labels(figures[0])[1].startswith("μ = 0.1, uncoupled\n")


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


def test_a_wild_lost_point_does_not_squeeze_the_curves_and_a_lost_curve_is_named(figures):
    amplitude, converged = resonance(250.0, 40e-6), np.ones(41, bool)
    converged[5], amplitude[5] = False, 1.0
    response_curves("x.png", [Curve(F, amplitude, converged=converged)])
    (axes,) = figures[0].axes
    assert axes.get_ylim()[1] < 60
    assert crosses(axes)[0][1] == [F[5]]
    lost = Curve(F, np.full(41, np.nan), "μ = 0.3")
    response_curves("x.png", [lost, Curve(F, resonance(250.0, 1e-5), "μ = 0.1")])
    assert labels(figures[1])[0] == "μ = 0.3\nno converged point"
    assert len(crosses(figures[1].axes[0])[0][1]) == 41


def test_a_figure_needs_a_curve(tmp_path):
    with pytest.raises(InputError, match="curves: none given"):
        response_curves(tmp_path / "x.png", [])


def test_nothing_of_the_callers_matplotlib_changes(tmp_path):
    before = dict(mpl.rcParams)
    response_curves(tmp_path / "x.png", [Curve(F, F * 1e-7)])
    assert dict(mpl.rcParams) == before


def test_listed_points_are_dots_and_frequencies_far_apart_get_a_logarithmic_axis(figures):
    lone = Curve(np.array([265.0]), np.array([2e-5]), "μ = 0.3", joined=False)
    some = Curve(np.array([240.0, 265.0]), np.array([1e-5, 3e-5]), "μ = 0.1", joined=False)
    response_curves("x.png", [lone, some])
    assert labels(figures[0]) == ["μ = 0.3\n20.0 µm at 265.0 Hz", "μ = 0.1\n30.0 µm at 265.0 Hz"]
    lines = [line for line in figures[0].axes[0].lines if line.get_linestyle() != "None"]
    assert all(len(line.get_xdata()) < 2 for line in lines)
    assert peak(Curve(np.array([265.0]), np.array([2e-5]))) == MarkedPeak(265.0, 2e-5, False)
    figures.clear()
    wide = Curve(np.array([1e-9, 265.0, 1e9]), np.array([1e-6, 2e-6, 0.0]))
    response_curves("x.png", [wide], engine_order=1)
    figures[0].canvas.draw()
    (axes,) = figures[0].axes
    assert axes.get_xscale() == "log"
    assert axes.child_axes[0].get_xlim() == pytest.approx((6e-8, 6e10))
    response_curves("x.png", [Curve(F, F * 1e-7)])
    assert figures[1].axes[0].get_xscale() == "linear"


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


def test_an_envelope_is_shaded_in_its_curves_colour(tmp_path, figures):
    amplitude = resonance(250.0, 40e-6)
    around = Envelope(F, 0.5 * amplitude, 2 * amplitude, [(F, 0.5 * amplitude), (F, 2 * amplitude)])
    response_curves(tmp_path / "a.png", [Curve(F, amplitude, "a", envelope=around)])
    (axes,) = [each for each in figures[0].axes if each.lines]
    (shade,) = axes.collections
    line = axes.lines[-1]
    assert same_color(shade.get_facecolor()[0][:3], to_rgb(axes.lines[0].get_color()))
    assert shade.get_paths()[0].get_extents().y1 == pytest.approx(80.0)
    assert line is not None


NAN = float("nan")
VALUES = (
    render.MeasuredValue("1", 0.1, 1e-2, 1e-3, False),
    render.MeasuredValue("3", 0.4, 1e-3, 1e-9, True),
    render.MeasuredValue("adaptive", 0.2, 1e-4, 1e-5, False, joined=False),
    render.MeasuredValue("9", 1.2, NAN, NAN, False),
)


@pytest.fixture
def axes():
    found = style.axes(Figure((6, 4)), 1, 1, 4, 2)
    convergence._draw(found, render.Panel("response.harmonics", VALUES))
    return found


def test_values_are_named_joined_in_sequences_and_the_reference_is_a_line_at_its_cost(axes):
    joined = [line.get_xydata() for line in axes.lines if line.get_linestyle() == "-"]
    np.testing.assert_allclose(joined[0], [[0.1, 1e-2], [0.4, 1e-3]])
    # An error too small to be drawn lies at the foot.
    np.testing.assert_allclose(joined[1], [[0.1, 1e-3], [0.4, 1e-7]])
    assert [text.get_text() for text in axes.texts] == ["1", "3", "adaptive", "9"]
    assert [text.get_fontweight() for text in axes.texts] == ["normal", "bold", "normal", "normal"]
    large = [line for line in axes.lines if line.get_markersize() == 8]
    assert [line.get_xdata().tolist() for line in large] == [[0.4], [0.4]]
    (dotted,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    assert set(dotted.get_xdata()) == {1.2}


def test_a_picture_needs_a_panel(tmp_path):
    with pytest.raises(InputError, match="none given"):
        render.convergence_picture(tmp_path / "none.png", [], "x")


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


def test_marks_tell_features_and_gauges_apart():
    named = [Named(f"{i}", 0.0, 1.0, gauge=i > 4) for i in range(8)]
    assert len(set(_marks(named))) == 8
