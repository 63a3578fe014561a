"""What holds at rest: closed contacts or nothing, which only press, and what inertia bears."""

import numpy as np
import scipy.linalg as sl

from vanelock.nonlinear import Response
from vanelock.rom import System, linear_stiffness, unheld_motions

PRESSED = 1e-9
"""Normal force over the largest, that of interference included, that closes a contact; less is
round-off."""
HELD = 1e-10
"""Least stiffness, over that with all contacts closed, that holds."""


def undetermined(system: System, static: Response) -> bool:
    """Whether some motion at rest meets no stiffness but that of contacts that are open.

    Motions that no contact would hold aside.
    """
    normal = static.force[0, 0, :, 0].real
    springs = system.contacts.kn * np.abs(system.contacts.v0)
    largest = max(np.abs(normal).max(initial=0.0), springs.max(initial=0.0))
    closed = normal > PRESSED * largest
    if closed.all():
        return False
    held, stuck = (linear_stiffness(system, 0, which).real for which in (closed, None))
    M = system.at(0).M.real
    moved = M @ unheld_motions(system, 0).real
    held, stuck = (K + stuck.trace() / M.trace() * moved @ moved.T for K in (held, stuck))
    try:
        sl.cholesky(held - HELD * stuck)
    except sl.LinAlgError:
        return True
    return False


def not_held(system: System) -> int:
    """Number of motions of the whole that nothing holds, not even contacts, at rest."""
    return len(unheld_motions(system, system.nodal_diameter(0)).T)


def on_inertia(system: System) -> float:
    """Size of what the inertia of motions that nothing holds balances, over the static load's."""
    k, force = system.nodal_diameter(0), system.force.get(0)
    if force is None or not force.vector.any():
        return 0.0
    M = system.at(k).M
    R = unheld_motions(system, k)
    borne = M @ (R @ (R.conj().T @ force.vector))
    return float(np.linalg.norm(borne) / np.linalg.norm(force.vector))


def constant_loads(system: System) -> dict[str, int]:
    """By joint, contacts across which nothing moves along the normal; only where there are any."""
    k = system.nodal_diameter(1)
    still = ~np.any(system.contact_rows(k)[:, 0], axis=1)
    joints = np.array(system.contacts.joints)[still].tolist()
    return {name: joints.count(name) for name in dict.fromkeys(joints)}
