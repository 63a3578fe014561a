"""The balance against direct time integration written here, step by step."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.nonlinear import SLIP, SLIP_OPEN, Options, System, frequency_response
from vanelock.rom.system.system import Contacts, Diameter, Force

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]


def integrate(
    M: Sequence[float],
    K: Floats,
    C: Floats,
    row: Floats,
    element: tuple[float, float, float, float],
    force: Array,
    omega: float,
    steps: int,
    periods: int,
) -> Floats:
    """Last period (steps, n) of a system with one contact, by central differences.

    `row` is (2, n): normal and tangential displacement; `element` is (kn, kt, mu, v0). The slider
    is moved no further than the bounds of the step ask for.
    """
    kn, kt, mu, v0 = element
    n = len(M)
    h = 2 * np.pi / omega / steps
    left = np.linalg.inv(np.diag(M) / h**2 + C / (2 * h))
    A, B = left @ (2 * np.diag(M) / h**2 - K), left @ (np.diag(M) / h**2 - C / (2 * h))
    push = (left @ (force * np.exp(1j * 2 * np.pi * np.arange(steps)[:, None] / steps)).real.T).T
    pull = left @ row.T
    x, before = np.zeros(n), np.zeros(n)
    w = 0.0
    last = np.empty((steps, n))
    for i in range(periods * steps):
        v = max(v0 + float(row[0] @ x), 0.0)
        u = float(row[1] @ x)
        reach = mu * kn * v / kt
        w = min(max(w, u - reach), u + reach)
        x, before = (
            A @ x - B @ before + push[i % steps] - pull @ (kn * v, kt * (u - w)),
            x,
        )
        last[(i + 1) % steps] = x
    return last


def single(mu: float, force: float, ratio: float = 0.03) -> System:
    """A mass on a spring of 1 N/m, sliding on the ground under a load of 1 N."""
    return System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                K=np.ones((1, 1), complex),
                M=np.ones((1, 1), complex),
                C=np.full((1, 1), 2 * ratio, complex),
                own=np.array([[[0], [1], [0]]], complex),
            )
        },
        contacts=Contacts(np.ones(1), np.full((1, 2), 0.8), np.array([mu]), np.ones(1)),
        force={1: Force(np.array([force], complex))},
    )


@pytest.mark.parametrize(("mu", "ratio"), [(0.3, 1.0), (0.6, 0.9), (0.3, 0.45)])
def test_oscillator_that_slides_on_the_ground(mu: float, ratio: float) -> None:
    omega, force, steps = 1.15 * ratio, 0.7, 2000
    system = single(mu, force)
    M, K, C = [1.0], np.eye(1), np.array([[0.06]])
    row = np.array([[0.0], [1.0]])
    reference = integrate(
        M, K, C, row, (1.0, 0.8, mu, 1.0), np.array([force]), omega, steps, periods=30
    )[:, 0]
    errors = []
    for harmonics in (1, 3, 7, 15):
        response = frequency_response(system, [omega / (2 * np.pi)], Options(harmonics))
        assert response.converged.all()
        assert response.state[0, 0] == SLIP
        errors.append(difference(response.x, reference[:, None]))
    # A symmetric slider has odd harmonics only, falling as the square of their number.
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.4 * errors[1]
    assert errors[3] < 1e-3
    assert errors[0] < 0.15


def difference(x: dict[int, Array], reference: Floats) -> float:
    """Largest difference over the period in harmonics h >= 1, relative to the largest value."""
    steps = len(reference)
    angle = 2 * np.pi * np.arange(steps)[:, None] / steps
    history = sum((x[h][0] * np.exp(1j * h * angle)).real for h in x if h > 0)
    moving = reference - reference.mean(axis=0)
    return float(np.abs(history - moving).max() / np.abs(moving).max())


def pair(v0: float, amplitude: float) -> System:
    """Two masses; the contact's normal follows one of them, its tangential the other."""
    K = np.array([[2.0, -0.6], [-0.6, 1.5]])
    return System(
        sectors=1,
        engine_order=0,
        diameters={
            0: Diameter(
                K=K.astype(complex),
                M=np.diag([1.0, 1.5]).astype(complex),
                C=(0.1 * K + 0.1 * np.eye(2)).astype(complex),
                own=np.array([[[1, 0.2], [0.1, 1], [0, 0]]], complex),
            )
        },
        contacts=Contacts(np.full(1, 0.9), np.full((1, 2), 0.7), np.full(1, 0.5), np.full(1, v0)),
        force={1: Force(np.array([amplitude, 0.8j * amplitude]))},
    )


@pytest.mark.parametrize(
    ("v0", "state", "omega"),
    [(3.0, SLIP, 1.0), (0.6, SLIP_OPEN, 1.0), (0.1, SLIP_OPEN, 1.5), (-0.3, SLIP_OPEN, 0.8)],
)
def test_pair_with_variable_normal_load_and_lift_off(v0: float, state: int, omega: float) -> None:
    system = pair(v0, 1.0)
    matrices, steps = system.at(0), 2000
    reference = integrate(
        [1.0, 1.5],
        matrices.K.real,
        np.asarray(matrices.C).real,
        matrices.own[0, :2].real,
        (0.9, 0.7, 0.5, v0),
        np.array([1.0, 0.8j]),
        omega,
        steps,
        periods=30,
    )
    errors = []
    for harmonics in (1, 3, 7, 15):
        response = frequency_response(system, [omega / (2 * np.pi)], Options(harmonics))
        assert response.converged.all()
        assert response.state[0, 0] == state
        errors.append(difference(response.x, reference))
        if harmonics == 15:
            mean = response.x[0][0].real - reference.mean(axis=0)
            assert np.abs(mean).max() < 1e-3 * np.abs(reference).max()
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.3 * errors[0]
    assert errors[3] < 1e-3
