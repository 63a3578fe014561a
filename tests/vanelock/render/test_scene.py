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


@pytest.mark.parametrize(
    ("size", "part", "columns", "rows"),
    [((300, 300), 0.5, (75, 224), (75, 224)), ((200, 400), 1.0, (0, 199), (100, 299))],
)
def test_the_fitted_body_fills_the_picture_or_its_width(size, part, columns, rows):
    body = scene.SceneBody(part * SQUARE, TRIANGLES, "black")
    dark = window.snapshot(scene.DrawnScene(DOWN, [body]), size).max(axis=2) < 128
    for found, expected in zip(np.nonzero(dark), (rows, columns), strict=True):
        assert (found.min(), found.max()) == pytest.approx(expected, abs=0.5 if part < 1 else 1)


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
