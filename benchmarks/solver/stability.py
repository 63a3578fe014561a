"""Cost of telling whether a wave is stable, against following the ring in time.

    python -m benchmarks.solver.stability [--system file.h5] [--hertz 257.77] [--quick] [--write]

The system, of `System.save`, must have all nodal diameters of its ring. Without one, the vane of
examples/vane.toml is meshed and reduced.
"""

import argparse
import time

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.clock import Unit, dynamic_stiffness
from benchmarks.pages import page
from benchmarks.solver.cyclic import natural, ring
from benchmarks.solver.mistuned_rings import vane
from vanelock.nonlinear import (
    STABLE,
    UNDECIDED,
    UNSTABLE,
    Options,
    System,
    frequency_response,
    stability,
    time_response,
)

PERIODS = 50
VERDICTS = {STABLE: "stable", UNSTABLE: "unstable", UNDECIDED: "undecided"}
HEADER = (
    "| H | deviate | largest multiplier | verdict | CPU | dense solves | of 50 periods |",
    "|---:|---:|---:|---|---:|---:|---:|",
)
ABOUT = """
CPU of `stability` at one point, one thread: modes and exponents of all nodal diameters by both
truncations. In units of one dense complex solve of the reduced model, and as a share of 50 periods
of `time_response` with its defaults (512 steps, all modes), of which two are followed. Deviate:
contacts that do not stick where they were assembled.
"""


def rows(system: System, hertz: float, harmonics: tuple[int, ...]) -> list[str]:
    """A line for each number of harmonics."""
    unit = Unit(dynamic_stiffness(system, hertz))
    lines = []
    for H in harmonics:
        response = frequency_response(system, [hertz], Options(H))
        begin = time.process_time()
        found = stability(system, response)
        spent = time.process_time() - begin
        begin = time.process_time()
        time_response(system, hertz, 2, start=(response, 0))
        period = (time.process_time() - begin) / 2
        for _ in range(5):
            unit.sample()
        lines.append(
            f"| {H} | {response.active[0]} | {np.abs(found.multiplier[0, 0]):.3f} | "
            f"{VERDICTS[int(found.verdict[0])]} | {spent:.1f} s | {spent / unit.time():.0f} | "
            f"{spent / (PERIODS * period):.1%} |"
        )
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system; the default vane if not given")
    parser.add_argument("--size", default="medium", help="mesh of the default vane")
    parser.add_argument("--hertz", type=float, help="by default the peak with one harmonic")
    parser.add_argument("--quick", action="store_true", help="a small random ring, one harmonic")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    with threadpool_limits(limits=1):
        small = ring(12, 3, 8, severity=30.0)
        system = System.load(options.system) if options.system else small
        if not (options.quick or options.system):
            system = vane(options.size)
        hertz = options.hertz
        if hertz is None:
            top = natural(system)
            sought = frequency_response(system, np.linspace(0.8 * top, top, 41), Options(1))
            hertz = float(sought.frequency[np.abs(sought.contact[:, 1]).max(axis=(1, 2)).argmax()])
        lines = rows(small, 200.0, (1,))  # kernels are compiled here
        if not options.quick:
            lines = rows(system, hertz, (1, 3, 5))
    print("\n".join([*HEADER, *lines]))
    of = f"Of a vane's ring, damping of the structure with joints {system.damping_joints}"
    lines = [ABOUT.strip(), "", f"{of}, at {hertz:.2f} Hz.", "", *HEADER, *lines]
    page("stability", "Cost of stability", lines, options.write)


if __name__ == "__main__":
    main()
