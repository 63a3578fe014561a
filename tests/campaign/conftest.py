"""A sector of masses and springs with hook and interlock contacts, small enough for planes."""

import numpy as np
import pytest

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
        ),
        force={1: Force(np.array([0, 0.2 + 0j, 1.0, 3.0]))},
        output_names=("vane accessory 1",),
        damping_ratio=0.01,
    )
