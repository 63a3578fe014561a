"""Between which loads static friction may hold a joint at rest: ends on `rest_states`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.following.bounds.rest_states import Joints, RestStates, rest_states
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.rom.system.system import System

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
        where friction can wedge the parts at any load, NaN where the programme failed.
    slider : (j, 3, c, 2) float
        Where the sliders were assembled for them, m; zeros where there is no such state.
    converged : (j, 3) bool
        Whether each was found, and its state at rest and that with sliders at zero are solved.
    proved : (j, 3) bool
        Whether no state lies beyond, whichever contacts are open; else it is the end of states
        that contacts reach by opening or closing one after another, and others may lie beyond.
    """

    joints: tuple[str, ...]
    rest_load: Floats = field(metadata={"unit": "N"})
    slider: Floats = field(metadata={"unit": "m"})
    converged: Bools
    proved: Bools


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
        If a joint is unknown, the share is not possible, or the structure is not held.
    """
    states = rest_states(system, joints, share, options, modes)
    names = dict.fromkeys(system.contacts.joints if of is None else np.atleast_1d(of).tolist())
    found = []
    for name in names:
        mask = system.contacts.of(name)
        if not mask.any():
            known = ", ".join(dict.fromkeys(system.contacts.joints)) or "none"
            raise InputError(f"of: given {name!r}: joints are {known}")
        found.append([_end(states, mask, sign) for sign in (1.0, 0.0, -1.0)])
    return StaticBounds(
        joints=tuple(names),
        rest_load=np.array([[end[1] for end in ends] for ends in found]).reshape(-1, 3),
        slider=np.array([[end[0] for end in ends] for ends in found]),
        converged=np.array([[end[2] for end in ends] for ends in found]).reshape(-1, 3),
        proved=np.array([[end[3] for end in ends] for ends in found]).reshape(-1, 3),
    )


def _end(states: RestStates, mask: Bools, sign: float) -> tuple[Floats, float, bool, bool]:
    """Sliders (c, 2), m, and load, N, where it is least (1) or largest (-1); if found; if proved.

    With 0 those assembled at zero.
    """
    try:
        slider, proved = states.proved_load(mask, sign) if sign else (states.zero, True)
    except InputError:
        return states.zero, np.nan, False, False
    if slider is None:
        return states.zero, np.inf, True, True
    state = states.solved(slider) if sign else states.nominal
    load = state.force[0, 0, mask, 0].real.sum()
    known = state.converged.all() and states.nominal.converged.all()
    return slider, max(float(load), 0.0), bool(known), proved
