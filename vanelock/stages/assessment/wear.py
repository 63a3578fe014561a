"""The step that wears the joints of a case while the engine dwells, and follows the vibration."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vanelock import nonlinear
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.schema.assessment.wear import DwellKeys
from vanelock.nonlinear import Dwell, Options, Response, WearHistory
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.assessment.bounds import Count
from vanelock.stages.parts.places import places_on
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import frequency_keys
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import by_height, peak_of

SHOWN = 8
"""States of a history in a table, about."""


@dataclass(frozen=True)
class WornCase(Product):
    """Wear of a case over cycles; without a history, why there is none.

    Attributes
    ----------
    history : WearHistory or None
    reason : str
    """

    history: WearHistory | None = None
    reason: str = ""


def wear_step(planned: Planned, first: Planned, count: Count) -> Step[WornCase]:
    """Wear of a case over the cycles of its dwells."""
    study = planned.case.study
    keys = study.wear
    assert keys is not None
    own = {"monitor": study.outputs.monitor, "direction": study.response.direction}
    inputs = {**keys.model_dump(), **study.wear_coefficients, **frequency_keys(study), **own}
    free, mesh = first.linear.responses["free"], planned.meshes["vane"]

    def compute(get: Callable[[Step[Any]], Any]) -> WornCase:
        watched = monitor(study.outputs.monitor, get(first.linear.system), get(free))
        response = by_height([get(each) for each in planned.responses], watched)[0]
        peak = peak_of(response, watched.amplitude(response))
        if peak is None:
            return WornCase(reason="no point converged")
        system: System = get(planned.solved(response).system)
        at = places_on(study, get(mesh))
        k = np.nan_to_num(at.coefficient)
        if not np.isfinite(at.area[k > 0]).all():
            return WornCase(reason="the area of some contacts is not known")
        options = Options(
            harmonics=as_solved(response, peak.point).harmonics,
            friction=response.friction,
            direction="down" if response.direction == "down" else "up",
        )
        reached = 0

        def progress(cycles: float, total: float, hertz: float, amplitude: float) -> None:
            nonlocal reached
            reached = max(reached, int(100 * cycles / total))
            count(reached, 100, amplitude)

        ends = float(response.frequency.min()), float(response.frequency.max())
        try:
            found = nonlinear.wear_history(
                system,
                [_dwell(each, ends) for each in keys.dwells],
                k,
                np.where(k > 0, at.area, 1.0),
                options,
                (system.output_names[watched.node], watched.component),
                keys.step,
                progress,
            )
        except InputError as error:
            return WornCase(reason=str(error))
        return WornCase(found)

    needs = (planned.system, *planned.responses, first.linear.system, free, mesh)
    of = planned.case.name
    return step("wear", "nonlinear", inputs, WornCase, needs, compute, pulls=True, of=of)


def _dwell(keys: DwellKeys, ends: tuple[float, float]) -> Dwell:
    """A dwell of the study; without a frequency at the peak of its range."""
    if keys.frequency is not None:
        return Dwell(keys.cycles, frequency=keys.frequency, force=keys.load)
    low, high = ends if keys.range is None else keys.range
    return Dwell(keys.cycles, near=(low, high), force=keys.load)


def shown_states(history: WearHistory) -> list[int]:
    """States of a history that tables show: both ends of each dwell, jumps, some between."""
    last = len(history.cycles) - 1
    even = np.interp(np.linspace(0, history.cycles[-1], SHOWN), history.cycles, np.arange(last + 1))
    ends = np.flatnonzero(np.diff(history.dwell))
    jumps = np.flatnonzero(history.jump)[:SHOWN]
    every = (np.round(even).astype(int), ends, ends + 1, jumps)
    return sorted(set(np.concatenate(every).tolist()))


def worn_at(planned: Planned, wear: Step[WornCase], state: int) -> Planned:
    """The case as worn at a state of its history, with the vibration there as its only point."""

    def worn_system(system: System, worn: WornCase) -> System:
        assert worn.history is not None
        return worn.history.system_at(system, state)

    def vibration(worn: WornCase) -> Response:
        assert worn.history is not None
        return worn.history.response.at([state])

    base, at = planned.system, {"worn": state}
    system = step("system", "rom", at, System, (base, wear), worn_system, False, True)
    response = step("response", "nonlinear", at, Response, (wear,), vibration, False, True)
    return planned.at_end(system, response)
