"""The step that follows a ring from the peak of a case, where its wave is unstable."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.nonlinear import (
    MODULATED,
    STEADY,
    UNSETTLED,
    UNSTABLE,
    Journal,
    Response,
    SettledResponse,
    Stability,
)
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.assessment.bounds import Count
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Settled, peak_of

STEPS, PERIODS = 128, 1000
"""Steps a period, and periods at most; some tenths of a second each for a coarse vane's ring."""
MODES = 60
"""Modes of a nodal diameter that keep their inertia; the others follow statically."""
DISTURBANCE = 1e-4
WORDS = {STEADY: "steady", MODULATED: "modulated", UNSETTLED: "not settled"}


@dataclass(frozen=True)
class FollowedPeak(Product):
    """What the ring does at the peak of a response.

    Attributes
    ----------
    found : SettledResponse or None
        None where the peak's wave is not unstable, so that it was not followed.
    node, component : int
        The monitored displacement among the outputs.
    """

    found: SettledResponse | None = None
    node: int = 0
    component: int = 0

    @property
    def balance(self) -> float:
        """The monitored displacement of the wave, m; NaN where it was not followed."""
        if self.found is None:
            return float("nan")
        return float(self.found.balance[self.node, self.component])

    @property
    def settled(self) -> Settled | None:
        """The monitored displacement in numbers."""
        if (found := self.found) is None:
            return None
        at = self.node, self.component
        return Settled(
            verdict=WORDS[found.verdict],
            mean=float(found.mean[at]),
            largest=float(found.largest[at]),
            smallest=float(found.smallest[at]),
            periods=found.periods,
            returned=found.returned,
            unsolved=found.unsolved,
        )


def settled_step(
    planned: Planned,
    first: Planned,
    whole: Step[System],
    response: Step[Response],
    stability: Step[Stability],
    count: Count,
) -> Step[FollowedPeak]:
    """What the ring does at the peak of a response of a case, if its wave is unstable."""
    given, free = planned.case.given, first.linear.responses["free"]
    inputs = {
        "monitor": given.outputs.monitor,
        "steps": STEPS,
        "periods": PERIODS,
        "modes": MODES,
        "disturbance": DISTURBANCE,
    }

    def compute(
        system: System,
        response: Response,
        stability: Stability,
        base: System,
        free: Response,
        journal: Journal,
    ) -> FollowedPeak:
        watched = monitor(given.outputs.monitor, base, free)
        peak = peak_of(response, watched.amplitude(response))
        if peak is None:
            return FollowedPeak()
        at = np.flatnonzero(stability.frequency == peak.frequency)
        if not len(at) or stability.verdict[at[0]] != UNSTABLE:
            return FollowedPeak()
        alone = as_solved(response, peak.point)
        found = nonlinear.settled_response(
            system,
            alone,
            0,
            steps=max(STEPS, 4 * alone.harmonics + 4),
            periods=PERIODS,
            disturbance=DISTURBANCE,
            modes=MODES,
            growth=float(stability.growth[at[0]].min()),
            progress=lambda done, total, defect: count(done, total, float("nan")),
            journal=journal,
        )
        return FollowedPeak(found, watched.node, watched.component)

    needs: tuple[Step[Any], ...] = (whole, response, stability, first.linear.system, free)
    of = planned.case.name
    return step("settled", "nonlinear", inputs, FollowedPeak, needs, compute, resumes=True, of=of)
