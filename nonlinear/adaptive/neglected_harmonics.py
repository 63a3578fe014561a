"""What neglected harmonics are worth at a point that was solved without estimates."""

from dataclasses import replace

import numpy as np

from vanelock.nonlinear.adaptive.error_estimates import BEYOND, SOURCES, Estimator, half
from vanelock.nonlinear.adaptive.harmonic_levels import HarmonicLevels
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response, chosen_points
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, resized, to_real
from vanelock.nonlinear.newton.newton import solve
from vanelock.rom.system.system import System

SMALL = 0.02
"""Relative change that first order is trusted with: near a fold a step may be of any length."""


@one_thread
def neglected_harmonics(
    system: System,
    response: Response,
    point: int,
    output: tuple[int, int],
    harmonic_diameters: str = "wave",
) -> float:
    """Relative error of an amplitude by the harmonics above H.

    Of a Newton step towards the balance with H + 2 where that changes the amplitude by little, else
    of its solution. Nodal diameters of the further harmonics that the system lacks take the nearest
    one's matrices.

    Parameters
    ----------
    system : System
        The response's.
    response : Response
    point : int
        Which of its frequencies.
    output : (int, int)
        Place of the output node, and direction.
    harmonic_diameters : {"wave", "sector"}
        As of `Options`.

    Returns
    -------
    float
        NaN where the point has not converged, or does not as the system's own, or with H + 2.

    Raises
    ------
    InputError
        If the point does not exist.
    """
    (point,) = chosen_points(response, [point])
    options = Options(
        response.harmonics,
        response.coupling,
        response.friction,
        harmonic_diameters,
        samples=response.samples or None,
    )
    if not response.converged[point] or not response.harmonics:
        return float("nan")
    omega = TURN * float(response.frequency[point])
    levels = HarmonicLevels(lambda _: system, (omega, omega), options)
    family = levels.solver(response.harmonics).family
    begin = to_real(response.contact[point] - response.force[point] / response.stiffness)
    held = fixed(family.at(omega), family.friction)
    found = solve(held, begin, 0.0, tolerance=options.tolerance, kept=None)
    if not found.converged:
        return float("nan")
    estimator, more = Estimator(levels, output), response.harmonics + BEYOND
    estimate = estimator.estimate(replace(found, parameter=omega), response.harmonics)
    change = estimate.change[SOURCES.index("harmonics")]
    if not abs(change) <= SMALL * estimate.amplitude:
        wide, start = levels.guessing(more), resized(found.w, more)
        held = fixed(wide.at(omega), wide.friction)
        again = solve(held, start, 0.0, tolerance=options.tolerance, kept=None)
        reached = half(estimator.output(wide.structure, omega, again.w))
        change = reached - estimate.amplitude if again.converged else np.nan
    return float(np.abs(change) / estimate.amplitude) if estimate.amplitude > 0 else float("nan")
