"""Animations: what each frame shows, against the wave's closed form, and what the file holds."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread
from PIL.GifImagePlugin import GifImageFile

from tests.vanelock.render.conftest import radial_wave
from vanelock.common.errors import InputError
from vanelock.render import Wave, mode_animation, response_animation, style
from vanelock.render.scenes import gif
from vanelock.render.scenes.window import Window
from vanelock.render.shapes import animation
from vanelock.render.shapes.shapes import skins_of

FIRST, SECOND = 1e-4, 3e-5


@pytest.fixture
def two_waves(sector):
    """A part with harmonic 1 of nodal diameter 1 and harmonic 2 of nodal diameter 14 of 16."""
    part = sector(sectors=16)
    waves = [
        Wave(1, 1, [radial_wave(part, 1, FIRST)]),
        Wave(2, 14, [radial_wave(part, -2, SECOND)]),
    ]
    return part, waves


def expected_radius(start, turns, alpha, scale):
    """R + s Σ a_h cos(hα - ND_h θ) at nodes of sector 0 turned to their sectors."""
    angle = np.arctan2(start[:, 1], start[:, 0]) + turns
    moved = FIRST * np.cos(alpha - angle) + SECOND * np.cos(2 * alpha + 2 * angle)
    return np.hypot(start[:, 0], start[:, 1]) + scale * moved, np.abs(moved)


def test_the_frames_divide_the_period_and_the_file_holds_them(two_waves, tmp_path, monkeypatch):
    part, waves = two_waves
    shown: list[np.ndarray] = []
    move = Window.move

    def heard(self, scene):
        shown.append(scene.bodies[0].points)
        move(self, scene)

    monkeypatch.setattr(Window, "move", heard)
    path = response_animation(tmp_path / "wave.gif", [part], waves, "Wave", frames=6)
    moving = animation.moving_parts([part], waves)
    split = moving[0].skin.split
    start = np.tile(moving[0].skin.points[split], (16, 1))
    turns = np.repeat(2 * np.pi * np.arange(16) / 16, len(split))
    assert len(shown) == 6
    # 5 % of the radius 0.6 m is 30 mm: 300 times 0.1 mm, rounded down to 200.
    for k, points in enumerate(shown):
        radius, _ = expected_radius(start, turns, 2 * np.pi * k / 6, 200.0)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), radius, rtol=1e-12)
    with GifImageFile(path) as file:
        assert file.n_frames == 6
        assert file.info["loop"] == 0
        assert file.info["duration"] == animation.MILLISECONDS
        frames = []
        for k in range(6):
            file.seek(k)
            frames.append(np.asarray(file.convert("RGB"), int))
    assert all(np.mean(np.abs(a - b)) > 1 for a, b in pairwise(frames))
    assert np.mean(frames[0].min(axis=2) == 255) > 0.4


def test_a_mode_is_drawn_as_large_as_in_its_picture(sector, tmp_path, monkeypatch):
    part = sector(sectors=8)
    texts: list[str] = []
    figure = style.figure

    def noted(height, title, subtitle, width):
        texts.append(subtitle)
        return figure(height, title, subtitle, width)

    monkeypatch.setattr(style, "figure", noted)
    reached: list[np.ndarray] = []
    monkeypatch.setattr(Window, "move", lambda _, scene: reached.append(scene.bodies[0].points))
    for scale in (1.0, 1e-6):
        wave = [radial_wave(part, 2, scale)]
        mode_animation(tmp_path / "mode.gif", [part], wave, 2, "Mode", "Free", frames=4)
    assert texts == ["Free. Largest displacement drawn as 30 mm."] * 2
    for one, other in zip(reached[:4], reached[4:], strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    assert np.hypot(reached[0][:, 0], reached[0][:, 1]).max() == pytest.approx(0.63, abs=1e-3)


def test_a_thinned_skin_has_fewer_triangles_over_the_same_body(sector):
    part = sector(sectors=8, divisions=(2, 24, 12))
    whole = skins_of([part], [radial_wave(part, 0, 1.0)], corners_only=True)[0]
    thin = animation.thinned(whole, 400)
    shown = whole.triangles[~whole.surface.cyclic]
    assert len(thin.triangles) <= 401 < len(shown) / 3
    assert np.isin(thin.surface.nodes, whole.surface.nodes).all()
    assert len(thin.surface.nodes) < len(whole.surface.nodes) / 2
    np.testing.assert_array_equal(thin.shape, radial_wave(part, 0, 1.0)[thin.surface.nodes])

    def measured(skin, triangles):
        """Area, and the nodes of the open edges, which the next sector's meet."""
        a, b, c = (skin.points[skin.split[triangles[:, i]]] for i in range(3))
        nodes = skin.surface.nodes[skin.split[triangles]]
        edges = np.sort(np.concatenate([nodes[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
        unique, count = np.unique(edges, axis=0, return_counts=True)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2, unique[count == 1]

    area, edge = measured(thin, thin.triangles)
    expected, border = measured(whole, shown)
    assert area == pytest.approx(expected, rel=5e-3)
    np.testing.assert_array_equal(edge, border)


def test_a_static_part_is_no_wave(two_waves, tmp_path):
    part, waves = two_waves
    with pytest.raises(InputError, match="harmonic: given 0: must be at least 1"):
        response_animation(tmp_path / "a.gif", [part], [Wave(0, 0, waves[0].shapes)], "Wave")


def test_pixels_of_a_gif_are_those_given(tmp_path):
    ramp = np.linspace(0, 254, 64).astype(np.uint8)
    first = np.full((40, 64, 3), 255, np.uint8)
    first[10:30] = np.stack([ramp, ramp[::-1], np.full(64, 128, np.uint8)], axis=-1)
    frames = [first, first[::-1, ::-1].copy(), np.roll(first, 9, axis=0)]
    path = gif.write_gif(tmp_path / "new" / "a.gif", frames, 50)
    with GifImageFile(path) as file:
        for k, frame in enumerate(frames):
            file.seek(k)
            read = np.asarray(file.convert("RGB"), int)
            assert np.abs(read - frame).max() <= 12
            np.testing.assert_array_equal(read[frame.min(axis=2) == 255], 255)
    assert imread(path).shape[:2] == (40, 64)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        gif.write_gif(tmp_path / "file" / "a.gif", frames, 50)
