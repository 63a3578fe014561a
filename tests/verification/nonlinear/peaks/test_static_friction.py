"""Bounds over static friction: a mixed-integer programme, random places, the vane."""

from collections import Counter

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp

from tests.conftest import FULL
from tests.nonlinear.systems import random_system, with_contacts
from tests.verification.nonlinear.spring_rings import spring_ring
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Options,
    System,
    audit_response,
    frequency_response,
    linear_response,
    peak_bounds,
    static_bounds,
)
from vanelock.nonlinear.balance.balance import structure

FAR = 50.0
"""Bound of all displacements of the mixed-integer programme, in those of the stuck structure."""


def proved_loads(system: System, chosen: np.ndarray, far: float = FAR) -> list[float]:
    """Least and largest load of some contacts at rest, N, by branch and bound.

    Unknowns: all w, up to `far`, and whether each contact is closed. Of the program's it takes the
    receptances alone.
    """
    balance = structure(system, 0).balance(0.0)
    R, linear = balance.columns.all(0).real, balance.linear[:, :, 0].reshape(-1)
    contacts, c = system.contacts, system.contacts.count
    scale = np.abs(linear).max()
    linear, stretch, normal = linear / scale, R - np.eye(3 * c), 3 * np.arange(c)
    none, each = np.zeros((c, c)), np.eye(c)
    matrices = [
        np.hstack([stretch[normal], none]),  # n / kn >= 0
        np.hstack([stretch[normal], -far * each]),  # closed, or n = 0
        np.hstack([-np.eye(3 * c)[normal], far * each]),  # open, or w_n = 0
    ]
    lows = [-linear[normal], np.full(c, -np.inf), np.full(c, -np.inf)]
    highs = [np.full(c, np.inf), -linear[normal], np.full(c, far)]
    for way in (1, 2):
        alpha = contacts.mu * contacts.kn / contacts.kt[:, way - 1]
        for sign in (1, -1):
            row = sign * stretch[normal + way] - alpha[:, None] * stretch[normal]
            matrices.append(np.hstack([row, none]))
            lows.append(np.full(c, -np.inf))
            highs.append(alpha * linear[normal] - sign * linear[normal + way])
    below, above = np.full(4 * c, -np.inf), np.full(4 * c, np.inf)
    above[normal], below[3 * c :], above[3 * c :] = 0, 0, 1
    rate = (contacts.kn * chosen) @ stretch[normal]
    loads = []
    for sign in (1, -1):
        found = milp(
            np.append(sign * rate / np.abs(rate).max(), np.zeros(c)),
            constraints=LinearConstraint(
                np.vstack(matrices), np.concatenate(lows), np.concatenate(highs)
            ),
            bounds=Bounds(below, above),
            integrality=np.repeat([0, 1], [3 * c, c]),
        )
        assert found.status == 0
        at = scale * (linear[normal] + stretch[normal] @ found.x[: 3 * c])
        loads.append(float((contacts.kn * chosen) @ at))
    return loads


def test_loads_are_those_that_branch_and_bound_proves(record):
    by_proof, by_search = [], []
    for seed in range(200 if FULL else 6):
        system = random_system(seed, contacts=4, mu=0.3, harmonics=1)
        system = with_contacts(system, joint=tuple("abbb"))
        chosen = np.arange(4) == 0
        by_proof.append(proved_loads(system, chosen))
        bounds = static_bounds(system, "a")
        assert bounds.proved.all()
        by_search.append(bounds.rest_load[0, [0, 2]])
    proved, found = np.array(by_proof), np.array(by_search)
    size = np.maximum(proved[:, 1:], 1e-7)  # below it, round-off of loads of about 1 N
    same = np.abs(found - proved) < 1e-6 * size
    record("ends", found.size)
    for seed in np.flatnonzero(
        np.isinf(found[:, 1])
    ).tolist():  # what it is depends on how far it looks
        system = random_system(seed, contacts=4, mu=0.3, harmonics=1)
        assert proved_loads(system, np.arange(4) == 0, 2 * FAR)[1] > 1.5 * proved[seed, 1]
        same[seed, 1], found[seed, 1] = True, proved[seed, 1]
    record("those that are proved to be the last", int(same.sum()))
    assert same.all()


def peak_of(system, hertz, direction):
    """Highest peak of the output's direction among close frequencies, m; 0 if there is none."""
    response = frequency_response(system, hertz, Options(1), find_jumps=False)
    size = response.amplitude[:, 0, direction]
    peaks = (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])
    return float(size[1:-1][peaks].max(initial=0.0))


@pytest.mark.parametrize("half", [0, 1])
def test_no_random_place_of_the_sliders_gives_a_peak_outside(half, record):
    """Rings of even and of odd seeds: most of the time of this page."""
    seeds = range(half, 200 if FULL else 4, 2)
    draws, outside, widths = 0, Counter[int](), []
    for seed in seeds:
        system = spring_ring(seed, 0.3)
        hertz = np.linspace(0.1, 0.45, 300)
        stuck = linear_response(system, hertz).amplitude[:, 0].max(axis=1)
        top = hertz[stuck.argmax()]
        near = (0.85 * top, 1.1 * top)
        try:
            found = peak_bounds(system, near, Options(1), starts=2)
        except InputError as error:  # friction has moved it away, or damped it out
            if "no peak was found" not in str(error):
                raise
            continue
        widths.append(found.amplitude[2] / found.amplitude[0])
        reach, random = np.abs(found.slider).max(), np.random.default_rng(seed)
        for _ in range(500 if FULL else 10):
            slider = reach * random.normal(size=system.contacts.kt.shape) * random.uniform()
            moved = with_contacts(system, slider=slider)
            size = peak_of(moved, np.linspace(*near, 60), found.direction)
            draws += 1
            outside[seed] += int(size > 1.01 * found.amplitude[2])
    record("rings", f"{len(widths)} of {len(seeds)} with a peak")
    record("draws", draws)
    record("above the bound found by more than 1 %", outside.total())
    record("largest / least peak", f"{min(widths):.3f} ... {max(widths):.3f}")
    assert min(widths) >= 1
    assert not +outside
    assert len(widths) > 0.8 * len(seeds)


def test_peaks_of_the_vane_that_static_friction_allows(scene, record, below):
    system = scene.system
    found = peak_bounds(system, (235.0, 300.0) if FULL else (248.0, 312.0), Options(1), starts=2)
    least, nominal, largest = found.amplitude
    record("peak", f"{1e6 * nominal:.2f} um")
    record("bounds", f"x {least / nominal:.3f} ... {largest / nominal:.3f}")
    record("at", ", ".join(f"{each:.1f} Hz" for each in found.frequency))
    place = found.joints.index("interlock")
    shown = ", ".join(f"{each:.1f} N" for each in found.rest_load[:, place])
    record("interlock at rest", shown)
    residuals = [
        audit_response(found.system_at(system, i), found.response.at([i])).residual[0]
        for i in range(3)
    ]
    below("audited", max(residuals), 1e-6)
    assert found.converged.all()
    assert least < 0.5 * nominal
    assert largest > 1.1 * nominal
