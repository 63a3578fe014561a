"""The drawings name every dimension with its value, and their texts can be read."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Text
from pydantic import BaseModel

from vanelock.mesh import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.checks.root_fillets import filleted
from vanelock.mesh.geometry.revolved import casing_outline, hooks_outline
from vanelock.render import casing_drawing, style, vane_drawing
from vanelock.render.drawings import drafting
from vanelock.render.drawings.captions import caption
from vanelock.render.drawings.casing_sheet import casing_sheet
from vanelock.render.drawings.sections import polar, revolved, section
from vanelock.render.drawings.vane_sheet import vane_sheet

DESIGNS: dict[str, tuple[dict[str, Any], dict[str, Any], int]] = {
    "usual": ({}, {}, 16),
    "many sectors": ({"aerofoils": 1}, {}, 60),
    "leaning and twisted": ({"lean": 9.5, "twist": -14.0, "interlock_slant": -20.0}, {}, 16),
    "few sectors, filleted": ({"fillet": 0.0012}, {"fillet": 0.0012}, 6),
    "stagger the other way, bosses": (
        {"stagger": -42.5, "camber": 0.0, "aerofoils": 2},
        {"bosses": 2, "boss_diameter": 0.022, "boss_height": 0.03},
        18,
    ),
    "thick": ({"thickness": 0.009, "edge_thickness": 0.006, "chord": 0.06}, {}, 12),
}


def sheets(design):
    vane, casing, sectors = design
    made = VaneDimensions(**vane), CasingDimensions(**casing), sectors, "a name"
    return {"vane": vane_sheet(*made), "casing": casing_sheet(*made)}


def texts(figure):
    return [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]


def names(model, prefix=""):
    for name, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from names(field.annotation, f"{prefix}{name}.")
        else:
            yield prefix + name


@pytest.fixture(scope="module", params=DESIGNS)
def drawn(request):
    return DESIGNS[request.param], sheets(DESIGNS[request.param])


def test_every_dimension_has_its_name_and_value(drawn):
    (vane, casing, sectors), figures = drawn
    written = {
        part: {t.get_text().partition(",")[0] for t in texts(f)} for part, f in figures.items()
    }
    one = filleted(VaneDimensions(**vane), sectors)
    other = CasingDimensions(**casing)
    assert {caption(one, name) for name in names(VaneDimensions)} <= written["vane"]
    assert {caption(other, name) for name in names(CasingDimensions)} <= written["casing"]
    assert "hook.roof_radius" in set(names(VaneDimensions))
    assert len(set(names(HookDimensions))) >= 5


def test_no_text_touches_another_or_leaves_its_panel(drawn):
    for figure in drawn[1].values():
        renderer = figure.canvas.get_renderer()
        boxes = [(t, t.get_window_extent(renderer)) for t in texts(figure)]
        for (one, a), (two, b) in combinations(boxes, 2):
            assert not a.padded(-1).overlaps(b.padded(-1)), (one.get_text(), two.get_text())
        for text, box in boxes:
            home = figure.bbox if text.axes is None else text.axes.bbox
            assert home.x0 <= box.x0, text
            assert box.x1 <= home.x1, text
            assert home.y0 <= box.y0, text
            assert box.y1 <= home.y1, text
        for one, two in combinations(figure.axes, 2):
            assert not one.bbox.padded(-1).overlaps(two.bbox.padded(-1))


def test_what_is_drawn_lies_in_its_panel(drawn):
    for figure in drawn[1].values():
        for axes in figure.axes:
            inside = axes.bbox.padded(1)
            assert axes.patches
            for artist in [*axes.lines, *axes.patches]:
                window = artist.get_clip_box()
                if window is axes.bbox:  # not cut at the view's border
                    points = axes.transData.transform(artist.get_xydata())
                    assert inside.count_contains(points) == len(points)
                else:
                    assert inside.count_contains(window.corners()) == 4


def test_a_boss_is_solid_where_the_sector_has_one_and_dashed_where_not(drawn):
    (_, given, _), figures = drawn
    casing = CasingDimensions(**given)
    at, radius = 1e3 * casing.boss_position, 500 * casing.boss_diameter
    low = 1e3 * casing.outer_radius
    box = [[at - radius, low], [at + radius, low + 1e3 * casing.boss_height]]

    def spans(points):
        corners = np.asarray(points)
        return len(corners) > 3 and np.allclose([corners.min(axis=0), corners.max(axis=0)], box)

    solid = [p for p in figures["casing"].findobj(Polygon) if spans(p.get_xy())]
    dashed = [line for line in figures["casing"].findobj(Line2D) if spans(line.get_xydata())]
    assert bool(solid) == (casing.bosses > 0)
    assert bool(dashed) == (casing.bosses == 0)


def test_a_place_seen_from_the_front_has_its_angle_from_the_top():
    np.testing.assert_allclose(polar(0.2, np.pi / 6), [100.0, 100 * 3**0.5])


def test_values_have_units():
    vane = VaneDimensions(chord=0.0475, stagger=30.5, aerofoils=3)
    assert caption(vane, "chord") == "chord  47.5"
    assert caption(vane, "stagger") == "stagger  30.5°"
    assert caption(vane, "aerofoils") == "aerofoils  3"
    assert caption(vane, "outer_shroud_extent") == "outer_shroud_extent  0.96 × pitch"
    assert caption(vane, "hook.mid_plane", "vane.") == "vane.hook.mid_plane  100"


def test_a_view_is_to_scale():
    figure = style.figure(6.0, "")
    view = drafting.view(figure, (1, 1, 8, 4), (1, 2, 0.5, 0.5), (0, 10), (100, 40), "")
    assert view.scale == pytest.approx(20)  # mm on an inch: 100 mm in 8 - 3 inches
    inch = style.DPI
    places = view.axes.transData.transform([(0, 10), (100, 40)]) / inch
    # 1.5 inches of the 3 that there are, in their middle.
    np.testing.assert_allclose(places, [(2, 1 + 0.5 + 0.75), (7, 1 + 0.5 + 0.75 + 1.5)])
    assert drafting.distance(view, (10, 20), (30, 20), 0.25) == pytest.approx((20, 25))
    assert drafting.sweep(view, (0, 0), 10, 90, 0) == pytest.approx((50**0.5, 50**0.5))


def test_labels_that_crowd_are_spread_evenly():
    found = drafting.spread([1.0, 5.0, 5.0, 5.1, 9.0], 1.0, 0.0, 10.0)
    np.testing.assert_allclose(found, [1.0, 5.1 / 3 + 10 / 3 - 1, 15.1 / 3, 15.1 / 3 + 1, 9.0])
    np.testing.assert_allclose(drafting.spread([0.1, 0.1], 1.0, 0.0, 10.0), [0.0, 1.0])
    np.testing.assert_allclose(drafting.spread([9.9, 9.9], 1.0, 0.0, 10.0), [9.0, 10.0])
    assert len(drafting.spread([], 1.0, 0.0, 1.0)) == 0


def test_the_files(tmp_path):
    sheet = VaneDimensions(), CasingDimensions(), 16
    for draw in (vane_drawing, casing_drawing):
        picture = imread(draw(tmp_path / "made" / "sheet.png", *sheet))
        assert picture.shape[:2] == (1755, 2700)
        assert (picture.min(axis=2) < 0.5).mean() > 0.005


def enclosed(points):
    x, y = np.asarray(points).T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_fillets_are_drawn_as_arcs():
    """Each of a rail's four, and of a leg's three, fills (1 - π/4) of a square, mm²."""
    corner = (1 - np.pi / 4) * 1.2**2
    sharp, rounded = (CasingDimensions(fillet=r) for r in (0, 0.0012))
    areas = [enclosed(revolved(casing_outline(c, HookDimensions()))) for c in (sharp, rounded)]
    assert areas[0] == pytest.approx(200 * 4 + 2 * 10 * 21 + 2 * (24 * 22 - 16 * 8), rel=1e-12)
    assert areas[1] - areas[0] == pytest.approx(8 * corner, rel=0.02)
    legs = [enclosed(revolved(hooks_outline(VaneDimensions(fillet=r)))) for r in (0, 0.0012)]
    assert legs[1] - legs[0] == pytest.approx(6 * corner, rel=0.02)


@pytest.mark.parametrize("along", [None, 0.432, 0.567])
def test_an_aerofoil_s_section_closes(along):
    """Its area: a parabolic thickness between the rounded edges, and two parabolas there."""
    vane = VaneDimensions(camber=0.0, twist=8.0)
    points = section(vane, along)
    mean = vane.edge_thickness + 2 / 3 * (vane.thickness - vane.edge_thickness)
    edge = vane.edge_thickness
    area = (vane.chord - edge) * mean + 2 / 3 * edge**2
    # Straight lines join the twisted sections: in the middle they pass nearer to the axis.
    shrink = np.cos(np.radians(4)) if along is None else 1.0
    assert enclosed(points) == pytest.approx(shrink**2 * area, rel=3e-3)
    steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    assert steps.max() < vane.chord / 30
    stagger = np.radians(vane.stagger + (0 if along is None else 4 * np.sign(along - 0.5)))
    reach = points @ [np.sin(stagger), np.cos(stagger)]
    assert np.ptp(reach) == pytest.approx(shrink * vane.chord, rel=1e-3)
