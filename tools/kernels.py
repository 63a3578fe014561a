"""Compile what the solver compiles at first use, and keep it: `python tools/kernels.py isotropic`.

One or two masses that slide on the ground, by every way of looking at them: harmonic balance with
located and sampled contacts and with elements, its audit, stability and time integration.
"""

import sys

import numpy as np

from vanelock.nonlinear import (
    Contact,
    Element,
    Options,
    System,
    audit_response,
    frequency_response,
    stability,
    time_response,
)
from vanelock.nonlinear.balance.receptance_columns import combine
from vanelock.nonlinear.transient.time_marching import follow

HERTZ = [15.0, 16.0, 17.0]


def system(count: int, *elements: Element) -> System:
    """Masses of 1 kg in a row; the second presses on the ground, others slide there."""
    contact = Contact(
        tangential=0, second=2 if count > 2 else None, normal=1, kt=1e4, kn=1e4, mu=0.3, preload=2.0
    )
    K = 2e4 * np.eye(count) - 1e4 * (np.eye(count, k=1) + np.eye(count, k=-1))
    force = {0: 1.0, count - 1: 1.0}
    return System.from_matrices(
        np.eye(count), K, [contact], elements=elements, damping_ratio=0.01, force=force
    )


def compile_for(friction: str) -> None:
    """What responses with this friction need."""
    masses = system(3 if friction == "isotropic" else 2)
    for samples in (None,) if friction == "isotropic" else (None, 64):
        options = Options(3, friction=friction, samples=samples)
        response = frequency_response(masses, HERTZ, options)
        assert response.converged.all()
        audit_response(masses, response)
        if samples is None:
            stability(masses, response, [1])
    time_response(masses, HERTZ[1], periods=2, steps=32, harmonics=3, friction=friction)


def compile_elements() -> None:
    """What elements need beside it."""
    spring = Element(force="cubic_spring", places=[0], parameters=[0.5])
    damper = Element(force="quadratic_damper", places=[1], parameters=[0.5])
    frequency_response(system(2, spring, damper), HERTZ, Options(3))


def compile_tables() -> None:
    """What large systems need: receptances from tables, contacts that stick for a long time."""
    follow(np.zeros((1, 1, 3)), np.ones((1, 2)), False, np.zeros((1, 3)))
    places = np.zeros(1, np.int64)
    combine(np.zeros((1, 1, 3), complex), np.zeros(1), places, np.zeros((1, 3), complex))


if __name__ == "__main__":
    compile_for(sys.argv[1])
    if sys.argv[1] == "orthogonal":
        compile_elements()
        compile_tables()
