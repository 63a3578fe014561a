"""The steps that follow damped modes of a case, and find where the air keeps them going."""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from vanelock import nonlinear
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear import DampedMode, LimitCycles, Options, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.assessment.bounds import Count
from vanelock.stages.assessment.unlike import peak_harmonics
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.summary import by_height


@dataclass(frozen=True)
class FollowedMode(Product):
    """A damped mode of a case; without one, why there is none.

    Attributes
    ----------
    number : int
        The mode's, from 1.
    nodal_diameter : int
        Of the wave, -N/2 to N/2.
    node, component : int
        The monitored displacement among the outputs.
    alone : DampedMode or None
        Where no air is given.
    driven : LimitCycles or None
        Where it is; `mode` is the same without it.
    reason : str
    """

    number: int
    nodal_diameter: int
    node: int
    component: int
    alone: DampedMode | None = None
    driven: LimitCycles | None = None
    reason: str = ""

    @property
    def mode(self) -> DampedMode | None:
        """The mode without the air."""
        return self.alone if self.driven is None else self.driven.mode


def damped_mode_steps(
    planned: Planned, first: Planned, whole: Step[System], count: Count
) -> Iterator[Step[FollowedMode]]:
    """One for each mode of each nodal diameter; `first` says which displacement is monitored."""
    study = planned.case.study
    keys = study.damped_modes
    assert keys is not None
    own = study.excitation.engine_order
    N = study.ring.sectors
    wave = own % N if 2 * (own % N) <= N else own % N - N
    for k in keys.nodal_diameters or (wave,):
        held = all(folded(h * k, N) in planned.held for h in range(study.response.harmonics + 1))
        system = planned.system if held else whole
        for number in keys.modes or (study.response.mode,):
            yield _step(planned, first, system, number, k, count)


def _step(
    planned: Planned, first: Planned, system: Step[System], number: int, k: int, count: Count
) -> Step[FollowedMode]:
    """One mode of one nodal diameter."""
    study = planned.case.study
    assert study.damped_modes is not None
    air, N = study.damped_modes.air, study.ring.sectors
    adaptive = planned.chosen_mesh is not None
    inputs = {
        "mode": number,
        "nodal_diameter": k,
        "influence": study.damped_modes.influence,
        "harmonics": study.response.harmonics,
        "friction": study.response.friction,
        "monitor": study.outputs.monitor,
    }
    free = first.linear.responses["free"]

    def compute(system: System, base: System, free: Response, *responses: Response) -> FollowedMode:
        watched, H = monitor(study.outputs.monitor, base, free), study.response.harmonics
        if adaptive:
            H = peak_harmonics(by_height(responses, watched)[0], watched)
        options = Options(harmonics=H, friction=study.response.friction)
        at = number, k, watched.node, watched.component

        def progress(done: int, total: int, hertz: float, amplitude: float) -> None:
            count(done, total, float("nan"))

        with warnings.catch_warnings(category=RuntimeWarning, action="ignore"):  # `ended` says it
            try:
                if air is None:
                    found = nonlinear.damped_mode(
                        system, number, None, options, k % N, progress=progress
                    )
                    return FollowedMode(*at, alone=found)
                driven = nonlinear.limit_cycles(
                    system, number, air, None, options, k % N, progress=progress
                )
            except InputError as error:
                return FollowedMode(*at, reason=str(error))
        return FollowedMode(*at, driven=driven)

    needs: tuple[Step[Any], ...] = (system, first.linear.system, free)
    needs += planned.responses if adaptive else ()
    of = f"{planned.case.name} mode {number} ND {k}"
    return step("damped mode", "nonlinear", inputs, FollowedMode, needs, compute, of=of)
