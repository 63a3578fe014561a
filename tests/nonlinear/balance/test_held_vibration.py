"""The structure excited by itself against its bordered matrix; derivatives by differences."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import random_system, rows, stuck_stiffness
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.fourier import to_complex

H, AMPLITUDE = 3, 0.7


def made(kind):
    """A system whose damping is of one kind, its held vibration, y, and contacts' deviations."""
    system = random_system(4, damping_ratio=0.02, harmonics=H)
    if kind == "open":
        system = replace(system, damping_joints="open")
    if kind == "coupled":
        rng, diameters = np.random.default_rng(0), {}
        for k, one in system.diameters.items():
            A = rng.normal(size=one.K.shape)
            diameters[k] = replace(one, C=0.02 * A @ A.T)
        system = replace(system, diameters=diameters)
    system = replace(system, force={})
    prepared, rng = structure(system, H), np.random.default_rng(1)
    modes = prepared.at(1)
    y = rng.normal(size=len(modes.compliance)) + 1j * rng.normal(size=len(modes.compliance))
    y /= np.sqrt((modes.compliance * np.abs(y) ** 2).sum())
    omega = 1.02 / np.sqrt(modes.compliance[2])
    w = 0.1 * np.random.default_rng(2).normal(size=(system.contacts.count, 3, 2 * H + 1))
    return system, HeldVibration(prepared, modes.compliance * y, omega, 0.07 * omega), y, w


def full(system, one, h):
    """Dense dynamic stiffness of a harmonic in the system's coordinates, all contacts stuck."""
    k, modes = system.nodal_diameter(h), one.structure.at(h)
    M, inverse, s = system.at(k).M, np.linalg.inv(modes.shapes), h * one.omega
    C = np.diag(modes.damping) if modes.coupled_damping is None else modes.coupled_damping
    C = inverse.conj().T @ C @ inverse
    return stuck_stiffness(system, k) - s**2 * M + 1j * s * (C - one.xi * M)


@pytest.mark.parametrize("kind", ["stuck", "open", "coupled"])
def test_motion_and_force_solve_the_bordered_equations(kind):
    system, one, y, w = made(kind)
    amplitudes, force = one.motion(AMPLITUDE, w)
    pulled = to_complex(w.reshape(-1, 2 * H + 1)) * system.contacts.stiffness.reshape(-1)
    u = to_complex(one.balance(AMPLITUDE).displacement(w).reshape(-1, 2 * H + 1))
    amplitudes[0] = amplitudes[0] - one.motion(AMPLITUDE, 0 * w)[0][0]  # at rest
    u[0] -= to_complex(one.balance(AMPLITUDE).displacement(0 * w).reshape(-1, 2 * H + 1))[0]
    for h in range(H + 1):
        D, B = full(system, one, h), rows(system, system.nodal_diameter(h))
        modes = one.structure.at(h)
        push = B.conj().T @ pulled[h] if h else (B.conj().T @ pulled[0]).real
        if h == 1:
            border = system.at(system.nodal_diameter(1)).M @ (modes.shapes @ y)
            D = np.block([[D, -border[:, None]], [border.conj()[None], np.zeros((1, 1))]])
            moved, expected = np.split(np.linalg.solve(D, np.append(push, AMPLITUDE)), [-1])
            assert abs(force - expected) < 1e-10 * abs(expected)
            linear = sum(
                np.sum(rate * x) for rate, x in zip(one.force_rates, (w, AMPLITUDE), strict=True)
            )
            assert abs(linear - expected) < 1e-10 * abs(expected)
        else:
            moved = np.linalg.solve(D, push)
        size = np.abs(moved).max()
        np.testing.assert_allclose(modes.shapes @ amplitudes[h], moved, atol=1e-10 * size)
        np.testing.assert_allclose(u[h], B @ np.array(moved), atol=1e-10 * np.abs(u[h]).max())


@pytest.mark.parametrize("everywhere", [True, False])
@pytest.mark.parametrize("kind", ["stuck", "open", "coupled"])
def test_rates_are_differences(kind, everywhere):
    _, one, _, w = made(kind)
    one = replace(one, everywhere=everywhere)
    rates = one.rates(one.motion(AMPLITUDE, w)[0])
    for (moved, change), name in zip(rates, ("omega", "xi"), strict=True):
        step = 1e-6 * one.omega
        ends = [replace(one, **{name: getattr(one, name) + each}) for each in (step, -step)]
        by_u = [each.balance(AMPLITUDE).displacement(w) for each in ends]
        by_force = [each.motion(AMPLITUDE, w)[1] for each in ends]
        difference = (by_u[0] - by_u[1]) / (2 * step)
        np.testing.assert_allclose(moved, difference, atol=1e-7 * np.abs(difference).max())
        np.testing.assert_allclose(change, (by_force[0] - by_force[1]) / (2 * step), rtol=1e-7)
