"""What holds each joint at rest while its contacts wear."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.balance.stuck_modes import StuckModes, stuck_modes
from vanelock.nonlinear.forced_response.frequency_response import static_response
from vanelock.nonlinear.forced_response.options import Options
from vanelock.rom.system.system import System

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Rest:
    """Joints at rest.

    Attributes
    ----------
    load : (j,) float
        Sum of the normal forces of each joint's contacts in a sector, N.
    approach : (j,) float
        Largest normal displacement among them, m; none is closed where it is negative.
    converged : bool
        Whether the state at rest is solved.
    """

    load: Floats
    approach: Floats
    converged: bool


@dataclass(frozen=True)
class Preload:
    """Finds joints at rest by the interference of all contacts.

    Attributes
    ----------
    system : System
    options : Options
    joints : tuple of str
        All that consist of contacts.
    modes : dict of int to StuckModes
        Those of nodal diameter 0, which wear does not change.
    """

    system: System
    options: Options
    joints: tuple[str, ...]
    modes: dict[int, StuckModes]

    def at(self, v0: Floats) -> Rest:
        """The joints at an interference, (c,) m."""
        contacts = replace(self.system.contacts, v0=v0)
        found = static_response(replace(self.system, contacts=contacts), self.options, self.modes)
        v = found.contact[0, 0, :, 0].real
        n = contacts.kn * np.maximum(v, 0.0)
        members = [contacts.of(joint) & contacts.springs for joint in self.joints]
        load = np.array([n[each].sum() for each in members])
        approach = np.array([v[each].max() for each in members])
        return Rest(load, approach, bool(found.converged[0]))


def preload(system: System, options: Options) -> Preload:
    """What finds the joints of a system at rest."""
    contacts = system.contacts
    named = zip(contacts.joints, contacts.springs, strict=True)
    joints = tuple(dict.fromkeys(joint for joint, spring in named if spring))
    return Preload(system, options, joints, {0: stuck_modes(system, 0)})
