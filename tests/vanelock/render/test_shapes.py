"""Deformed shapes: where points go, what colour they get, and that pictures show them."""

import numpy as np
import pytest
from matplotlib.image import imread

from tests.vanelock.render.conftest import radial_wave
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render import mesh_picture, mode_picture, response_picture, style
from vanelock.render.scenes import annulus
from vanelock.render.scenes.surface import surface
from vanelock.render.shapes import shapes


def black(points, shape):
    return np.zeros((len(points), 3))


@pytest.mark.parametrize("nodal_diameter", [0, 1, 3])
def test_the_deformed_ring_is_the_wave_that_goes_round_it(sector, nodal_diameter):
    """Takes radius r to r + s a cos(α - ND θ), all round the ring, of the skin and its lines."""
    part = sector(sectors=16)
    (skin,) = skins = shapes.skins_of([part], [radial_wave(part, nodal_diameter, 1e-4)])
    drawn = shapes.ring_scene(skins, nodal_diameter, 0.4, 200.0, black)
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
        count.append(len(shapes.ring_scene(skins, 0, 0.0, 0.01, black).bodies[0].triangles))
    skin = surface(part)
    assert count == [8 * np.count_nonzero(~skin.cyclic), len(skin.triangles)]


def test_the_sector_is_drawn_at_its_largest_deflection(sector):
    part = sector(sectors=16)
    shape = radial_wave(part, 0, 1e-3) * np.exp(0.7j)
    angle = annulus.largest_instant(shape)
    skins = shapes.skins_of([part], [shape])
    body = shapes.sector_scene(skins, angle, 10.0, black).bodies[0]
    moved = np.hypot(body.points[:, 0], body.points[:, 1])
    still = np.hypot(*part.points[skins[0].surface.nodes][skins[0].split, :2].T)
    np.testing.assert_allclose(np.abs(moved - still), 1e-2, rtol=1e-12)


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


def test_mode_picture_does_not_depend_on_the_scale_and_an_unwritable_place_is_refused(
    parts, tmp_path
):
    waves = [radial_wave(part, 2, 1.0) for part in parts]
    first = mode_picture(tmp_path / "a.png", parts, waves, 2, "Mode 1")
    assert colours_in(first) > 40
    assert 0.3 < share_white(first) < 0.9
    second = mode_picture(tmp_path / "b.png", parts, [1e-5 * w for w in waves], 2, "Mode 1")
    assert np.mean(np.abs(imread(first) - imread(second)) > 0.02) < 1e-3
    (tmp_path / "file").write_text("")
    waves = [radial_wave(part, 1, 1.0) for part in parts]
    with pytest.raises(InputError, match="cannot be written"):
        mode_picture(tmp_path / "file" / "mode.png", parts, waves, 1, "Mode")


def test_response_picture_shows_every_phase(parts, tmp_path):
    """Radial wave of one nodal diameter: each sixth of the cyclic map colours a sixth of it."""
    waves = [radial_wave(part, 1, 2e-5) for part in parts]
    path = response_picture(tmp_path / "response.png", parts, waves, 1, "Response", component=0)
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


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (lambda w: w[:1], "given 1: 2, one for each part, needed"),
        (lambda w: [w[0][:-1], w[1]], r"vane: shape of \(\d+, 3\): \(\d+, 3\) is needed"),
        (lambda w: [np.nan * w[0], w[1]], "vane: shape holds values that are not finite"),
        (lambda w: [0 * one for one in w], "zero everywhere"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(parts, tmp_path, bad, message):
    waves = [radial_wave(part, 1, 1.0) for part in parts]
    with pytest.raises(InputError, match=message):
        mode_picture(tmp_path / "mode.png", parts, bad(waves), 1, "Mode")
