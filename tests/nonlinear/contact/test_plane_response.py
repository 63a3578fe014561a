"""Responses with isotropic friction against time integration, and directions left open."""

import numpy as np
import pytest

from tests.nonlinear.systems import (
    in_time,
    planar,
    with_contacts,
)
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Contact,
    Options,
    System,
    frequency_response,
)

HERTZ = 1.05 / (2 * np.pi)
PLANE = Options(3, friction="isotropic")


@pytest.mark.parametrize(
    ("swing", "v0", "shake", "state"),
    [
        (0.7j, 2.0, 0.0, SLIP),  # nearly a circle under constant load
        (0.5 + 0.2j, 2.0, 1.2, SLIP),  # an ellipse, the normal load varies
        (0.5j, 0.8, 2.0, SLIP_OPEN),
    ],
)
def test_mass_that_slides_in_a_plane(swing, v0, shake, state):
    system, steps = planar(swing, 0.6, v0, shake), 2000
    path, _ = in_time(system, HERTZ, 30, steps, "isotropic")
    moving, errors = path - path.mean(axis=0), []
    turn = np.exp(2j * np.pi * np.arange(steps) / steps)[:, None]
    for harmonics in (1, 3, 7, 15):
        response = frequency_response(system, [HERTZ], Options(harmonics, friction="isotropic"))
        assert response.converged.all()
        assert response.state[0, 0] == state
        history = sum((response.x[k][0] * turn**k).real for k in range(1, harmonics + 1))
        errors.append(float(np.abs(history - moving).max() / np.abs(moving).max()))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.3 * errors[0]
    assert errors[3] < 1e-3


CASES = {  # push along t2, interference, push along the normal, friction, what is left open
    "slides along t1": (0.02, 2.0, 0.0, "orthogonal", (False, True)),
    "slides along t1, held in the plane": (0.02, 2.0, 0.0, "isotropic", (False, False)),
    "slides along both": (2.0j, 2.0, 0.0, "orthogonal", (False, False)),
    "slides and opens": (0.02, 0.8, 2.0, "orthogonal", (False, False)),
    "sticks": (0.02, 40.0, 0.0, "orthogonal", (True, True)),
    "sticks in the plane": (0.02, 40.0, 0.0, "isotropic", (True, True)),
}


@pytest.mark.parametrize("name", CASES)
def test_what_assembly_left_is_kept_where_nothing_slides(name):
    swing, v0, shake, friction, expected = CASES[name]
    system = planar(swing, 0.6, v0, shake)
    response = frequency_response(system, [HERTZ], Options(5, friction=friction))
    assert response.converged.all()
    assert tuple(response.undetermined[0, 0]) == expected
    one, other = (
        in_time(system, HERTZ, 40, 500, friction, (0.0, left))[1][:, 1].mean()
        for left in (-0.1, 0.1)
    )
    assert other - one == pytest.approx(0.2, rel=1e-6) if expected[1] else abs(other - one) < 0.02


def test_contact_without_friction_leaves_nothing_open():
    none = with_contacts(planar(0.02, 0.6, 2.0, 0.0), mu=np.zeros(1))
    assert not frequency_response(none, [0.1], Options(1)).undetermined.any()


@pytest.mark.parametrize("kt", [1e10, 1e13])
def test_friction_that_vanishes_beside_the_motion_is_none(kt):
    K = 1e7 * np.array([[2.0, -1.0], [-1.0, 2.0]])
    contact = Contact(tangential=1, normal=(None, 0), mu=1e-9, kt=kt, kn=1e7, preload=0.1)
    system = System.from_matrices(np.eye(2), K, [contact], force={1: 0.1}, static_force={0: -3.0})
    found = frequency_response(system, [430.0, 500.0, 600.0], Options(1, friction="isotropic"))
    square = (2 * np.pi * found.frequency[:, None, None]) ** 2 * np.eye(2)
    alone = np.linalg.solve(K + np.diag([1e7, 0.0]) - square, [0.0, 0.1])
    assert found.converged.all()
    np.testing.assert_allclose(found.x[1], alone, rtol=1e-7)  # μ n is 1e-9 of the force
