"""Tractions by their resultants on curved faces, in whatever place; what is refused."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble, pressure, traction
from vanelock.fem.loads import centroid, faces_of

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
FORCE, MOMENT = np.array([3.0, -20.0, 7.0]), np.array([0.1, 0.4, -0.2])


def bent(p):
    return p * [0.4, 0.3, 0.2] + 0.03 * np.sin(3 * p[:, [1, 2, 0]])


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
