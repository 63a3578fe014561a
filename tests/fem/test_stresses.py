"""Strains, stresses and what a mesh adds to the stiffness, against fields that are known."""

import numpy as np
import pytest

from tests.fem.conftest import CELLS, STEEL, bent
from vanelock.common.errors import InputError
from vanelock.fem import (
    assemble,
    excess_by_element,
    excess_stiffness,
    peak_von_mises,
    strain,
    stresses,
    von_mises,
)
from vanelock.fem.stresses import turned


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


def test_field_of_another_part_is_refused(lattice):
    model = assemble(lattice((1, 1, 1)), STEEL)
    for call, of in ((strain, model.part), (excess_stiffness, model)):
        with pytest.raises(InputError, match=r"displacement of shape \(5, 3\): needed is"):
            call(of, np.zeros((5, 3)))
