"""Strains, stresses and gauges against fields that are known."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.fem.conftest import CELLS, STEEL, bent
from tests.refusals import refused
from vanelock import mesh
from vanelock.fem import (
    assemble,
    excess_by_element,
    excess_stiffness,
    gauge,
    peak_von_mises,
    strain,
    stresses,
    von_mises,
)
from vanelock.fem.gauges import skin
from vanelock.fem.stresses import turned
from vanelock.mesh.cells import surface


def tensor(s):
    """(n, 3, 3) stress tensors of Voigt vectors."""
    x, y, z, yz, zx, xy = np.moveaxis(s, 1, 0)
    return np.array([[x, xy, zx], [xy, y, yz], [zx, yz, z]]).transpose(2, 0, 1)


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_linear_field_gives_its_strain_at_every_node(lattice, cell_type):
    part = lattice((2, 3, 2), bent, cell_type, curved=True)
    G = np.array([[0.3, -0.2, 0.5], [0.7, -0.4, 0.1], [0.9, -0.8, 0.6]])  # ∂u_i/∂x_j
    fields = np.stack([part.points @ G.T, 2j * part.points @ G.T], axis=2)
    expected = [0.3, -0.4, 0.6, 0.1 - 0.8, 0.5 + 0.9, -0.2 + 0.7]
    found = strain(part, fields)
    np.testing.assert_allclose(found[:, :, 0], np.tile(expected, (len(found), 1)), atol=1e-13)
    np.testing.assert_allclose(found[:, :, 1], 2j * found[:, :, 0], atol=1e-13)
    assert np.array_equal(strain(part, fields[..., 1]), found[..., 1])


def test_blocks_of_elements_change_nothing(lattice, monkeypatch):
    part = lattice((3, 3, 2), bent, "tetra10", curved=True)
    u = np.random.default_rng(1).standard_normal((len(part.points), 3, 2))
    model = assemble(part, STEEL)
    whole, form = strain(part, u), excess_stiffness(model, u)
    monkeypatch.setattr(stresses, "_ENTRIES", 5000)
    assert np.abs(strain(part, u) - whole).max() < 1e-13 * np.abs(whole).max()
    np.testing.assert_allclose(excess_stiffness(model, u), form, rtol=1e-12)
    each = excess_by_element(model, u[:, :, 0])
    assert (len(each), each.min() > 0) == (len(part.cells), True)
    assert each.sum() == pytest.approx(form[0, 0], rel=1e-12)


def test_turning_the_body_turns_stress_and_strain():
    rng = np.random.default_rng(4)
    s = rng.standard_normal((5, 6))
    angle = 0.7
    R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    np.testing.assert_allclose(tensor(turned(s, R)), R @ tensor(s) @ R.T, atol=1e-14)
    e = s * [1, 1, 1, 2, 2, 2]
    np.testing.assert_allclose(turned(e, R, shear=2.0), turned(s, R) * [1, 1, 1, 2, 2, 2])
    assert von_mises(turned(s, R)) == pytest.approx(von_mises(s), rel=1e-13)


def test_von_mises_is_the_deviator_s_norm():
    s = np.random.default_rng(5).standard_normal((7, 6))
    deviator = tensor(s) - np.eye(3) * (s[:, :3].sum(axis=1) / 3)[:, None, None]
    expected = np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))
    assert von_mises(s) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("harmonics", [1, 3])
def test_peak_over_a_period_against_fine_sampling(harmonics):
    rng = np.random.default_rng(6)
    s = rng.standard_normal((harmonics + 1, 300, 6)) + 1j * rng.standard_normal(
        (harmonics + 1, 300, 6)
    )
    s[0] = s[0].real
    sampled = np.zeros(300)
    for angle in np.linspace(0, 2 * np.pi, 5001):
        now = np.einsum("h,hnc->nc", np.exp(1j * np.arange(harmonics + 1) * angle), s).real
        sampled = np.maximum(sampled, von_mises(now))
    found = peak_von_mises(s)
    # The samples lie below by at most half the curvature (2H)² times their half distance squared.
    assert np.all(found >= sampled * (1 - 1e-13))
    assert np.max(found / sampled - 1) < (2 * harmonics) ** 2 * (np.pi / 5000) ** 2 / 2


@pytest.mark.parametrize("cell_type", CELLS)
def test_what_elements_hold_exactly_has_no_error(lattice, cell_type):
    """Constant strain in curved elements, and rigid motion."""
    model = assemble(lattice((2, 3, 2), bent, cell_type, curved=True), STEEL)
    G = np.array([[0.3, -0.2, 0.5], [0.7, -0.4, 0.1], [0.9, -0.8, 0.6]])
    p = model.part.points
    u = np.stack([p @ G.T, p @ (G - G.T), np.ones_like(p)], axis=2)
    form = excess_stiffness(model, u)
    assert form.shape == (3, 3)
    x = model.free(u[:, :, 0])
    assert np.abs(form).max() < 1e-18 * (x @ (model.K @ x)) / 2


def test_field_of_another_part_is_refused(lattice):
    model = assemble(lattice((1, 1, 1)), STEEL)
    for call, of in ((strain, model.part), (excess_stiffness, model)):
        refused(r"displacement of shape \(5, 3\): needed is", call, of, np.zeros((5, 3)))


GRADIENT = np.array([[0.3, -0.2, 0.5], [0.7, -0.4, 0.1], [0.9, -0.8, 0.6]])


def shell(p):
    """A piece of a cylinder of radius 1 to 1.2 about the axis z."""
    r, angle = 1 + 0.2 * p[:, 0], p[:, 1]
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), p[:, 2]])


@pytest.mark.parametrize(("cell_type", "length"), [
    *((cell_type, None) for cell_type in CELLS), ("tetra10", 0.05), ("hexahedron20", 0.05),
    ("hexahedron27", 0.05),
])  # fmt: skip
def test_uniform_strain_on_a_box_in_any_direction(lattice, cell_type, length):
    part = lattice((2, 2, 2), lambda p: p * [1.0, 0.8, 0.5], cell_type)
    u = part.points @ GRADIENT.T
    rng = np.random.default_rng(0)
    for axis, side in ((0, 0.0), (1, 0.8), (2, 0.5)):
        position = rng.uniform(0.1, 0.4, 3)
        position[axis] = side
        direction = rng.standard_normal(3)
        found = gauge(part, position, direction, length)
        flat = np.where(np.arange(3) == axis, 0.0, direction)
        flat /= np.linalg.norm(flat)
        assert found.direction == pytest.approx(flat, abs=1e-14)
        assert abs(found.normal[axis]) == pytest.approx(1)
        assert found.position == pytest.approx(position, abs=1e-14)
        assert found.strain(u) == pytest.approx(flat @ GRADIENT @ flat, rel=1e-12)
        both = found.strain(np.stack([u, 3j * u], axis=2))
        assert both == pytest.approx(flat @ GRADIENT @ flat * np.array([1, 3j]), rel=1e-12)


def test_it_reads_the_nodal_strain_field(lattice):
    part = lattice((3, 2, 2), shell, "tetra10", curved=True)
    u = np.random.default_rng(1).standard_normal((len(part.points), 3))
    node = part.node_sets["x1"][7]
    found = gauge(part, part.points[node], [0, 0, 1])
    assert found.strain(u) == pytest.approx(strain(part, u)[node, 2], rel=1e-11)


@pytest.mark.parametrize("length", [0.15, 0.3])
def test_mean_of_a_strain_that_curves_depends_on_the_length(lattice, length):
    """Strain 3 x² has the mean 3 (x² + L²/12) over a length L."""
    part = lattice((16, 1, 1), lambda p: p * [0.4, 0.1, 0.1], "hexahedron20")
    u = np.zeros_like(part.points)
    u[:, 0] = part.points[:, 0] ** 3
    found = gauge(part, [0.2, 0.05, 0.1], [1, 0, 0], length).strain(u)
    assert found == pytest.approx(3 * (0.2**2 + length**2 / 12), rel=5e-3)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20"])
def test_no_sample_of_a_curved_surface_is_nearer(lattice, cell_type):
    part = lattice((1, 2, 1), shell, cell_type, curved=True)
    outside = skin(part)
    t = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 21)]), axis=-1).reshape(-1, 2)
    t = t[t.sum(axis=1) < 1 + 1e-9] if cell_type == "tetra10" else t
    values, _ = surface(outside.faces.shape[1]).functions(t)
    tree = KDTree((values @ part.points[outside.faces]).reshape(-1, 3))
    rng = np.random.default_rng(2)
    for position in part.points[::9] + 0.1 * rng.standard_normal(part.points[::9].shape):
        found = outside.nearest(position).position
        assert np.linalg.norm(found - position) <= tree.query(position)[0] + 1e-12
        assert tree.query(found)[0] < 0.06  # it lies among them


def test_where_the_surface_is_off_the_position(lattice):
    part = lattice((2, 2, 2))
    found = gauge(part, [0.3, 0.4, 1.1], [1, 0, 0], tolerance=0.2)
    assert found.position == pytest.approx([0.3, 0.4, 1.0])
    assert found.distance == pytest.approx(0.1)
    assert gauge(part, [1.2, 0.4, 1.1], [0, 1, 0], tolerance=0.3).position == pytest.approx(
        [1.0, 0.4, 1.0]
    )
    inside = gauge(part, [0.3, 0.4, 0.9], [1, 0, 0], normal=[0, 0, -1], tolerance=1.0)
    assert inside.position == pytest.approx([0.3, 0.4, 0.0])


@pytest.mark.parametrize(("given", "message"), [
    ({"position": [0.3, 0.4, 2.0]}, r"gauge at \(0.3, 0.4, 2\) m: the surface is 1 m away"),
    ({"direction": [0, 0, 1]}, r"gauge direction \(0, 0, 1\) leaves the surface"),
    ({"direction": [0, 1]}, r"gauge direction = \[0, 1\]: needed are three numbers"),
    ({"length": 0.0}, "gauge length = 0 m: must be positive"),
    ({"length": 0.7}, "an end lies off the surface"),
])  # fmt: skip
def test_what_is_refused(lattice, given, message):
    gauge_at = {"position": [0.3, 0.4, 1.0], "direction": [1, 0, 0]} | given
    refused(message, gauge, lattice((2, 2, 2)), **gauge_at)


@pytest.mark.parametrize("side", ["suction", "pressure"])
def test_on_the_vane_it_sits_within_the_sagitta_of_the_elements(coarse, side):
    # Straight element sides of length s cut a camber line of curvature 8·camber/chord short by
    # s²/8 of it.
    part, sizes = coarse[0], mesh.VaneDimensions()
    corners = part.points[part.cells[:, :4]]
    side_length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    sagitta = side_length**2 * sizes.camber / sizes.chord
    u = part.points @ GRADIENT.T
    for number, span, chord in ((1, 0.1, 0.5), (2, 0.5, 0.25), (4, 0.93, 0.8)):
        place = mesh.on_aerofoil(sizes, 16, number, span, chord, side, "span")
        found = gauge(part, place.position, place.direction, normal=place.normal)
        assert found.distance < sagitta
        assert found.normal @ place.normal > 0.95
        d = found.direction
        assert d @ place.direction > 0.99
        assert found.strain(u) == pytest.approx(d @ GRADIENT @ d, rel=1e-10)
