"""A sector of masses and springs with hook and interlock contacts, small enough for planes."""

import numpy as np
import pytest

from vanelock.published.maps.plane import Method, Plane
from vanelock.rom import Contacts, Diameter, Force, System


@pytest.fixture
def sector():
    """Seven sectors of four coordinates: a hook pair to the ground, an interlock pair to the next.

    The interlock presses the first coordinate on the next sector's third, which moves with the
    fourth, along which it slides: normal load and sliding vibrate together, and the mean load can
    change.
    """
    K = np.diag([3.0, 2.0, 1.0, 1.2]) * 1e6
    K[1, 3] = K[3, 1] = -0.02e6
    K[2, 3] = K[3, 2] = -0.5e6
    M = np.eye(4)
    own, following = np.zeros((2, 3, 4)), np.zeros((2, 3, 4))
    own[0, [0, 1, 2], [1, 0, 0]] = 1
    own[1, [0, 1, 2], [0, 3, 1]] = 1
    following[1, [0, 1, 2], [2, 3, 1]] = -1
    output = np.zeros((1, 3, 4))
    output[0, [0, 1, 2], [1, 2, 3]] = 1
    one = Diameter(K, M, own, following, output)
    return System(
        sectors=7,
        engine_order=1,
        diameters=dict.fromkeys(range(4), one),
        contacts=Contacts(
            kn=np.array([2e6, 5e5]),
            kt=np.array([[2e6, 2e6], [4e5, 4e5]]),
            mu=np.array([0.3, 0.3]),
            v0=np.array([4e-4, 2e-6]),
            joint=("hook", "interlock"),
            always_closed=("hook",),
        ),
        force={1: Force(np.array([0, 0.2 + 0j, 1.0, 3.0]))},
        output_names=("vane output 1",),
        damping_ratio=0.01,
    )


METHODS = (Method(1), Method(1, "uncoupled"), Method(1, "constant-load"), Method(3), Method(5))
MU, V0 = np.array([0.1, 0.3, 1.0]), np.array([1e-6, 2e-6])


@pytest.fixture
def plane():
    """A peak that falls to mu = 0.3 and rises again, and with interference throughout."""
    a = np.array([[60, 50], [20, 15], [40, 30]]) * 1e-6
    f = np.array([[250, 251], [255, 256], [270, 272.0]])
    factors = np.array([1.0, 0.8, 1.2, 1.05, 1.052])
    shifts = np.array([0.0, 0.5, 0.7, 0.1, 0.1])
    amplitude, frequency = a[..., None] * factors, f[..., None] + shifts
    amplitude[2, :, 1] *= 2  # uncoupled higher than coupled beyond the optimum
    ones = np.ones((3, 2, 5))
    return Plane(
        "interference",
        MU,
        V0,
        tuple(method.name for method in METHODS),
        amplitude,
        frequency,
        0 * ones,
        ones,
        ones.astype(int),
        ones,
        ones.astype(int),
    )
