"""Maps and ridges: every cell says its number, unknown ones that they are not known."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.render import MapPanel, RidgeLine, RidgePanel, map_picture, ridge_picture, style

ACROSS, UP = (0.5, 1.0, 2.0), (0.1, 0.3)


@pytest.fixture
def figures(monkeypatch):
    """Figures that would be written."""
    kept = []
    monkeypatch.setattr(style, "write", lambda figure, path: kept.append(figure))
    return kept


def cells(axes):
    return [text.get_text() for text in axes.texts]


def test_cells_say_their_numbers(figures):
    values = np.array([[1, 2.5, np.nan], [40, 50, 60]])
    panels = [
        MapPanel("peak", values, ".1f", logarithmic=True),
        MapPanel("holds", values > 2),
        MapPanel("error", values - 30, "+.0f", diverging=True),
        MapPanel("nothing", np.full((2, 3), np.nan)),
    ]
    map_picture("x.png", ACROSS, UP, panels, "interference (µm)", "μ", "Map", marked=(1.0, 0.3))
    peak, holds, error, nothing = figures[0].axes
    assert cells(peak) == ["1.0", "2.5", "–", "40.0", "50.0", "60.0"]
    assert cells(holds) == ["no", "yes", "no", "yes", "yes", "yes"]
    assert cells(error) == ["-29", "-28", "–", "+10", "+20", "+30"]
    assert cells(nothing) == []
    assert [label.get_text() for label in peak.get_xticklabels()] == ["0.5", "1", "2"]
    (frame,) = [patch for patch in peak.patches if patch.get_linewidth() > 2]
    assert frame.get_xy() == (1.0, 1.0)  # the cell of 1 um and 0.3


def test_texts_stand_out_from_their_cells(figures):
    values = np.linspace(1, 100, 6).reshape(2, 3)
    map_picture("x.png", ACROSS, UP, [MapPanel("peak", values)], "x", "y", "Map")
    mesh = figures[0].axes[0].collections[0]
    shades = mesh.to_rgba(mesh.get_array()).reshape(-1, 4)[:, :3].mean(axis=1)
    for text, shade in zip(figures[0].axes[0].texts, shades, strict=True):
        assert (shade > 0.5) == (text.get_color() != "white")


def test_a_panel_must_fit_the_plane():
    with pytest.raises(InputError, match=r"map peak: shape \(3, 2\): \(2, 3\) is needed"):
        map_picture("x.png", ACROSS, UP, [MapPanel("peak", np.ones((3, 2)))], "x", "y", "Map")


def test_ridges_show_their_least_and_the_limits(figures):
    mu = np.geomspace(0.01, 1, 9)
    line = RidgeLine(mu, 1e-5 * (1 + np.log(mu / 0.1) ** 2), "H = 1", (0.1, 1e-5))
    panel = RidgePanel("friction", [line], [("linear, free", 9e-5)], marked=0.3)
    ridge_picture("x.png", [panel], "Peak")
    axes = figures[0].axes[0]
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["H = 1: least 10.0 µm at 0.1", "linear, free", "this study"]
    drawn = axes.lines[0]
    np.testing.assert_allclose(drawn.get_ydata(), 10 * (1 + np.log(mu / 0.1) ** 2))
    assert axes.get_xscale() == axes.get_yscale() == "log"


def test_ridges_come_in_one_or_two_panels():
    with pytest.raises(InputError, match="given 0 panels: allowed are 1 and 2"):
        ridge_picture("x.png", [], "Peak")
