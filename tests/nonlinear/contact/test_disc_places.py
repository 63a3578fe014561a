"""Places of sliders that follow a disc: theory, and radial return in small steps."""

import numpy as np
import pytest

from tests.nonlinear.contact.test_isotropic_law import draw, radial_return
from vanelock.nonlinear.contact.isotropic_law import slider_places
from vanelock.nonlinear.contact.law import SLIP, SLIP_OPEN, contact_law
from vanelock.nonlinear.fourier import TURN
from vanelock.rom.system.system import Contacts


@pytest.mark.parametrize("radius", [0.3, 0.7, 0.95])
def test_a_circle_is_followed_on_a_smaller_one(radius: float) -> None:
    # The slider moves towards the disc's centre, so that u - w is tangent to its own circle.
    u = np.zeros((3, 3))
    u[0, 0], u[1, 1], u[2, 2] = 1.0, 1.0, -1.0
    angles = np.linspace(-3.0, 9.0, 101)
    w = slider_places(u, radius, angles)
    p = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # Between the nodes of a step the direction is less accurate than at its end, the distance not.
    np.testing.assert_allclose(np.hypot(*w.T), np.sqrt(1 - radius**2), rtol=5e-8)
    np.testing.assert_allclose(np.hypot(*(p - w).T), radius, rtol=1e-9)
    np.testing.assert_allclose(((p - w) * w).sum(axis=1), 0, atol=5e-8)


@pytest.mark.parametrize("harmonics", [3])
def test_places_are_those_of_radial_return_in_small_steps(harmonics: int) -> None:
    made, u = draw(harmonics, 30, 8)
    state = contact_law(made, harmonics, friction="isotropic")(u).state
    moves = np.isin(state, (SLIP, SLIP_OPEN))
    assert {SLIP, SLIP_OPEN} <= set(state)
    made = Contacts(made.kn[moves], made.kt[moves], made.mu[moves], made.v0[moves])
    u, angles = u[moves], TURN * np.arange(1000) / 1000
    each = zip(u, made.mu * made.kn / made.kt[:, 0], strict=True)
    places = np.array([slider_places(a, float(alpha), angles) for a, alpha in each])
    off = []
    for count in (3000, 12000):  # of first order
        path = radial_return(made, u, count, 6)[0]
        apart = np.abs(path[:: count // 1000].swapaxes(0, 1) - places).max(axis=(1, 2))
        off.append(apart / np.abs(u).max(axis=(1, 2)))
    assert off[1].max() < 2e-3
    assert np.median(off[1]) < 0.3 * np.median(off[0])
