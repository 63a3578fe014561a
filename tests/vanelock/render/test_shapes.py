"""Deformed shapes, animations, sections and stresses: where points go and what colour they get."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread
from PIL.GifImagePlugin import GifImageFile

from tests.vanelock.render.conftest import radial_wave
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render import (
    Wave,
    mesh_picture,
    mode_picture,
    response_animation,
    response_picture,
    stress_picture,
    style,
)
from vanelock.render.scenes import gif
from vanelock.render.scenes.surface import surface
from vanelock.render.scenes.window import _Window
from vanelock.render.shapes import animation, shapes
from vanelock.render.shapes.meshes import _meridional_section


def black(points, shape):
    return np.zeros((len(points), 3))


@pytest.mark.parametrize("nodal_diameter", [0, 1, 3])
def test_the_deformed_ring_is_the_wave_that_goes_round_it(sector, nodal_diameter):
    """Takes radius r to r + s a cos(α - ND θ), all round the ring, of the skin and its lines."""
    part = sector(sectors=16)
    (skin,) = skins = shapes.skins_of([part], [radial_wave(part, nodal_diameter, 1e-4)])
    drawn = shapes._ring_scene(skins, nodal_diameter, 0.4, 200.0, black)
    for points, nodes in (
        (drawn.bodies[0].points, skin.surface.nodes[skin.split]),
        (drawn.lines[0].points, skin.surface.nodes),
    ):
        start = np.tile(part.points[nodes], (16, 1))
        turns = np.repeat(2 * np.pi * np.arange(16) / 16, len(nodes))
        angle = np.arctan2(start[:, 1], start[:, 0]) + turns
        radius = np.hypot(start[:, 0], start[:, 1])
        expected = radius + 200.0 * 1e-4 * np.cos(0.4 - nodal_diameter * angle)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), expected, rtol=1e-13)


def test_a_ring_hides_its_inner_faces_and_a_lone_part_does_not(sector):
    part = sector(sectors=8)
    alone = Part("vane", part.points, part.cells, "tetra10", part.node_sets, {}, 1)
    count = []
    for one in (part, alone):
        skins = shapes.skins_of([one], [radial_wave(one, 0, 1.0)])
        count.append(len(shapes._ring_scene(skins, 0, 0.0, 0.01, black).bodies[0].triangles))
    skin = surface(part)
    assert count == [8 * np.count_nonzero(~skin.cyclic), len(skin.triangles)]


def colours_in(path):
    """Numbers of clearly different colours (4 bits a channel) that fill 0.02 % of a picture."""
    pixels = (imread(path)[:, :, :3] * 15.999).astype(int).reshape(-1, 3)
    _, count = np.unique(pixels @ [256, 16, 1], return_counts=True)
    return int(np.count_nonzero(count > 2e-4 * len(pixels)))


def share_white(path):
    return float(np.mean(np.all(imread(path)[:, :, :3] > 0.999, axis=2)))


@pytest.fixture(scope="module")
def parts(sector):
    vane = sector("vane", 0.4, 0.55, 0.08, 12, (3, 4, 2))
    casing = sector("casing", 0.56, 0.6, 0.12, 12, (1, 4, 3))
    return vane, casing


def test_mesh_picture(parts, tmp_path):
    path = mesh_picture(tmp_path / "new" / "mesh.png", *parts, "Mesh")
    assert path == tmp_path / "new" / "mesh.png"
    assert imread(path).shape[:2] == (1260, 1800)
    assert colours_in(path) > 25
    assert 0.3 < share_white(path) < 0.9
    # The bands' colour is there, on balls and in the legend.
    pixels = imread(path)[:, :, :3]
    band = np.linalg.norm(pixels - [0.835, 0.369, 0.0], axis=2) < 0.12
    assert np.count_nonzero(band) > 400


def test_response_picture_shows_every_phase(parts, tmp_path):
    """Radial wave of one nodal diameter: each sixth of the cyclic map colours a sixth of it."""
    waves = [radial_wave(part, 1, 2e-5) for part in parts]
    path = response_picture(tmp_path / "response.png", parts, waves, 1, "Response")
    right = imread(path)[:, 915:1620, :3]
    for degrees in (-120, -60, 0, 60, 120):
        wanted = np.array(style.PHASE_MAP((degrees + 180) / 360)[:3])
        # Shading scales a colour; compare its direction and a broad range of lightness.
        along = right @ wanted / (wanted @ wanted)
        off = np.linalg.norm(right - along[..., None] * wanted, axis=2)
        near = (off < 0.04) & (along > 0.5) & (along < 1.1)
        assert np.count_nonzero(near) > 1000, degrees


def test_scale_and_largest_amplitude_are_stated_and_end_the_bars(
    parts, tmp_path, monkeypatch, bars
):
    texts: list[str] = []
    monkeypatch.setattr(
        style, "write", lambda figure, path: texts.extend(t.get_text() for t in figure.texts)
    )
    waves = [radial_wave(part, 1, 20e-6) for part in parts]
    response_picture(tmp_path / "r.png", parts, waves, 1, "Response")
    # 5 % of the radius 0.6 m is 30 mm: 1500 times 20 µm, rounded down to 1000.
    stated = "Largest amplitude 20.0 µm; deformation drawn 1,000 times as large."
    assert stated in texts
    mode_picture(tmp_path / "m.png", parts, waves, 1, "Mode", "Interlock free")
    assert (
        "Interlock free. Drawn at its largest deflection; largest displacement drawn as 30 mm."
        in texts
    )
    assert "Full ring, 12 sectors, nodal diameter 1" in texts
    assert bars == [
        (0, pytest.approx(20), "amplitude (µm)"),
        (-180, 180, "phase (degrees)"),
        (0, 1, "displacement / largest displacement (–)"),
    ]


def test_a_shape_of_zeros_is_refused(parts, tmp_path):
    waves = [np.zeros(part.points.shape, complex) for part in parts]
    with pytest.raises(InputError, match="zero everywhere"):
        mode_picture(tmp_path / "mode.png", parts, waves, 1, "Mode")


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
    move = _Window.move

    def heard(self, scene):
        shown.append(scene.bodies[0].points)
        move(self, scene)

    monkeypatch.setattr(_Window, "move", heard)
    monkeypatch.setattr(animation, "FRAMES", 6)
    path = response_animation(tmp_path / "wave.gif", [part], waves, "Wave")
    moving = animation._moving_parts([part], waves)
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


def area(polygon):
    x, y = polygon.T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def pipe(p):
    """Unit cube to an eighth of a pipe of 1 to 2 m, 3 m long."""
    r, a = 1 + p[:, 0], np.pi / 4 * p[:, 1]
    return np.column_stack([r * np.cos(a), r * np.sin(a), 3 * p[:, 2]])


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_a_rectangle_is_covered_once(lattice, cell_type):
    part = lattice((2, 3, 2), pipe, cell_type, curved=True)
    pieces, edges = _meridional_section(part, 0.3)
    # Of straight elements the section lies inside the arc by their sagitta at most.
    linear = cell_type in ("tetra", "hexahedron", "hexahedron20")
    sagitta = 1 - np.cos(np.pi / 24)
    tolerance = 2 * sagitta if linear else 2 * (1 - np.cos(np.pi / 48))
    assert sum(map(area, pieces)) == pytest.approx(3, rel=tolerance)
    every = np.concatenate(pieces)
    np.testing.assert_allclose(every.min(axis=0), [0, 1], atol=tolerance)
    np.testing.assert_allclose(every.max(axis=0), [3, 2], atol=2 * tolerance)
    # The outline's edges belong to one element, all others to two.
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    on_axis = np.isclose(edges[:, :, 0], 0).all(axis=1) | np.isclose(edges[:, :, 0], 3).all(axis=1)
    assert length[on_axis].sum() == pytest.approx(2, rel=2 * tolerance)


def dark(path, left):
    """Share of a panel's pixels near the map's upper end."""
    pixels = imread(path)[:, left : left + 700, :3]
    return float(np.mean(np.linalg.norm(pixels - style.AMPLITUDE_MAP(1.0)[:3], axis=2) < 0.2))


def test_colours_follow_the_stress_and_single_nodes_do_not_set_the_scale(sector, tmp_path):
    part = sector("vane", 0.4, 0.55, 0.08, 12, (3, 4, 2))
    high = np.where(part.points[:, 0] > np.median(part.points[:, 0]), 80e6, 0.0)
    outlier = high.copy()
    outlier[part.node_sets["output"]] = 1e12
    low = np.full(len(high), 1.0)
    low[0] = 1e3
    path = stress_picture(tmp_path / "a.png", part, outlier, 1e6 * low, "Stress", "case")
    assert imread(path).shape[:2] == (1035, 1800)
    assert 0.05 < dark(path, 40) < 0.5
    same = stress_picture(tmp_path / "b.png", part, high, 1e6 * low, "Stress", "case")
    assert np.mean(np.abs(imread(path) - imread(same)) > 0.05) < 5e-3
