"""Which displacement stands for the vibration: one component of one output node."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError
from vanelock.nonlinear import Response
from vanelock.rom import System

CARTESIAN = ("x", "y", "z")
MOST = 6
"""Output nodes that a message names."""


@dataclass(frozen=True)
class Monitor:
    """A component of an output node.

    Attributes
    ----------
    name : str
        Such as "upper 17, x".
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
    """The displacement that a case monitors."""
    node, component = output_of(wanted, system.output_names, system.sectors)
    at = system.output_names.index(node)
    largest = int(free.amplitude[:, at].max(axis=0).argmax())
    components = COMPONENTS if system.sectors > 1 else CARTESIAN
    place = components.index(component) if component else largest
    return Monitor(f"{node}, {components[place]}", at, place)


def output_of(wanted: str | None, names: Sequence[str], sectors: int) -> tuple[str, str]:
    """The output node and component, "" where none is named, that `outputs.monitor` means."""
    if not names:
        raise InputError("outputs: the scene has no output nodes: give outputs.nodes or a load")
    components = COMPONENTS if sectors > 1 else CARTESIAN
    node, _, component = (wanted or names[0]).partition(", ")
    if node not in names or (component and component not in components):
        some = ", ".join(names[:MOST]) + (", ..." if len(names) > MOST else "")
        raise InputError(
            f'outputs.monitor = "{wanted}": allowed are {some}, and after ", " one of '
            f"{', '.join(components)}"
        )
    return node, component
