"""What neglected harmonics are worth at the peak of a case without an accuracy."""

from dataclasses import dataclass

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.plan import Planned
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.summary import peak_of


@dataclass(frozen=True)
class NeglectedHarmonics(Product):
    """Relative error of a peak's amplitude by neglected harmonics; NaN where it is not known."""

    amplitude: float


def neglected_harmonics_step(planned: Planned) -> Step[NeglectedHarmonics]:
    """The estimate, of the peak of a case's response."""
    wanted = planned.case.given.outputs.monitor

    def compute(
        system: System, response: Response, linear: System, free: Response
    ) -> NeglectedHarmonics:
        watched = monitor(wanted, linear, free)
        peak = peak_of(response, watched.amplitude(response))
        if peak is None:
            return NeglectedHarmonics(float("nan"))
        output = watched.node, watched.component
        return NeglectedHarmonics(
            nonlinear.neglected_harmonics(system, response, peak.point, output)
        )

    linear = planned.linear
    needs = (planned.system, planned.response, linear.system, linear.responses["free"])
    inputs = {"monitor": wanted}
    return step(
        "neglected harmonics, peak", "nonlinear", inputs, NeglectedHarmonics, needs, compute
    )
