"""What the gradient of a peak costs, by all parameters together, in Newton steps at that peak.

    python -m benchmarks.solver.peak_gradient [--system file.h5] [--quick] [--write]

The system is one of `System.save`. Without one, the vane of examples/vane.toml is meshed and
reduced.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.clock import scaled
from benchmarks.pages import page
from benchmarks.solver.cyclic import natural
from benchmarks.solver.mistuned_rings import small, vane
from vanelock.nonlinear import (
    AmplitudeGradient,
    Options,
    System,
    amplitude_gradient,
    frequency_response,
    harmonic_modes,
    peak_gradient_of,
)
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.newton.newton import solve
from vanelock.nonlinear.peaks.amplitude_gradient import prepared_again

HARMONICS = (1, 3, 5)
FORCES = (0.1, 1.0)
REPEATS = 15
ASIDE = 0.2  # of the peak's half-width, at which steps are timed
HEADER = (
    "| force | H | peak, µm | unknowns | gradient, ms | step, ms | ratio | first, ms | ratio |",
    "|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
)
ABOUT = """
The amplitude's gradient of {name} at its peak: by the excitation, the loads at rest, modal damping,
interference, friction and the three springs of every contact, one thread. A Newton step: CPU time
of the balance {aside:g} half-widths from the peak, solved from the peak, over its steps; with the
preconditioner that the peak's solution leaves, and with none known, as at the first frequency of
all. Up to 150 unknowns are solved directly either way. Medians of {repeats}, taken in turns.
"""


def seconds(compute: Callable[[], object]) -> float:
    """CPU time."""
    begin = time.process_time()
    compute()
    return time.process_time() - begin


def whole(gradient: AmplitudeGradient | None) -> None:
    """Every parameter's share."""
    assert gradient is not None
    gradient.by_force(), gradient.by_rest_force(), gradient.by_damping()
    gradient.by_interference(), gradient.by_friction(), gradient.by_contact_stiffness()


def row(system: System, limits: tuple[float, float], force: float, harmonics: int) -> str:
    """One line of the table."""
    modes = harmonic_modes(system, harmonics).diameters
    options = Options(harmonics)
    hertz = np.linspace(*limits, 81)
    response = frequency_response(system, hertz, options, find_jumps=False, modes=modes)
    size = response.amplitude[:, 0]
    direction = int(size.max(axis=0).argmax())
    point, component = int(size[:, direction].argmax()), (0, direction)
    output = system.output_names[0], direction
    width = 2 * float(hertz[1] - hertz[0])
    found = peak_gradient_of(system, response, point, output, width, modes)
    ready = prepared_again(system, response.at([point]), modes)
    solution, family = found.peak.solution, ready.solver.family
    beside = solution.omega + ASIDE * found.peak.width
    gradients, kept, fresh = [], [], []
    for _ in range(REPEATS):
        gradients.append(seconds(lambda: whole(amplitude_gradient(ready, solution, component))))
        for steps, known in ((kept, solution.reuse), (fresh, None)):
            begin = time.process_time()
            held = fixed(family.at(beside), family.friction)
            again = solve(held, solution.w, 0.0, reuse=known)
            assert again.converged
            steps.append((time.process_time() - begin) / again.iterations)
    unknowns = int((solution.w != 0).sum())
    cost, near, alone = (1e3 * float(np.median(each)) for each in (gradients, kept, fresh))
    return (
        f"| × {force:g} | {harmonics} | {1e6 * found.amplitude:.4g} | {unknowns} | {cost:.3g} | "
        f"{near:.3g} | {cost / near:.2f} | {alone:.3g} | {cost / alone:.2f} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system; the default vane if not given")
    parser.add_argument("--size", default="medium", help="mesh of the default vane")
    parser.add_argument("--low", type=float, default=240.0, help="where the peak lies, Hz")
    parser.add_argument("--high", type=float, default=280.0)
    parser.add_argument("--quick", action="store_true", help="a small random ring alone")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    with threadpool_limits(limits=1):
        system = small()
        around = (0.9 * natural(system), 1.1 * natural(system))
        lines = [row(system, around, 1.0, 1)]  # compiles kernels
        if options.quick:
            print("\n".join([*HEADER, *lines]))
            return
        system = System.load(options.system) if options.system else vane(options.size)
        print("\n".join(HEADER), flush=True)
        lines = []
        for force in FORCES:
            for harmonics in HARMONICS:
                limits = (options.low, options.high)
                lines.append(row(scaled(system, force), limits, force, harmonics))
                print(lines[-1], flush=True)
    about = ABOUT.strip().format(name="the default vane", aside=ASIDE, repeats=REPEATS)
    page("peak_gradient", "Gradient of a peak", [about, "", *HEADER, *lines], options.write)


if __name__ == "__main__":
    main()
