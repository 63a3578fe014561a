"""What a mesh is estimated to add to the stiffness, against fields whose error is known."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.fem import (
    Material,
    assemble,
    excess_by_element,
    excess_stiffness,
    strain_energy,
    stresses,
)

CELLS = ["tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27"]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def bent(p):
    return p * [0.4, 0.3, 0.2] + 0.03 * np.sin(3 * p[:, [1, 2, 0]])


@pytest.mark.parametrize("cell_type", CELLS)
def test_what_elements_hold_exactly_has_no_error(lattice, cell_type):
    """Constant strain in curved elements, and rigid motion."""
    model = assemble(lattice((2, 3, 2), bent, cell_type, curved=True), STEEL)
    G = np.array([[0.3, -0.2, 0.5], [0.7, -0.4, 0.1], [0.9, -0.8, 0.6]])
    p = model.part.points
    u = np.stack([p @ G.T, p @ (G - G.T), np.ones_like(p)], axis=2)
    form = excess_stiffness(model, u)
    assert form.shape == (3, 3)
    assert np.abs(form).max() < 1e-18 * strain_energy(model, u)[0]


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron20", "hexahedron27"])
def test_quadratic_displacements_have_no_error(lattice, cell_type):
    """But for what few elements around a corner miss of a quadratic strain."""
    model = assemble(lattice((3, 2, 2), lambda p: p * [0.4, 0.3, 0.2], cell_type), STEEL)
    x, y, z = model.part.points.T
    u = np.column_stack([x**2 - y * z, x * y + z**2, 2 * z * x - y**2])
    few = {"tetra10": 1e-4}.get(cell_type, 1e-20)
    assert excess_stiffness(model, u) < few * strain_energy(model, u)


def test_a_form_in_the_fields(lattice):
    """Of combined fields it is what it is of their parts; complex ones and blocks included."""
    model = assemble(lattice((3, 2, 2), bent, "tetra10", curved=True), STEEL)
    random = np.random.default_rng(3)
    waves = np.sin(random.standard_normal((3, 3, 4)).T @ model.part.points.T)  # (4, 3, nodes)
    u = waves.transpose(2, 1, 0)
    form = excess_stiffness(model, u)
    assert np.array_equal(form, form.T)
    assert np.linalg.eigvalsh(form).min() > 0
    mixed = random.standard_normal((4, 2)) + 1j * random.standard_normal((4, 2))
    found = excess_stiffness(model, u @ mixed)
    np.testing.assert_allclose(
        found, mixed.conj().T @ form @ mixed, rtol=0, atol=1e-12 * form.max()
    )
    assert np.isclose(excess_stiffness(model, u[:, :, 0]), form[0, 0], rtol=1e-10)


def test_blocks_of_elements_change_nothing(lattice, monkeypatch):
    model = assemble(lattice((3, 3, 2), bent, "tetra10", curved=True), STEEL)
    u = np.sin(model.part.points[:, [1, 2, 0], None] * [[[5.0, 7.0]]])
    whole = excess_stiffness(model, u)
    monkeypatch.setattr(stresses, "_ENTRIES", 5000)
    np.testing.assert_allclose(excess_stiffness(model, u), whole, rtol=1e-12)
    each = excess_by_element(model, u[:, :, 0])
    assert (len(each), each.min() > 0) == (len(model.part.cells), True)
    assert each.sum() == pytest.approx(whole[0, 0], rel=1e-12)


def test_field_of_another_part_is_refused(lattice):
    model = assemble(lattice((1, 1, 1)), STEEL)
    with pytest.raises(InputError, match=r"displacement of shape \(5, 3\)"):
        excess_stiffness(model, np.zeros((5, 3)))
