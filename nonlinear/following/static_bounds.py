"""Between which loads static friction may hold a joint at rest: ends on `rest_states`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.following.rest_states import Joints, rest_states
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.rom.system import System

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class StaticBounds(Product):
    """Loads of j joints at rest: the least, that with sliders assembled at zero, and the largest.

    Attributes
    ----------
    joints : tuple of str
        Their names.
    rest_load : (j, 3) float
        Sum of the normal forces of a joint's contacts in a sector, N, each of a solved state; inf
        where friction can wedge the parts at any load.
    slider : (j, 3, c, 2) float
        Where the sliders were assembled for them, m; zeros for an infinite load.
    converged : (j, 3) bool
        Whether each state was solved.
    """

    joints: tuple[str, ...]
    rest_load: Floats = field(metadata={"unit": "N"})
    slider: Floats = field(metadata={"unit": "m"})
    converged: Bools


@one_thread
def static_bounds(
    system: System,
    of: str | Sequence[str] | None = None,
    joints: Joints = "all",
    share: float = 1.0,
    options: Options = Options(),
    modes: Mapping[int, StuckModes] | None = None,
) -> StaticBounds:
    """Between which loads static friction may hold joints at rest, each by itself.

    Parameters
    ----------
    system : System
        Its own sliders are not looked at.
    of : str or sequence of str, optional
        The joints whose load it is; every one by default.
    joints : str, sequence of str or (c,) bool
        Those whose static friction is undetermined. The others use the share of Coulomb's limit
        that they use with all sliders assembled at zero.
    share : float
        Share of Coulomb's limit by which friction may differ from that state, 0 to 1.
    options : Options
        As of `static_response`.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.

    Raises
    ------
    InputError
        If a joint is unknown, the share is not possible, friction is isotropic, or the structure is
        not held.
    """
    states = rest_states(system, joints, share, options, modes)
    names = dict.fromkeys(system.contacts.joints if of is None else np.atleast_1d(of).tolist())
    sliders, loads, converged = [], [], []
    for name in names:
        mask = np.array([each == name for each in system.contacts.joints], bool)
        if not mask.any():
            known = ", ".join(dict.fromkeys(system.contacts.joints)) or "none"
            raise InputError(f"of: given {name!r}: joints are {known}")
        ends = states.least_load(mask), states.zero, states.least_load(mask, -1.0)
        found = [None if end is None else states.solved(end) for end in ends]
        sliders.append([states.zero if end is None else end for end in ends])
        forces = [None if each is None else each.force[0, 0, mask, 0].real for each in found]
        loads.append([np.inf if force is None else max(force.sum(), 0.0) for force in forces])
        converged.append([each is None or each.converged.all() for each in found])
    return StaticBounds(tuple(names), np.array(loads), np.array(sliders), np.array(converged))
