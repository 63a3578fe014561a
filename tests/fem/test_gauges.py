"""Strain gauges: uniform strain, bending, the surface they sit on, and refusals."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.fem.conftest import CELLS
from vanelock import mesh
from vanelock.common.errors import InputError
from vanelock.fem import gauge, strain
from vanelock.fem.gauges import skin
from vanelock.mesh.cells import surface

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


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
def test_uniform_strain_on_a_curved_surface(lattice, cell_type):
    part = lattice((1, 4, 2), shell, cell_type, curved=True)
    u = part.points @ GRADIENT.T
    for angle in (0.1, 0.77):
        out = np.array([np.cos(angle), np.sin(angle), 0])
        found = gauge(part, 1.201 * out + [0, 0, 0.6], [0, 0, 1] + 0.5 * out)
        assert found.normal == pytest.approx(out, abs=5e-3)  # the face is a parabola
        assert found.distance == pytest.approx(1e-3, abs=1e-4)
        d = found.direction
        assert d @ found.normal == pytest.approx(0, abs=1e-14)
        assert found.strain(u) == pytest.approx(d @ GRADIENT @ d, rel=1e-11)


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
    with pytest.raises(InputError, match=message):
        gauge(lattice((2, 2, 2)), **gauge_at)


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
