"""Patch tests: what any mesh, however distorted, must reproduce to round-off.

After B. M. Irons and A. Razzaque, Experience with the patch test for convergence of finite
elements (1972), for displacements that are prescribed around a block of distorted elements.
"""

import itertools

import numpy as np
import pytest
import scipy.linalg

from vanelock.fem import Material, assemble, eigenpairs, factorise
from vanelock.mesh import Part

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SIZE = np.array([0.4, 0.3, 0.2])
CELLS = ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27"]
SHAPES = [(cell, "straight") for cell in CELLS]
SHAPES += [(cell, "curved") for cell in ("tetra10", "hexahedron20", "hexahedron27")]


@pytest.fixture
def patch(lattice):
    """Function that meshes a box whose inner nodes are scattered; curved sides inside if asked."""

    def build(cell_type, sides):
        counts = np.array([3, 3, 3])

        def scatter(p):
            inner = np.all((p > 1e-9) & (p < 1 - 1e-9), axis=1)
            corner = np.all(np.abs(p * counts - np.rint(p * counts)) < 1e-9, axis=1)
            reach = np.where(corner, 0.2, 0.04)  # of an element; sides bow where ends leave them
            shift = np.random.default_rng(7).uniform(-1, 1, p.shape) / counts
            return SIZE * (p + (inner * reach)[:, None] * shift)

        return lattice(tuple(counts), scatter, cell_type, sides == "curved")

    return build


def prescribed(part, field):
    """Largest error of the inner displacements that `field` around the patch enforces."""
    model = assemble(part, STEEL)
    exact = np.empty(model.K.shape[0])
    exact[model.dofs] = field
    around = np.unique(np.concatenate(list(part.node_sets.values())))
    outer = model.dofs[around].ravel()
    inner = np.setdiff1d(np.arange(len(exact)), outer)
    assert len(inner) >= 24
    K = model.K.tocsr()
    found = factorise(K[inner][:, inner]).solve(-K[inner][:, outer] @ exact[outer])
    return np.abs(found - exact[inner]).max() / np.abs(exact).max()


@pytest.mark.parametrize(("cell_type", "sides"), SHAPES)
def test_constant_strain(patch, below, cell_type, sides):
    part = patch(cell_type, sides)
    worst = 0.0
    for i, j in itertools.product(range(3), repeat=2):
        field = np.zeros(part.points.shape)
        field[:, i] = part.points[:, j]
        worst = max(worst, prescribed(part, field))
    below("error", worst, 1e-13)


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron27"])
def test_pure_bending(patch, below, cell_type):
    # σ_xx = E y alone: a quadratic displacement without body force (Love, art. 88). Elements with
    # straight sides hold all quadratic fields, except for the 20-node hexahedron, which loses
    # them where it is no parallelepiped.
    part = patch(cell_type, "straight")
    worst = 0.0
    for axes in itertools.permutations(range(3)):
        x, y, z = part.points[:, axes].T
        bent = [x * y, -(x**2 + STEEL.nu * (y**2 - z**2)) / 2, -STEEL.nu * y * z]
        field = np.empty(part.points.shape)
        field[:, axes] = np.array(bent).T
        worst = max(worst, prescribed(part, field))
    below("error", worst, 1e-13)


def test_bending_leaves_the_distorted_20_node_hexahedron(patch, record, below, lattice):
    def bending(part):
        x, y, z = part.points.T
        bent = [x * y, -(x**2 + STEEL.nu * (y**2 - z**2)) / 2, -STEEL.nu * y * z]
        return prescribed(part, np.array(bent).T)

    distorted = bending(patch("hexahedron20", "straight"))
    sheared = lattice(
        (3, 3, 3), lambda p: SIZE * p @ [[1, 0.3, 0], [0, 1, 0.2], [0.1, 0, 1]], "hexahedron20"
    )
    record("error, distorted", f"{distorted:.1e}")
    below("error, parallelepipeds", bending(sheared), 1e-13)
    assert 1e-6 < distorted < 1e-2


@pytest.mark.parametrize(("cell_type", "sides"), SHAPES)
def test_only_rigid_motions_carry_no_energy(patch, record, below, cell_type, sides):
    # One element alone: a seventh motion without energy would be a fault of its quadrature.
    part = patch(cell_type, sides)
    rank = []
    for nodes in part.cells:
        alone = Part(
            "element", part.points[nodes], np.arange(len(nodes))[None], cell_type, {}, {}, 1
        )
        values = scipy.linalg.eigvalsh(assemble(alone, STEEL).K.toarray())
        rank.append([np.abs(values[:6]).max() / values[-1], values[6] / values[-1]])
    zero, lowest = np.max(rank, axis=0)[0], np.min(rank, axis=0)[1]
    record("elements", len(rank))
    below("six energies below", zero, 1e-14)
    record("the seventh above", f"{lowest:.1e}")
    assert lowest > 1e-5
    model = assemble(part, STEEL)
    values, _ = eigenpairs(model.K, model.M, 8, shift=-1e8)
    record("free block: ω² of six motions / the next", f"{abs(values[5]) / values[6]:.1e}")
    assert np.abs(values[:6]).max() < 1e-9 * values[6]


@pytest.mark.parametrize(("cell_type", "sides"), SHAPES)
def test_mass_and_moments_of_a_box(patch, record, cell_type, sides):
    # Fields 1 and x are the elements' own, so that uᵀ M u is the volume's integral, exact where
    # the quadrature is: not for second moments in distorted hexahedra with 8 nodes (of degree 4
    # in each coordinate, beyond its two points), nor with curved sides.
    part = patch(cell_type, sides)
    model = assemble(part, STEEL)
    n = model.K.shape[0]
    mass = STEEL.rho * SIZE.prod()
    errors = {"mass": 0.0, "centre": 0.0, "inertia": 0.0}
    for i in range(3):
        shift, spin, about = np.zeros(n), np.empty(n), np.eye(3)[i]
        shift[model.dofs[:, i]] = 1
        spin[model.dofs] = np.cross(about, part.points - SIZE / 2)
        inertia = mass / 12 * (np.sum(SIZE**2) - SIZE[i] ** 2)
        place = np.zeros(n)
        place[model.dofs[:, i]] = part.points[:, i]
        errors["mass"] = max(errors["mass"], abs(shift @ model.M @ shift / mass - 1))
        first = abs(shift @ model.M @ place / (mass * SIZE[i] / 2) - 1)
        errors["centre"] = max(errors["centre"], first)
        errors["inertia"] = max(errors["inertia"], abs(spin @ model.M @ spin / inertia - 1))
    for name, error in errors.items():
        record(name, f"{error:.1e}")
    assert errors["mass"] < 1e-13
    if sides == "straight":
        assert errors["centre"] < 1e-13
    exact = sides == "straight" and cell_type != "hexahedron"
    assert errors["inertia"] < (1e-13 if exact else 2e-5)
