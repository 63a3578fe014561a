"""Directions whose static friction is left open, against a march from other states of assembly."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.nonlinear.contact.test_plane_response import planar
from vanelock.nonlinear import Options, frequency_response

Floats = NDArray[np.float64]

OMEGA, STEPS, PERIODS = 1.05, 500, 40
CASES = {  # push along t2, interference, push along the normal, friction, what is left open
    "slides along t1": (0.02, 2.0, 0.0, "orthogonal", (False, True)),
    "slides along t1, held in the plane": (0.02, 2.0, 0.0, "isotropic", (False, False)),
    "slides along both": (2.0j, 2.0, 0.0, "orthogonal", (False, False)),
    "slides and opens": (0.02, 0.8, 2.0, "orthogonal", (False, False)),
    "sticks": (0.02, 40.0, 0.0, "orthogonal", (True, True)),
    "sticks in the plane": (0.02, 40.0, 0.0, "isotropic", (True, True)),
}


def marched(
    swing: complex, v0: float, shake: float, friction: str, assembled: Sequence[float]
) -> Floats:
    """Mean places of the slider along t2 in the last period, from those that assembly left."""
    system = planar(swing, 0.6, v0, shake)
    d = system.at(0)
    assert d.C is not None
    M, K, C = (np.diagonal(matrix).real for matrix in (d.M, d.K, d.C))
    h = 2 * np.pi / OMEGA / STEPS
    turn = np.exp(2j * np.pi * np.arange(STEPS) / STEPS)
    push = (system.force[1].vector * turn[:, None]).real
    x, before = np.zeros((2, len(assembled), 3))
    w = np.column_stack([np.zeros(len(assembled)), assembled])
    places = np.zeros((STEPS, len(assembled)))
    for i in range(PERIODS * STEPS):
        n = 0.9 * np.maximum(v0 + x[:, 2:], 0.0)
        reach, away = 0.6 * n / 0.8, x[:, :2] - w
        if friction == "orthogonal":
            w = x[:, :2] - away.clip(-reach, reach)
        else:
            size = np.hypot(away[:, :1], away[:, 1:])
            w = x[:, :2] - away * np.minimum(1.0, reach / np.maximum(size, 1e-300))
        places[i % STEPS] = w[:, 1]
        pull = np.hstack([0.8 * (x[:, :2] - w), n])
        rate = push[i % STEPS] - pull - K * x + 2 * M / h**2 * x
        after = (rate + (C / (2 * h) - M / h**2) * before) / (M / h**2 + C / (2 * h))
        x, before = after, x
    return np.asarray(places.mean(axis=0))


@pytest.mark.parametrize("name", CASES)
def test_what_assembly_left_is_kept_where_nothing_slides(name: str) -> None:
    swing, v0, shake, friction, expected = CASES[name]
    response = frequency_response(
        planar(swing, 0.6, v0, shake), [OMEGA / (2 * np.pi)], Options(5, friction=friction)
    )
    assert response.converged.all()
    assert tuple(response.undetermined[0, 0]) == expected
    one, other = marched(swing, v0, shake, friction, (-0.1, 0.1))
    along_t2 = abs(other - one)
    assert along_t2 == pytest.approx(0.2, rel=1e-6) if expected[1] else along_t2 < 0.02


def test_contact_without_friction_leaves_nothing_open() -> None:
    system = planar(0.02, 0.6, 2.0, 0.0)
    none = replace(system, contacts=replace(system.contacts, mu=np.zeros(1)))
    assert not frequency_response(none, [0.1], Options(1)).undetermined.any()
