"""Resonances of undamped systems that friction does not bound, against modes and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contact,
    Options,
    Shares,
    System,
    adaptive_response,
    peak_bounds,
    peak_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.arc_length import follow
from vanelock.nonlinear.continuation.families import Loads
from vanelock.nonlinear.forced_response.linear_response import check_bound
from vanelock.nonlinear.fourier import TURN
from vanelock.nonlinear.newton.newton import solve

K = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 4.0]])
M = np.diag([1.0, 1.5, 2.0])
SHARES = Shares(3e-2, 3e-2)


def slipping(load):
    """Three masses without damping that slip on the ground and on each other."""
    contacts = [
        Contact(tangential=0, second=1, kt=1.0, mu=0.3, preload=0.5),
        Contact(tangential=(1, 2), kt=2.0, mu=0.2, preload=1.5),
        Contact(tangential=2, kt=1.0, mu=0.0, preload=1.0),
    ]
    force = {0: 0.3 * load, 2: 0.7j * load}
    return System.from_matrices(M, K, contacts, force=force)


def limit(mode):
    """A mode's frequency, rad/s, and the load whose work is that of friction in large motion."""
    squares, shapes = la.eigh(K, M)
    a, b, c = shapes[:, mode]
    friction = 4 / np.pi * (0.15 * (abs(a) + abs(b)) + 0.3 * abs(b - c))
    return float(np.sqrt(squares[mode])), float(friction / abs(0.3 * a + 0.7j * c))


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_what_friction_holds_of_a_load_is_known_from_the_modes_that_slide(mode):
    omega, most = limit(mode)
    near = 0.97 * omega, 1.03 * omega
    check_bound(structure(slipping(0.999 * most), 1), near, None, "range")
    with pytest.raises(InputError, match=r"range: near \S+ Hz .* holds 0.999 of its load at most"):
        check_bound(structure(slipping(1.001 * most), 1), near, None, "range")
    damped = replace(slipping(2 * most), damping_ratio=1e-6)
    check_bound(structure(damped, 1), near, None, "range", omega)
    system, hertz = slipping(2 * most), (near[0] / TURN, near[1] / TURN)
    said = f"near {omega / TURN:.6g} Hz it grows without damping, and friction holds 0.5 of"
    with pytest.raises(InputError, match=f"frequencies: no largest amplitude .*: {said}"):
        adaptive_response(lambda _: system, hertz, SHARES)
    with pytest.raises(InputError, match="near: no largest amplitude .* at mu = 0.01: near"):
        peak_response(system, "mu", [0.01], hertz)
    with pytest.raises(InputError, match=f"near: no largest amplitude .* at zero: {said}"):
        peak_bounds(system, hertz, Options(1))


def test_peaks_by_force_end_where_friction_holds_no_more():
    omega, most = limit(0)
    hertz = 0.8 * omega / TURN, 1.2 * omega / TURN
    found = peak_response(slipping(most), "force", (0.5, 2.0), hertz, Options(1))
    assert found.parameter[-1] == 2.0
    np.testing.assert_array_equal(found.converged, found.parameter < 1)
    assert found.parameter[-2] > 0.99
    assert found.converged.sum() == len(found.converged) - 1  # no more is looked for beyond


def test_a_resonance_that_no_known_friction_holds_is_said_where_it_is_not_found():
    pad = Contact(tangential=0, normal=1, kn=1.0, kt=1.0, mu=0.3, gap=1e3)  # open for good
    system = System.from_matrices(np.eye(2), np.diag([1.0, 3.0]), [pad], force={0: 0.1})
    said = "frequencies: .*: near 0.159155 Hz it grows without damping, and friction alone may not"
    with pytest.raises(InputError, match=said):
        adaptive_response(lambda _: system, (0.9 / TURN, 1.15 / TURN), SHARES, Options(1))


def test_a_stop_that_nothing_damps_is_refused_where_it_grows():
    # Far beyond the gap, half a period belongs to each stiffness: 2 ω_1 ω_2 / (ω_1 + ω_2).
    stop = Contact(normal=0, kn=1.0, gap=0.1)
    system = System.from_matrices([[1.0]], [[1.0]], [stop], force={0: 0.1})
    near = 2 * 2**0.5 / (1 + 2**0.5) / TURN
    with pytest.raises(InputError, match=f"near {near:.3f}"):
        adaptive_response(lambda _: system, (0.95 * near, 1.05 * near), SHARES, Options(3))
    below = adaptive_response(lambda _: system, (0.90 * near, 0.94 * near), SHARES, Options(3))
    assert below.amplitude.max() < 1.0


def test_a_path_ends_where_nothing_holds_it():
    # Raised at the resonance of the mass that slides, the force is 4/π μ n at infinity.
    pad = Contact(tangential=0, kt=0.1, mu=0.3, preload=1.0)
    system = System.from_matrices([[1.0]], [[1.0]], [pad], force={0: 1.0})
    balance, law = structure(system, 1).balance(1.0), contact_law(system.contacts, 1)
    moving = balance.linear.copy()
    moving[:, :, 0] = 0.0
    family = Loads(replace(balance, linear=balance.linear - moving), moving, law)
    begun = solve(family, np.zeros_like(moving), 0.0)
    arc = follow(family, begun, 1.0, limit=600, effort=3000, shortest=1e-6)
    assert arc.solution is None
    assert arc.iterations < 300
