"""The structure excited by itself against its bordered matrix; derivatives by differences."""

from dataclasses import replace

import numpy as np
import pytest

from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.held_vibration import HeldVibration
from vanelock.nonlinear.fourier import to_complex

KINDS = ("stuck", "open", "coupled")
H = 3


def made(random_system, kind):
    """A random system whose damping is of one kind, and its C at a nodal diameter."""
    system = random_system(4, damping_ratio=0.02, harmonics=H)
    if kind == "open":
        system = replace(system, damping_joints="open")
    if kind == "coupled":
        rng = np.random.default_rng(0)
        diameters = {}
        for k, one in system.diameters.items():
            A = rng.normal(size=one.K.shape)
            diameters[k] = replace(one, C=0.02 * A @ A.T)
        system = replace(system, diameters=diameters)
    return replace(system, force={})


def held(system):
    prepared = structure(system, H)
    rng = np.random.default_rng(1)
    modes = prepared.at(1)
    n = len(modes.compliance)
    y = rng.normal(size=n) + 1j * rng.normal(size=n)
    y /= np.sqrt((modes.compliance * np.abs(y) ** 2).sum())
    omega = 1.02 / np.sqrt(modes.compliance[2])
    return HeldVibration(prepared, modes.compliance * y, omega, 0.07 * omega), y


def deviation(system):
    rng = np.random.default_rng(2)
    return 0.1 * rng.normal(size=(system.contacts.count, 3, 2 * H + 1))


def full(system, one, h, damping_of):
    """Dense dynamic stiffness of a harmonic in the system's coordinates, all contacts stuck."""
    k = system.nodal_diameter(h)
    matrices, modes = system.at(k), one.structure.at(h)
    B = system.contact_rows(k).reshape(-1, len(matrices.K))
    stuck = matrices.K + (B.conj().T * system.contacts.stiffness.reshape(-1)) @ B
    inverse = np.linalg.inv(modes.shapes)
    C = inverse.conj().T @ damping_of(modes) @ inverse
    s = h * one.omega
    return stuck - s**2 * matrices.M + 1j * s * (C - one.xi * matrices.M), B


def damping_of(modes):
    return np.diag(modes.damping) if modes.coupled_damping is None else modes.coupled_damping


@pytest.mark.parametrize("kind", KINDS)
def test_motion_and_force_solve_the_bordered_equations(random_system, kind):
    system = made(random_system, kind)
    (one, y), w, a = held(system), deviation(system), 0.7
    amplitudes, force = one.motion(a, w)
    pulled = to_complex(w.reshape(-1, 2 * H + 1)) * system.contacts.stiffness.reshape(-1)
    u = to_complex(one.balance(a).displacement(w).reshape(-1, 2 * H + 1))
    for h in range(1, H + 1):
        D, B = full(system, one, h, damping_of)
        modes = one.structure.at(h)
        push = B.conj().T @ pulled[h]
        if h == 1:
            border = system.at(system.nodal_diameter(1)).M @ (modes.shapes @ y)
            D = np.block([[D, -border[:, None]], [border.conj()[None], np.zeros((1, 1))]])
            moved, expected = np.split(np.linalg.solve(D, np.append(push, a)), [-1])
            assert abs(force - expected) < 1e-10 * abs(expected)
            linear = sum(np.sum(rate * x) for rate, x in zip(one.force_rates, (w, a), strict=True))
            assert abs(linear - expected) < 1e-10 * abs(expected)
        else:
            moved = np.linalg.solve(D, push)
        size = np.abs(moved).max()
        np.testing.assert_allclose(modes.shapes @ amplitudes[h], moved, atol=1e-10 * size)
        np.testing.assert_allclose(u[h], B @ np.array(moved), atol=1e-10 * np.abs(u[h]).max())


@pytest.mark.parametrize("everywhere", [True, False])
@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_differences(random_system, kind, everywhere):
    system = made(random_system, kind)
    one, w, a = replace(held(system)[0], everywhere=everywhere), deviation(system), 0.7
    rates = one.rates(one.motion(a, w)[0])
    for (moved, change), name in zip(rates, ("omega", "xi"), strict=True):
        step = 1e-6 * one.omega
        ends = [replace(one, **{name: getattr(one, name) + each}) for each in (step, -step)]
        by_u = [each.balance(a).displacement(w) for each in ends]
        by_force = [each.motion(a, w)[1] for each in ends]
        difference = (by_u[0] - by_u[1]) / (2 * step)
        np.testing.assert_allclose(moved, difference, atol=1e-7 * np.abs(difference).max())
        np.testing.assert_allclose(change, (by_force[0] - by_force[1]) / (2 * step), rtol=1e-7)
