"""Where things land in a picture, and what colour they have there."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from vanelock.render import style
from vanelock.render.scenes import scene, views, window
from vanelock.render.scenes.surface import surface

SQUARE = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
DOWN = scene.Camera((0, 0, -1), (0, 1, 0), SQUARE, margin=1.0)


def centre_of(picture, chosen):
    rows, columns = np.nonzero(chosen)
    return columns.mean(), rows.mean()


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.5, -0.25), (-0.8, 0.7)])
def test_a_mark_lands_where_the_projection_puts_it(place):
    mark = scene.Marks(np.array([[*place, 0.0]]), style.VERMILION, 14)
    drawn = scene.DrawnScene(DOWN, [scene.SceneBody(SQUARE, TRIANGLES, "white")], marks=[mark])
    picture = window.snapshot(drawn, (400, 400))
    red = (picture[:, :, 0] > 120) & (picture[:, :, 2] < 60)
    # x = -1 ... 1 fills 400 pixels; rows count downwards.
    expected = (200 + 200 * place[0] - 0.5, 200 - 200 * place[1] - 0.5)
    assert centre_of(picture, red) == pytest.approx(expected, abs=0.8)


@pytest.mark.parametrize(
    ("size", "part", "columns", "rows"),
    [((300, 300), 0.5, (75, 224), (75, 224)), ((200, 400), 1.0, (0, 199), (100, 299))],
)
def test_the_fitted_body_fills_the_picture_or_its_width(size, part, columns, rows):
    body = scene.SceneBody(part * SQUARE, TRIANGLES, "black")
    dark = window.snapshot(scene.DrawnScene(DOWN, [body]), size).max(axis=2) < 128
    for found, expected in zip(np.nonzero(dark), (rows, columns), strict=True):
        assert (found.min(), found.max()) == pytest.approx(expected, abs=0.5 if part < 1 else 1)


def test_a_hidden_mark_shines_through_paler():
    above = np.array([0.0, 0.0, 1.0])
    cover = scene.SceneBody(SQUARE + above, TRIANGLES, "white")
    points = np.array([[0.3, 0.0, 0.0]])

    def weight(position):
        marks = [scene.Marks(points + position * above, style.BLUE, 20)]
        picture = window.snapshot(scene.DrawnScene(DOWN, [cover], marks=marks), (200, 200))
        return float(np.sum(255.0 - picture[:, 125:136, 0]))

    background = window.snapshot(scene.DrawnScene(DOWN, [cover]), (200, 200))
    empty = float(np.sum(255.0 - background[:, 125:136, 0]))
    hidden, open_ = weight(0.0) - empty, weight(2.0) - empty
    assert 0.3 < hidden / open_ < 0.6  # drawn at a strength of 0.45


def test_a_body_has_the_colours_given_at_its_points():
    shades = np.array([to_rgb("red"), to_rgb("red"), to_rgb("blue"), to_rgb("blue")])
    picture = window.snapshot(
        scene.DrawnScene(DOWN, [scene.SceneBody(SQUARE, TRIANGLES, shades)]), (100, 100)
    )
    low, high = picture[95, 50].astype(int), picture[5, 50].astype(int)
    assert low[0] > 200 > 40 > low[2]
    assert high[2] > 200 > 40 > high[0]


def test_colours_follow_maps_the_phase_map_closes_and_repeated_bodies_keep_their_points():
    shown = scene.colours(np.array([0.0, 5.0, 10.0, np.nan]), style.AMPLITUDE_MAP, 0, 10)
    expected = [style.AMPLITUDE_MAP(v)[:3] for v in (0.0, 0.5, 1.0)] + [to_rgb(style.LIGHT)]
    np.testing.assert_allclose(shown, expected, atol=1e-12)
    np.testing.assert_allclose(style.PHASE_MAP(0.0), style.PHASE_MAP(1.0), atol=1e-12)
    given = scene.repeat(np.array([[0, 1, 2], [1, 2, 3]]), 4, 3)
    repeated = [[0, 1, 2], [1, 2, 3], [4, 5, 6], [5, 6, 7], [8, 9, 10], [9, 10, 11]]
    np.testing.assert_array_equal(given, repeated)


def test_smooth_surface_doubles_points_on_sharp_edges_only(sector):
    part = sector(sectors=8, divisions=(2, 4, 3))
    skin = surface(part)
    points = part.points[skin.nodes]
    place, triangles = scene.smooth_surface(points, skin)
    np.testing.assert_array_equal(place[triangles], skin.triangles)
    copies = np.bincount(place, minlength=len(points))
    sharp = np.zeros(len(points), bool)
    sharp[skin.outline.ravel()] = True
    assert np.all(copies[sharp] >= 2)
    assert np.all(copies[~sharp] == 1)


@pytest.mark.parametrize("turned", [0.0, 1.0, 2.5, -2.0])
def test_views_turn_with_the_sector(sector, turned):
    """A sector anywhere on the ring is seen from the same side, its outer side up."""
    part = sector(sectors=16)
    c, s = np.cos(turned), np.sin(turned)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for view in (views.sector_camera, views.ring_camera):
        here, there = view(part.points), view(part.points @ R.T)
        np.testing.assert_allclose(there.direction, R @ here.direction, atol=1e-12)
        np.testing.assert_allclose(there.up, R @ here.up, atol=1e-12)
    middle = part.points.mean(axis=0) * [1, 1, 0]
    assert views.sector_camera(part.points).up @ middle == pytest.approx(np.linalg.norm(middle))
