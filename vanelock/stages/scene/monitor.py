"""Which displacement stands for the vibration of a scene, and what its responses come to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError
from vanelock.input.cases.scene_cases import SceneCase
from vanelock.nonlinear import OPEN, SLIP_OPEN, Response
from vanelock.rom import System
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.summary import RUBS, Peak, Sweep, share

CARTESIAN = ("x", "y", "z")


def scene_monitor(wanted: str | None, system: System, free: Response) -> Monitor:
    """The displacement that a scene monitors.

    Parameters
    ----------
    wanted : str or None
        `outputs.monitor`: an output node and perhaps a component, such as "upper 17, x"; by default
        the first node, and the component that moves most in the linear response `free`.
    system : System
        Where its outputs are.
    free : Response
        Linear response with contacts open.

    Raises
    ------
    InputError
        If there is no such output.
    """
    names = system.output_names
    if not names:
        raise InputError("outputs: the scene has no output nodes: give outputs.nodes or a load")
    components = COMPONENTS if system.sectors > 1 else CARTESIAN
    node, _, component = (wanted or names[0]).partition(", ")
    if node not in names or (component and component not in components):
        some = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        raise InputError(
            f'outputs.monitor = "{wanted}": allowed are {some}, and after ", " one of '
            f"{', '.join(components)}"
        )
    at = names.index(node)
    largest = int(free.amplitude[:, at].max(axis=0).argmax())
    place = components.index(component) if component else largest
    return Monitor(f"{node}, {components[place]}", at, place)


@dataclass(frozen=True)
class Found:
    """A case in numbers.

    Attributes
    ----------
    case : SceneCase
        Which.
    peak : Peak or None
        None where no point converged.
    of_free, of_stuck : float
        Peak over the linear peaks with contacts open and stuck; NaN where unknown.
    loose : bool
        Whether a part is held by no contact that is closed at rest.
    slipping, opening : float
        Share of the contacts that slip and that open in every period at the peak.
    work : dict of str to float
        Friction work of each joint in a period at the peak, J.
    converged, points : int
        Points that converged, and all.
    worst : float
        Largest residual of the others, 0 if there are none.
    seconds : float
        What computing took.
    warnings : tuple of str
        What else to know before using them, see `vanelock.quantities.warnings`.
    sweeps : tuple of Sweep
        That of the peak, and the other one where both directions were swept.
    """

    case: SceneCase
    peak: Peak | None
    of_free: float
    of_stuck: float
    loose: bool
    slipping: float
    opening: float
    work: dict[str, float]
    converged: int
    points: int
    worst: float
    seconds: float
    warnings: tuple[str, ...] = ()
    sweeps: tuple[Sweep, ...] = ()


def found_in(
    case: SceneCase,
    response: Response,
    joints: Sequence[str],
    peak: Peak | None,
    linear: Sequence[Peak | None],
    loose: bool,
    seconds: float,
) -> Found:
    """The numbers of a case; `linear` are the peaks with contacts open and stuck."""
    lost = ~response.converged
    slipping = opening = float("nan")
    work: dict[str, float] = {}
    if peak is not None:
        dissipation = response.dissipation[peak.point]
        most = dissipation.max(initial=0.0)
        slipping = share(
            dissipation > RUBS * most if most > 0 else np.zeros(len(dissipation), bool)
        )
        opening = share(np.isin(response.state[peak.point], (OPEN, SLIP_OPEN)))
        each = np.array(joints)
        work = {name: float(dissipation[each == name].sum()) for name in dict.fromkeys(joints)}
    over = [_over(peak, other) for other in linear]
    worst = float(response.residual[lost].max()) if lost.any() else 0.0
    count = int(response.converged.sum())
    return Found(
        case,
        peak,
        over[0],
        over[1],
        loose,
        slipping,
        opening,
        work,
        count,
        response.points,
        worst,
        seconds,
    )


def _over(peak: Peak | None, other: Peak | None) -> float:
    if peak is None or other is None or other.amplitude <= 0:
        return float("nan")
    return peak.amplitude / other.amplitude
