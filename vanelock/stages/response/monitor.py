"""Which displacement stands for the vibration: one component of one output node."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError
from vanelock.input.schema.study import MONITOR
from vanelock.nonlinear import Response
from vanelock.rom import System


@dataclass(frozen=True)
class Monitor:
    """A component of an output node.

    Attributes
    ----------
    name : str
        Such as "vane accessory 1, radial".
    node, component : int
        Where it is among the outputs.
    """

    name: str
    node: int
    component: int

    def amplitude(self, response: Response) -> NDArray[np.float64]:
        """(p,) half the peak-to-peak, m; not a number where a point did not converge."""
        amplitude = response.amplitude[:, self.node, self.component]
        return np.where(response.converged, amplitude, np.nan)


def monitor(wanted: str | None, system: System, free: Response) -> Monitor:
    """The displacement that a study monitors.

    Parameters
    ----------
    wanted : str or None
        `outputs.monitor`: an output node and perhaps a component; by default the first node, and
        the component that moves most in the linear response `free`.
    """
    found = re.fullmatch(MONITOR, wanted or system.output_names[0])
    if found is None or found["node"] not in system.output_names:
        names = ", ".join(system.output_names)
        raise InputError(f'outputs.monitor = "{wanted}": allowed nodes are {names}')
    node = system.output_names.index(found["node"])
    if found["component"]:
        component = COMPONENTS.index(found["component"])
    else:
        component = int(free.amplitude[:, node].max(axis=0).argmax())
    return Monitor(f"{found['node']}, {COMPONENTS[component]}", node, component)
