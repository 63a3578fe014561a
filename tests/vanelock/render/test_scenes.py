"""Where things land in a picture, sectors around the ring, skins of parts, files for ParaView."""

import sys

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.common.process import missing_libraries
from vanelock.mesh import Part
from vanelock.render import write_vtu
from vanelock.render.scenes import annulus, offscreen
from vanelock.render.scenes.surface import surface


def wave(points, nodal_diameter):
    """A field given on the whole ring: u(θ) = (a e_r + b e_θ + c e_z) e^{-i ND θ}."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    around = np.column_stack([-np.sin(angle), np.cos(angle), 0 * angle])
    axial = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    phase = np.exp(-1j * nodal_diameter * angle)[:, None]
    return (0.3 * radial + (0.2 - 0.5j) * around + 0.7j * axial) * phase


def test_peak_is_the_largest_length_in_a_cycle():
    random = np.random.default_rng(4)
    shape = random.standard_normal((20, 3)) + 1j * random.standard_normal((20, 3))
    steps = np.linspace(0, 2 * np.pi, 20001)
    lengths = [np.linalg.norm(annulus.at(shape, angle), axis=1) for angle in steps]
    np.testing.assert_allclose(annulus.peak(shape), np.max(lengths, axis=0), rtol=1e-7)


def test_largest_instant_over_two_shapes():
    random = np.random.default_rng(5)
    a, b = (random.standard_normal((9, 3)) + 1j * random.standard_normal((9, 3)) for _ in range(2))

    def energy(angle):
        return sum(float(np.sum(annulus.at(shape, angle) ** 2)) for shape in (a, b))

    best = max(energy(angle) for angle in np.linspace(0, np.pi, 10001))
    assert energy(annulus.largest_instant(a, b)) == pytest.approx(best, rel=1e-6)


def test_cylindrical_components_and_names_of_known_waves(sector):
    part = sector(sectors=16)
    angle = np.arctan2(part.points[:, 1], part.points[:, 0])
    given = annulus.cylindrical(part.points, wave(part.points, 1))
    expected = np.exp(-1j * angle)[:, None] * np.array([0.3, 0.2 - 0.5j, 0.7j])
    np.testing.assert_allclose(given, expected, atol=1e-14)
    assert annulus.wave_name(1, 16) == "nodal diameter 1"
    assert annulus.wave_name(8, 16) == "nodal diameter 8"
    assert annulus.wave_name(15, 16) == "nodal diameter 1, backward wave"
    assert annulus.wave_name(-1, 16) == "nodal diameter 1, backward wave"


def volume(points, triangles):
    """Volume inside a closed skin whose triangles wind outwards (divergence theorem)."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.sum(a * np.cross(b, c)) / 6


