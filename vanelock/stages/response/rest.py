"""What contacts do at rest: whether those that are closed hold every part, and which only press."""

import numpy as np
import scipy.linalg as sl

from vanelock.nonlinear import Response
from vanelock.rom import System, linear_stiffness

PRESSED = 1e-9
"""Normal force over the largest of all that closes a contact; less is round-off."""
HELD = 1e-10
"""Least stiffness, over that with all contacts closed, that holds."""


def undetermined(system: System, static: Response) -> bool:
    """Whether some motion at rest meets no stiffness but that of contacts that are open.

    Parameters
    ----------
    system : System
        The joined parts.
    static : Response
        Their state at rest.
    """
    normal = static.force[0, 0, :, 0].real
    closed = normal > PRESSED * np.abs(normal).max(initial=0.0)
    if closed.all():
        return False
    held, stuck = (linear_stiffness(system, 0, which).real for which in (closed, None))
    try:
        sl.cholesky(held - HELD * stuck)
    except sl.LinAlgError:
        return True
    return False


def constant_loads(system: System) -> dict[str, int]:
    """By joint, contacts across which nothing moves along the normal; only where there are any."""
    k = system.nodal_diameter(1)
    still = ~np.any(system.contact_rows(k)[:, 0], axis=1)
    joints = np.array(system.contacts.joints)[still].tolist()
    return {name: joints.count(name) for name in dict.fromkeys(joints)}
