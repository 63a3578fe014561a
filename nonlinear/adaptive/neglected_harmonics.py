"""What neglected harmonics are worth at a point that was solved without estimates."""

from dataclasses import replace

import numpy as np

from vanelock.nonlinear.adaptive.error_estimates import SOURCES, Estimator
from vanelock.nonlinear.adaptive.harmonic_levels import HarmonicLevels
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response, chosen_points
from vanelock.nonlinear.fourier.threads import one_thread
from vanelock.nonlinear.fourier.trigonometric import TURN, to_real
from vanelock.nonlinear.newton.newton import solve
from vanelock.rom.system.system import System


@one_thread
def neglected_harmonics(
    system: System,
    response: Response,
    point: int,
    output: tuple[int, int],
    harmonic_diameters: str = "wave",
) -> float:
    """Relative error of an amplitude by the harmonics above H, to first order.

    Of a Newton step towards the balance with H + 2. Nodal diameters of the further harmonics that
    the system lacks take the nearest one's matrices.

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
        NaN where the point has not converged, or does not as the system's own.

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
    estimate = Estimator(levels, output).estimate(
        replace(found, parameter=omega), response.harmonics
    )
    change = estimate.change[SOURCES.index("harmonics")]
    return float(np.abs(change) / estimate.amplitude) if estimate.amplitude > 0 else float("nan")
