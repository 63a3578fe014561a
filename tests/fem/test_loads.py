"""Loads at rest: resultants against integrals over volumes and faces, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.fem.conftest import CELLS, STEEL, bent
from vanelock.common.errors import InputError
from vanelock.fem import assemble, centrifugal, pressure, stress, thermal, traction
from vanelock.fem.loads import centroid, faces_of


def block(lattice, cell_type, counts=(2, 3, 2)):
    part = lattice(counts, bent, cell_type, curved=True)
    return replace(part, node_sets={**part.node_sets, "all": np.arange(len(part.points))})


@pytest.mark.parametrize("cell_type", CELLS)
def test_pressure_all_round_squeezes_evenly_and_a_gradient_lifts(lattice, cell_type):
    # u = -p/(3λ + 2μ) x is the exact answer, which every element holds; the stiffness of elements
    # with curved sides is not integrated exactly.
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    (lame, shear), x = STEEL.lame, model.part.points
    f = pressure(model, "all", 1e6)
    bound = {"tetra10": 1e-4, "hexahedron20": 1e-6, "hexahedron27": 1e-6}.get(cell_type, 1e-12)
    squeezed = model.K @ (-1e6 / (3 * lame + 2 * shear) * x).ravel()
    np.testing.assert_allclose(squeezed, f, atol=bound * np.abs(f).max())
    moment = np.cross(x, f.reshape(-1, 3))
    assert np.linalg.norm(moment.sum(axis=0)) < 1e-13 * np.abs(moment).sum()
    lift = pressure(model, "all", 1e6 + 5e4 * x[:, 2]).reshape(-1, 3).sum(axis=0)
    volume = model.M.sum() / 3 / STEEL.rho  # Gauss: -∮ p n dA = -∫ ∇p dV
    accuracy = 1e-12 if cell_type in ("tetra", "tetra10") else 1e-3  # of the mass's own rule
    np.testing.assert_allclose(lift, [0, 0, -5e4 * volume], atol=accuracy * 5e4 * volume)


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_free_body_grows_without_stress(lattice, cell_type):
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    grown = 2e-3 * model.part.points
    f = thermal(model, 2e-3)
    np.testing.assert_allclose(model.K @ grown.ravel(), f, atol=1e-13 * np.abs(f).max())
    free = stress(model, grown, 2e-3)
    assert np.abs(free).max() < 1e-12 * STEEL.E * 2e-3
    held = stress(model, 0 * grown, np.full(len(grown), 2e-3))
    lame, shear = STEEL.lame
    np.testing.assert_allclose(held[:, :3], -(3 * lame + 2 * shear) * 2e-3, rtol=1e-12)


def test_what_acts_on_clamped_nodes_is_left_out(lattice):
    part = block(lattice, "tetra10")
    free = assemble(part, STEEL, fixed=None)
    held = assemble(part, STEEL, fixed="x0")
    rows = held.dofs >= 0
    for load in (
        lambda model: pressure(model, "all", 1e6),
        lambda model: thermal(model, 1e-3),
        lambda model: centrifugal(model, 100.0),
    ):
        assert np.array_equal(load(free).reshape(-1, 3)[rows], load(held)[held.dofs[rows]])


def test_what_does_not_belong_to_a_part_is_refused(lattice):
    model = assemble(block(lattice, "tetra10"), STEEL, fixed=None)
    n = len(model.part.points)
    for call, words in (
        (lambda: pressure(model, "back", 1.0), "no node set 'back'; it has all, x0, x1"),
        (lambda: pressure(model, "x0", np.ones(3)), f"pressure of shape .3,.: needed is .* .{n},."),
        (lambda: pressure(model, "x0", np.nan), "pressure must be finite"),
        (lambda: thermal(model, np.ones((n, 3))), "thermal strain of shape"),
        (lambda: thermal(model, np.inf), "thermal strain must be finite"),
        (lambda: centrifugal(model, np.nan), "speed = nan rad/s: must be finite"),
    ):
        with pytest.raises(InputError, match=words):
            call()
    edge = replace(model.part, node_sets={"edge": np.arange(2)})
    with pytest.raises(InputError, match="no face of the surface has all its nodes in 'edge'"):
        pressure(replace(model, part=edge), "edge", 1.0)


FORCE, MOMENT = np.array([3.0, -20.0, 7.0]), np.array([0.1, 0.4, -0.2])


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron27"])
def test_force_and_moment_are_those_given(lattice, cell_type):
    model = assemble(lattice((2, 3, 2), bent, cell_type, curved=True), STEEL, fixed=None)
    faces = faces_of(model.part, "x1")
    middle = centroid(model, faces)
    f = traction(model, faces, FORCE, MOMENT).reshape(-1, 3)
    arm = model.part.points - middle
    np.testing.assert_allclose(f.sum(axis=0), FORCE, rtol=1e-12)
    np.testing.assert_allclose(np.cross(arm, f).sum(axis=0), MOMENT, rtol=1e-11)
    away = np.setdiff1d(np.arange(len(f)), faces)
    assert not f[away].any()


def test_across_a_flat_face_a_force_is_an_even_pressure_and_a_moment_a_linear_one(lattice):
    part = lattice((2, 3, 2), lambda p: p * [0.4, 0.3, 0.2], "tetra10")
    model = assemble(part, STEEL, fixed=None)
    faces, x = faces_of(model.part, "x1"), model.part.points
    area, inertia = 0.3 * 0.2, 0.2 * 0.3**3 / 12
    even = traction(model, faces, [-5.0, 0.0, 0.0])
    np.testing.assert_allclose(even, pressure(model, "x1", 5.0 / area), atol=1e-13)
    bending = traction(model, faces, [0.0, 0.0, 0.0], [0.0, 0.0, 2.0])
    linear = pressure(model, "x1", 2.0 / inertia * (x[:, 1] - 0.15))
    np.testing.assert_allclose(bending, linear, atol=1e-12)


def test_wrong_resultants_and_no_faces_are_refused(lattice):
    model = assemble(lattice((1, 1, 1), bent, "tetra"), STEEL, fixed=None)
    side, none = faces_of(model.part, "x1"), np.empty((0, 3), int)
    for faces, force, message in (
        (side, [np.inf, 0, 0], "three finite numbers each"),
        (side, [1.0, 0.0], "three finite numbers each"),
        (none, FORCE, "traction: no faces are given"),
    ):
        with pytest.raises(InputError, match=message):
            traction(model, faces, force, [0, 0, 0])