def area(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def prism_volume(sectors, steps, inner, outer, length):
    """Volume of a sector whose arcs are `steps` straight chords."""
    step = 2 * np.pi / sectors / steps
    return steps * 0.5 * np.sin(step) * (outer**2 - inner**2) * length


@pytest.mark.parametrize("corners_only", [False, True])
@pytest.mark.parametrize("cell_type", ["tetra", "tetra10"])
def test_skin_of_a_sector_encloses_its_volume(sector, cell_type, corners_only):
    part = sector(sectors=8, divisions=(2, 4, 3))
    cells = part.cells[:, :4] if cell_type == "tetra" else part.cells
    part = Part("casing", part.points, cells, cell_type, part.node_sets, {}, 8)
    skin = surface(part, corners_only=corners_only)
    points = part.points[skin.nodes]
    expected = prism_volume(8, 4, 0.5, 0.6, 0.1)
    assert volume(points, skin.triangles) == pytest.approx(expected, rel=1e-12)


def test_cyclic_faces_have_their_area_and_the_outline_is_the_edges(sector):
    """Four straight edges along z, four along r, and four arcs of chords of 11.25 degrees."""
    part = sector(sectors=8)
    skin = surface(part)
    hidden = skin.triangles[skin.cyclic]
    assert area(part.points[skin.nodes], hidden) == pytest.approx(2 * 0.1 * 0.1, rel=1e-12)
    part = sector(sectors=8, divisions=(2, 4, 3))
    skin = surface(part)
    points = part.points[skin.nodes]
    length = np.linalg.norm(np.diff(points[skin.outline], axis=1), axis=2).sum()
    arcs = 2 * 4 * 2 * np.sin(np.pi / 8 / 4) * (0.5 + 0.6)
    assert length == pytest.approx(4 * 0.1 + 4 * 0.1 + arcs, rel=1e-12)


@pytest.mark.parametrize(
    ("cell_type", "nodes"), [("hexahedron", 8), ("hexahedron20", 20), ("hexahedron27", 26)]
)
def test_bricks(lattice, cell_type, nodes):
    part = lattice((1, 1, 1), lambda p: p * [1.0, 2.0, 3.0], cell_type)
    skin = surface(part)
    points = part.points[skin.nodes]
    assert len(skin.nodes) == nodes
    assert volume(points, skin.triangles) == pytest.approx(6.0, rel=1e-12)
    assert area(points, skin.triangles) == pytest.approx(22.0, rel=1e-12)
    for edges, expected in ((skin.outline, 24.0), (skin.mesh_edges, 24.0)):
        length = np.linalg.norm(np.diff(points[edges], axis=1), axis=2).sum()
        assert length == pytest.approx(expected, rel=1e-12)


def test_other_elements_are_refused():
    part = Part("brick", np.eye(3), np.array([[0, 1, 2]]), "triangle", {}, {}, 1)
    with pytest.raises(InputError, match="brick: element type triangle: pictures know tetra"):
        surface(part)


@pytest.fixture
def unknown():
    """Forget what was found out about this machine, before and after."""
    offscreen.trial.cache_clear()
    yield
    offscreen.trial.cache_clear()


def test_this_machine_draws_and_a_trial_that_crashes_or_errs_does_not_count(unknown):
    assert missing_libraries(["libc.so.6", "libNoSuchThing.so.1"]) == ["libNoSuchThing.so.1"]
    assert offscreen._render_window() in ("vtkEGLRenderWindow", "")
    crash = "import ctypes; ctypes.string_at(0)"  # a segmentation fault, as VTK's
    assert offscreen._draws("", "pass")
    assert not offscreen._draws("", crash)
    blue = offscreen._PROBE.replace("SetBackground(1.0, 0.0, 0.0)", "SetBackground(0.0, 0.0, 1.0)")
    assert offscreen._draws(offscreen._render_window())
    assert not offscreen._draws(offscreen._render_window(), blue)


@pytest.mark.parametrize(
    ("name", "value"),
    [("missing_libraries", lambda libraries: list(libraries)), ("_draws", lambda window: False)],
)
def test_the_message_says_what_to_install(unknown, monkeypatch, name, value):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(offscreen, name, value)
    with pytest.raises(InputError) as raised:
        offscreen.pyvista()
    message = str(raised.value)
    assert "apt-get install libgl1 libegl1 libgl1-mesa-dri" in message
    assert "\n" not in message


def test_shape_and_sets_come_back(sector, tmp_path):
    part = sector()
    random = np.random.default_rng(2)
    shape = random.standard_normal(part.points.shape) + 1j * random.standard_normal(
        part.points.shape
    )
    path = write_vtu(tmp_path / "shapes" / "casing.vtu", part, shape)
    mesh = offscreen.pyvista().read(path)
    np.testing.assert_array_equal(mesh.points, part.points)
    np.testing.assert_array_equal(mesh.cells.reshape(-1, 11)[:, 1:], part.cells)
    assert set(mesh.celltypes) == {24}  # VTK_QUADRATIC_TETRA
    data = mesh.point_data
    back = data["displacement_real (m)"] + 1j * data["displacement_imag (m)"]
    np.testing.assert_array_equal(back, shape)
    np.testing.assert_array_equal(data["amplitude (m)"], annulus.peak(shape))
    assert np.count_nonzero(data["left"]) == len(part.node_sets["left"])
    places = np.arange(1, len(part.node_sets["left"]) + 1)
    np.testing.assert_array_equal(data["left"][part.node_sets["left"]], places)
    # Straight-sided: its volume is that of four chords of an eighth of the annulus.
    volume = 4 * 0.5 * np.sin(np.pi / 16) * (0.6**2 - 0.5**2) * 0.1
    assert mesh.volume == pytest.approx(volume, rel=1e-9)
