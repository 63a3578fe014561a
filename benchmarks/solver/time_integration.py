"""A steady response by harmonic balance of one sector, and by integrating the whole ring in time.

    python -m benchmarks.solver.time_integration [--quick] [--write]

Both errors are measured against an integration with very small steps; costs are compared at equal
error.
"""

import argparse
import time
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.pages import page
from benchmarks.solver.cyclic import natural, ring
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Options,
    System,
    TimeResponse,
    frequency_response,
    time_response,
)

Array = NDArray[np.complex128]
Result = TypeVar("Result")


class Case(NamedTuple):
    """A ring in which every contact slips: the steady vibration is then one and no other."""

    name: str
    size: int
    contacts: int
    sectors: int
    mu: float
    severity: float
    seed: int


CASES = (
    Case("gross slip", 12, 4, 5, 0.05, 60.0, 1),
    Case("opening", 12, 4, 5, 0.3, 60.0, 0),
    Case("opening", 40, 6, 8, 0.3, 60.0, 1),
)
HARMONICS = (1, 3, 5, 9, 15)
STEPS = (64, 128, 256, 512)
KEPT = 9  # harmonics that are compared


def timed(run: Callable[[], Result]) -> tuple[Result, float]:
    """What a call returns, and its CPU seconds."""
    begin = time.process_time()
    result = run()
    return result, time.process_time() - begin


def peak(system: System) -> tuple[float, float]:
    """Frequency, Hz, of the peak with friction among those where all contacts slip, and a step."""
    top = natural(system)
    hertz = np.linspace(0.6 * top, 1.05 * top, 91)
    response = frequency_response(system, hertz, Options(3))
    slips = np.isin(response.state, (SLIP, SLIP_OPEN)).all(axis=1)
    moved = np.where(slips, np.abs(response.contact[:, 1]).max(axis=(1, 2)), 0.0)
    return float(hertz[int(moved.argmax())]), float(hertz[1] - hertz[0])


def padded(q: Array) -> Array:
    """Coefficients (KEPT + 1, c, 3), those that a balance leaves out zero."""
    full = np.zeros((KEPT + 1, *q.shape[1:]), complex)
    full[: len(q)] = q[: KEPT + 1]
    return full


def deviation(q: Array, exact: Array) -> float:
    """Largest difference, the mean included, relative to the largest coefficient at h >= 1."""
    return float(np.abs(padded(q) - exact).max() / np.abs(exact[1:]).max())


def at_error(error: float, errors: list[float], seconds: list[float]) -> float:
    """CPU of the integration for an error: of second order in the step through all its runs.

    Not less than the coarsest run's.
    """
    scale = np.exp(np.mean(np.log(seconds) + 0.5 * np.log(errors)))
    return float(max(scale / np.sqrt(error), min(seconds)))


def rows(case: Case, harmonics: tuple[int, ...], steps: tuple[int, ...], fine: int) -> list[str]:
    """Lines of the table for one ring."""
    system = ring(
        case.size, case.contacts, KEPT, case.mu, case.severity, case.sectors, seed=case.seed
    )
    hertz, apart = peak(system)
    rich = frequency_response(system, [hertz], Options(31))
    reference = time_response(system, hertz, 30, fine, KEPT, start=(rich, 0))
    exact = reference.contact[:, 0]
    head = f"| {case.name}, {case.sectors} × {case.size}, {case.contacts} contacts |"
    lines, errors, seconds = [], [], []
    for count in steps:

        def integrate(count: int = count) -> TimeResponse:
            tolerance = 1e-2 * 2e-3 * (128 / count) ** 2
            return time_response(system, hertz, 1000, count, KEPT, tolerance=tolerance)

        found, spent = timed(integrate)
        errors.append(deviation(found.contact[:, 0], exact))
        seconds.append(spent)
        lines.append(
            f"{head} integration, {count} steps | {len(found.defect)} periods | "
            f"{errors[-1]:.1e} | {1e3 * spent:.0f} ms | |"
        )
        print(lines[-1], flush=True)
    for H in harmonics:
        near = hertz + apart / 4 * np.arange(-8, 9)
        marks: list[float] = []

        def progress(*given: float, marks: list[float] = marks) -> None:
            if given[3] == given[3]:  # a point that is done, not one that is looked for
                marks.append(time.process_time())

        response = frequency_response(system, near, Options(H), progress=progress)
        point = float(np.mean(np.diff(marks)))
        error = deviation(response.contact[8], exact)
        lost = np.count_nonzero(~response.converged)
        ratio = at_error(error, errors, seconds) / point
        lines.append(
            f"{head} balance, H = {H} | {len(near) - lost} / {len(near)} converged | {error:.1e} | "
            f"{1e3 * point:.1f} ms | {ratio:.0f} |"
        )
        print(lines[-1], flush=True)
    return lines


HEADER = ("| ring | method | | error | CPU | ratio |", "|---|---|---|---:|---:|---:|")
ABOUT = """
CPU of one steady response at the peak, one thread: `time_response` of the whole ring from the
state in which every contact sticks until it is periodic to a hundredth of its error; and
`frequency_response` of one sector, the mean of a point of a curve across the peak. Errors: of the
contacts' displacements in harmonics 0 to 9, those that a balance leaves out included, relative to
the largest, against an integration with 4096 steps a period started from the balance with H = 31,
whose own error is near 2e-6. Ratio: CPU of the integration at the balance's error (its runs, taken
as of second order; at least the coarsest) over that of the balance. Rings are random ones whose
modes spread like a vane's, damping ratio 0.003, sectors × coordinates; some, whose wave is
not stable, settle to a motion that no balance of one sector describes, and are not compared.
"""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one small ring, few runs")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    print("\n".join(HEADER), flush=True)
    lines = []
    with threadpool_limits(limits=1):
        first = CASES[0]
        quick = rows(first, (1,), (64, 128), 256)  # kernels are compiled here
        if options.quick:
            lines = quick
        else:
            for case in CASES:
                lines += rows(case, HARMONICS, STEPS, 4096)
    text = [ABOUT.strip(), "", *HEADER, *lines]
    page("time_integration", "Harmonic balance against time integration", text, options.write)


if __name__ == "__main__":
    main()
