"""Damped modes and limit cycles: closed forms, amplitudes that are asked for, what is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import with_contacts
from tests.refusals import refused
from tests.verification.nonlinear.peaks.test_limit_cycles import found as cycles_of
from tests.verification.nonlinear.peaks.test_limit_cycles import one_mass
from tests.verification.nonlinear.spring_rings import MASSES, spring_ring
from vanelock import rom
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    OPEN,
    SLIP_OPEN,
    Contacts,
    DampedMode,
    Diameter,
    Element,
    Force,
    Options,
    System,
    aerodynamic_damping,
    damped_mode,
    limit_cycles,
)
from vanelock.nonlinear.modes.limit_cycles import _coefficients

RING = spring_ring(0)


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled", "constant-load"])
def test_amplitudes_of_a_list_lie_on_the_curve_of_a_range(coupling):
    options = Options(2, coupling=coupling)
    curve = damped_mode(RING, 1, (0.05, 5.0), options)
    assert curve.amplitude[[0, -1]] == pytest.approx([0.05, 5.0], rel=1e-10)
    chosen = curve.amplitude[[3, 20, -5]]
    listed = damped_mode(RING, 1, chosen[::-1], options)
    np.testing.assert_allclose(listed.amplitude, chosen, rtol=1e-10)
    np.testing.assert_allclose(listed.frequency, curve.frequency[[3, 20, -5]], rtol=1e-9)
    np.testing.assert_allclose(listed.damping_ratio, curve.damping_ratio[[3, 20, -5]], rtol=1e-8)


def test_every_mode_of_every_wave_begins_with_its_linear_one():
    for k in range(RING.sectors):
        hertz, _ = rom.linear_modes(RING, k, MASSES)
        for mode in range(1, MASSES + 1):
            found = damped_mode(RING, mode, [1e-4], Options(1), k)
            assert found.nodal_diameter == k
            np.testing.assert_allclose(found.frequency, hertz[mode - 1], rtol=1e-12)
            np.testing.assert_allclose(found.damping_ratio, RING.damping_ratio, rtol=1e-10)


def test_contacts_open_at_rest_leave_the_linear_mode_when_they_close():
    apart = with_contacts(RING, v0=np.array([3.0, -30.0]))
    hertz, _ = rom.linear_modes(apart, 1, MASSES, np.array([True, False]))
    found = damped_mode(apart, 1, (1e-4, 1e3), Options(1))
    np.testing.assert_allclose(found.frequency[0], hertz[0], rtol=1e-4)  # C couples its modes
    assert not found.ended
    assert found.response.state[0, 1] == OPEN
    assert found.response.state[-1, 1] == SLIP_OPEN


@pytest.mark.parametrize("amplitudes", [None, [1.2, 2.0, 30.0]])
def test_a_contact_on_a_circle_slips_all_the_way_round_at_once(amplitudes):
    # The slider is on a circle, too, its disc's edge tangent to it (test_isotropic_law):
    # k = kt r (r + i √(U² - r²))/U² from U = r on, where the damping begins as a root.
    g, kt, r, c = 0.1, 0.25, 0.5 * 0.4 / 0.25, 0.01
    own = np.zeros((1, 3, 3))
    own[0, [0, 1, 2], [2, 0, 1]] = 1.0
    K = np.eye(3, dtype=complex)
    K[0, 1], K[1, 0] = 1j * g, -1j * g
    blocks = {k: Diameter(K=K if k == 1 else K.real, M=np.eye(3), own=own) for k in (0, 1, 2)}
    contacts = Contacts(np.ones(1), np.full((1, 2), kt), np.array([0.5]), np.array([0.8]))
    system = System(4, 1, blocks, contacts, {}, damping_ratio=c)
    found = damped_mode(system, 1, amplitudes, Options(1, friction="isotropic"))
    U = found.amplitude / np.sqrt(2)
    slid = np.maximum(U, r)
    omega = np.sqrt(1 - g + kt * (r / slid) ** 2)
    loss = 2 * c * np.sqrt(1 - g + kt) * omega + kt * r * np.sqrt(slid**2 - r**2) / slid**2
    assert not found.ended
    assert U[-1] > 20 * r
    np.testing.assert_allclose(2 * np.pi * found.frequency, omega, rtol=1e-9)
    np.testing.assert_allclose(found.damping_ratio, loss / (2 * omega**2), rtol=1e-8)


def test_it_is_saved_and_loaded(tmp_path):
    found = damped_mode(RING, 1, [0.5, 2.0], Options(1))
    found.save(tmp_path / "mode.h5")
    again = DampedMode.load(tmp_path / "mode.h5")
    np.testing.assert_array_equal(again.damping_ratio, found.damping_ratio)
    assert again.at([1]).frequency == found.frequency[1]


SPRING = Element(force="cubic_spring", places=[0], parameters=[0.5])
SPRUNG = System.from_matrices(np.eye(1), np.eye(1), elements=[SPRING])
FEW = replace(RING, diameters={k: RING.diameters[k] for k in (0, 1)})


@pytest.mark.parametrize(("arguments", "words"), [
    ({"mode": 0}, "mode: given 0: allowed: 1 to 3"),
    ({"mode": 4}, "mode: given 4: allowed: 1 to 3"),
    ({"mode": 1.5}, "mode"),
    ({"nodal_diameter": 5}, "nodal_diameter: given 5: allowed: 0 to 4"),
    ({"amplitudes": (2.0, 1.0)}, r"amplitudes: given \(2.0, 1.0\): a range is \(low, high\)"),
    ({"amplitudes": [1.0, -1.0]}, r"amplitudes: given \[1.0, -1.0\]: must be > 0"),
    ({"options": Options(0)}, "harmonics: given 0: a mode needs at least 1"),
    ({"options": Options(1, direction="up")}, "direction: given 'up'"),
    ({"options": Options(1, static_beyond=3.0)}, "static_beyond: given 3.0"),
    ({"self_excitation": "some"}, "self_excitation: given 'some': allowed: fundamental, all"),
    ({"system": FEW, "options": Options(2)},
     "nodal_diameter: given 1: harmonic 2 has nodal diameter 2, but the system holds 0, 1$"),
    ({"system": replace(RING, band=0.1), "mode": 3}, "mode: given 3: its .* beyond the 0.1 Hz"),
    ({"system": SPRUNG}, "elements: .* a damped mode is of contacts alone"),
])  # fmt: skip
def test_what_is_not_possible_is_said_in_a_line(arguments, words):
    with pytest.raises(InputError) as caught:
        damped_mode(**{"system": RING, "mode": 1, **arguments})
    assert re.match(words, str(caught.value))
    assert "\n" not in str(caught.value)


def test_a_frictionless_system_needs_a_range():
    smooth = with_contacts(RING, mu=np.zeros(2))
    smooth = replace(smooth, force={0: Force(np.zeros(MASSES))})
    found = damped_mode(smooth, 1, (1e-4, 1e-2), Options(1))
    np.testing.assert_allclose(found.frequency, found.frequency[0], rtol=1e-12)


def test_air_that_damps_leaves_no_cycle():
    quiet = cycles_of(-0.1, 1)
    assert len(quiet.amplitude) == 0
    assert quiet.critical_kick == np.inf
    assert quiet.linear_damping == pytest.approx(quiet.aerodynamic_damping)
    assert quiet.linear_damping > 0


def test_real_coefficients_move_the_frequency_alone():
    plain, size = cycles_of(0.36, 1), 0.2 / 0.25
    influence = {0: -0.1 + 1j * 0.36 * 0.25 / np.pi}
    stiff = limit_cycles(one_mass(), 1, influence, (0.3 * size, 12 * size), Options(1))
    np.testing.assert_allclose(stiff.amplitude, plain.amplitude, rtol=1e-9)
    squares = (2 * np.pi * stiff.frequency) ** 2 - (2 * np.pi * plain.frequency) ** 2
    np.testing.assert_allclose(squares, 0.1, rtol=1e-9)


def test_coefficients_are_checked():
    with pytest.raises(InputError, match=r"^influence: given sectors \[-1, 4\]: two are the same"):
        _coefficients({-1: 1j, 4: 2j}, 5)
    refused(r"needs \(5,\), one a sector", _coefficients, np.ones(4), 5)
    refused("not finite", _coefficients, {0: np.nan}, 5)
    refused("^frequency: given 0", aerodynamic_damping, {0: 1j}, 5, 0.0)
