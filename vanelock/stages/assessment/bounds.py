"""The step that bounds a case's peak over static friction that its model leaves undetermined."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear import Journal, Options, PeakBounds, Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import frequencies
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import frequency_keys
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak, by_height, peak_of

Count: TypeAlias = Callable[[int, int | None, float], None]
"""Called with how many are done, of how many where that is known, and an amplitude, m, or NaN."""

LOW, NOMINAL, HIGH = 0, 1, 2
"""Places of `PeakBounds`."""


@dataclass(frozen=True)
class BoundedPeak(Product):
    """Bounds of a peak, and the curves at both; without bounds, why there are none.

    Attributes
    ----------
    found : PeakBounds or None
    low, high : Response or None
        Over the frequencies of the case, with the sliders of the least and of the largest peak.
    residual : (3,) float
        Of an audit of the peaks, see `Audit`.
    reason : str
        Why there are no bounds.
    """

    found: PeakBounds | None = None
    low: Response | None = None
    high: Response | None = None
    residual: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.nan))
    reason: str = ""

    def shortened(self) -> "BoundedPeak":
        """The same without its curves and all states but the nominal one."""
        if self.found is None:
            return self
        nominal = replace(self.found, response=self.found.response.at([NOMINAL]))
        return replace(self, found=nominal, low=None, high=None)

    def peak(self, place: int) -> Peak | None:
        """The least (0), nominal (1) or largest (2) peak; None without bounds."""
        if self.found is None:
            return None
        at = float(self.found.frequency[place]), float(self.found.amplitude[place])
        return Peak(place, *at, at_edge=False)


def bounds_step(planned: Planned, first: Planned, count: Count) -> Step[BoundedPeak]:
    """Bounds of a case's peak, of that sweep which finds the higher one."""
    given = planned.case.given
    keys = given.bounds
    assert keys is not None
    wanted = keys.model_dump()
    limits, modes, free = planned.linear.limits, planned.modes, first.linear.responses["free"]
    own = {"monitor": given.outputs.monitor, "direction": given.response.direction}
    inputs = {**wanted, **frequency_keys(given), **own}

    def compute(get: Callable[[Step[Any]], Any], journal: Journal) -> BoundedPeak:
        stuck = get(modes).diameters
        watched = monitor(given.outputs.monitor, get(first.linear.system), get(free))
        response = by_height([get(each) for each in planned.responses], watched)[0]
        peak = peak_of(response, watched.amplitude(response))
        if peak is None:
            return BoundedPeak(reason="no point converged")
        system: System = get(planned.solved(response).system)
        options = Options(
            harmonics=as_solved(response, peak.point).harmonics,
            friction=response.friction,
            direction="down" if response.direction == "down" else "up",
        )
        try:
            found = nonlinear.peak_bounds(
                system,
                (float(response.frequency.min()), float(response.frequency.max())),
                options,
                (system.output_names[watched.node], watched.component),
                keys.joints or "all",
                keys.share,
                keys.starts,
                seed=keys.seed,
                progress=lambda done, amplitude: count(done, None, amplitude),
                modes=stuck,
                journal=journal,
            )
        except InputError as error:
            return BoundedPeak(reason=str(error))
        at = [found.system_at(system, place) for place in (LOW, NOMINAL, HIGH)]
        audits = [
            nonlinear.audit_response(each, found.response.at([place]))
            for place, each in enumerate(at)
        ]
        hertz = frequencies(given, get(limits))
        low, high = (
            nonlinear.frequency_response(at[place], hertz, options, None, stuck, journal)
            for place in (LOW, HIGH)
        )
        return BoundedPeak(found, low, high, np.array([each.residual[0] for each in audits]))

    return step(
        "bounds",
        "nonlinear",
        inputs,
        BoundedPeak,
        (planned.system, *planned.responses, limits, first.linear.system, free, modes),
        compute,
        pulls=True,
        resumes=True,
        of=planned.case.name,
    )


def high_end(planned: Planned, bounds: Step[BoundedPeak]) -> Planned:
    """The case with the sliders of its largest peak, of which its response is the only point."""

    def slid(system: System, bounded: BoundedPeak) -> System:
        assert bounded.found is not None
        return bounded.found.system_at(system, HIGH)

    def top(bounded: BoundedPeak) -> Response:
        assert bounded.found is not None
        return bounded.found.response.at([HIGH])

    base = planned.system
    system = step("system", "rom", {"end": HIGH}, System, (base, bounds), slid, False, True)
    response = step("response", "nonlinear", {"end": HIGH}, Response, (bounds,), top, False, True)
    return planned.at_end(system, response)
