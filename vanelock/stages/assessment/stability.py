"""The steps that determine whether the ring stays with the waves of a case's response."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear, rom
from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import (
    STABLE,
    UNDECIDED,
    UNSTABLE,
    HarmonicModes,
    Journal,
    Response,
    Stability,
)
from vanelock.nonlinear.floquet.stability import NEUTRAL
from vanelock.nonlinear.fourier.trigonometric import TURN
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.assessment.bounds import Count
from vanelock.stages.matrices import steps as of_matrices
from vanelock.stages.parts.components import casing_step
from vanelock.stages.parts.systems import joined_step, system_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import WaveVerdict, peak_of


def whole_step(planned: Planned) -> Step[System]:
    """A case's system with all nodal diameters, 0 to N/2."""
    given = planned.case.given
    every = range(given.ring.sectors // 2 + 1)
    lacking = tuple(k for k in every if k not in planned.held)
    if isinstance(given, Scene):
        if given.system is not None or not lacking:
            return planned.system
        more = [of_matrices.system_step(given, at=lacking)]
    elif planned.chosen_mesh is not None:
        return joined_step(planned.case.study, every)
    else:
        study, vane, base = planned.case.study, planned.rom["vane"], planned.base
        more = [system_step(study, vane, casing_step(study, k), base) for k in lacking]

    def compute(*systems: System) -> System:
        return rom.united(systems)

    return step("system", "rom", {}, System, (planned.system, *more), compute, False, True)


WORDS = {STABLE: "stable", UNSTABLE: "unstable", UNDECIDED: "undecided"}


def verdict_at(stability: Stability, frequency: float) -> WaveVerdict | None:
    """What is known of the wave at a frequency, Hz, solved; None where nothing is."""
    (at,) = np.nonzero(stability.frequency == frequency)
    if not len(at):
        return None
    i = int(at[0])
    seen = stability.seen[i, 0]
    return WaveVerdict(
        verdict=WORDS[int(stability.verdict[i])],
        growth=float(np.abs(stability.multiplier[i, 0])),
        diameter=int(stability.diameter[i, 0]),
        growing=int(stability.growing[i]),
        frequencies=tuple(seen[np.isfinite(seen)].tolist()),
        reason=undecided(stability, i) if stability.verdict[i] == UNDECIDED else "",
    )


def undecided(stability: Stability, point: int) -> str:
    """Why the verdict at a point is neither stable nor unstable."""
    growth = stability.growth[point] / (TURN * stability.frequency[point])
    if np.isnan(growth).any():
        return f"the wave was not found again with {stability.harmonics[1]} harmonics"
    if np.any(np.abs(growth) <= NEUTRAL):
        return "a departure from it neither grows nor dies out"
    if growth.min() < 0 < growth.max():
        return "two numbers of harmonics differ on whether a departure from it grows"
    return "not all departures from it could be followed"


def verdicts_along(frequency: NDArray[np.float64], stability: Stability) -> NDArray[np.int64]:
    """(p,) verdicts at the frequencies of a curve, Hz; -1 where nothing is known."""
    known = dict(zip(stability.frequency.tolist(), stability.verdict.tolist(), strict=True))
    return np.array([known.get(each, -1) for each in frequency.tolist()])


def stability_step(
    planned: Planned,
    first: Planned,
    whole: Step[System],
    response: Step[Response],
    count: Count,
) -> Step[Stability]:
    """Stability of a response of a case: at its peak, or all along."""
    given = planned.case.given
    keys, free = given.stability, first.linear.responses["free"]
    assert keys is not None
    inputs = {**keys.model_dump(), "monitor": given.outputs.monitor}

    def compute(
        system: System,
        response: Response,
        base: System,
        free: Response,
        stuck: HarmonicModes,
        journal: Journal,
    ) -> Stability:
        chosen = np.flatnonzero(response.converged).tolist()
        if keys.points == "peaks":
            watched = monitor(given.outputs.monitor, base, free)
            peak = peak_of(response, watched.amplitude(response))
            point = 0 if peak is None else peak.point
            response, chosen = as_solved(response, point), [0]
        return nonlinear.stability(
            system,
            response,
            chosen,
            progress=lambda done, total: count(done, total, float("nan")),
            modes=stuck.diameters,
            journal=journal,
        )

    needs: tuple[Step[Any], ...] = (whole, response, first.linear.system, free, planned.modes)
    of = planned.case.name
    return step("stability", "nonlinear", inputs, Stability, needs, compute, resumes=True, of=of)
