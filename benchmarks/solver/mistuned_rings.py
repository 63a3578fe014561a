"""Mistuned rings: what a point costs beside a tuned one, and how far rings are amplified.

    python -m benchmarks.solver.mistuned_rings [--system file.h5] [--rings 50] [--quick] [--write]

The system, of `System.save`, must have all nodal diameters of its ring. Without one, the vane of
examples/vane.toml is meshed and reduced.
"""

import argparse
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks import segment
from benchmarks.clock import scaled
from benchmarks.pages import page
from benchmarks.solver.cyclic import natural, ring
from vanelock import rom
from vanelock.nonlinear import (
    Mistuning,
    Options,
    System,
    frequency_response,
    harmonic_modes,
    ring_response,
    whitehead,
)
from vanelock.stages.parts.segment import Segment

AROUND = 0.01  # of the peak's frequency, to either side
PERCENTILES = (5, 50, 95)
DEVIATIONS = {
    "interference 1 %": {"interference": 0.01},
    "interference 1 %, kn and kt 5 %": {"interference": 0.01, "kn": 0.05, "kt": 0.05},
    "interference and μ 5 %": {"interference": 0.05, "mu": 0.05},
}
FIRST, STIFFNESS, FRICTION = DEVIATIONS
LINES = (  # factor on the default force, what deviates, share of the rings
    (0.1, FIRST, 1.0),
    (1.0, FIRST, 1.0),
    (1.0, STIFFNESS, 0.1),
    (0.1, FRICTION, 1.0),
)
HEADER = (
    "| force | deviate | rings | points | converged | tuned points a point | a sector | steps |"
    " amplification 5 % | 50 % | 95 % | largest |",
    "|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
)
ABOUT = """
Rings of {name}, drawn at random: one normal deviation for every sector, joint and quantity, of the
same standard deviation at all joints. Force: a factor on the default study's. Points are those that
`ring_response` chooses within 1 % of the tuned ring's peak, H = 3, one thread. A point's cost is
its median CPU time, in tuned points: the median CPU time of `frequency_response` in the same range.
A sector: that over the number of sectors. Amplification: the largest vibration of any sector's
first output in any direction, over all frequencies, relative to the tuned ring's; its percentiles
over the rings drawn. One linear mode a sector, without friction, could reach {bound:.2f}
(Whitehead, 1966).
"""


def vane(size: str) -> System:
    """The ring of the default vane under the default force, mu 0.15."""
    vane = rom.reduce(segment.vane_model(size), segment.VANE_MASTERS)
    diameters = range(9)
    casing = rom.reduce(
        segment.casing_model(size),
        segment.CASING_MASTERS,
        nodal_diameters=diameters,
        band=vane.band,
    )
    return Segment(segment.JOINTS, 1, 30.0, damping_ratio=0.003).join(vane, casing)


def small() -> System:
    """A random ring whose first three coordinates are an output."""
    system = ring(12, 3, 8, severity=30.0)
    output = np.eye(12)[None, :3]
    diameters = {k: replace(matrices, output=output) for k, matrices in system.diameters.items()}
    return replace(system, diameters=diameters, output_names=("first",))


def row(system: System, limits: tuple[float, float], name: str, force: float, rings: int) -> str:
    """One line of the table."""
    modes = harmonic_modes(system, system.sectors).diameters
    options = Options(3)
    wide = frequency_response(system, limits, options, find_jumps=False, modes=modes)
    peak = wide.frequency[wide.amplitude[:, 0].max(axis=1).argmax()]
    near = ((1 - AROUND) * peak, (1 + AROUND) * peak)
    tuned = frequency_response(system, near, options, find_jumps=False, modes=modes)
    joints = sorted(set(system.contacts.joints))
    ratios, seconds, steps, converged = [], [], [], []
    for seed in range(rings):
        mistuning = Mistuning.scatter(system, dict.fromkeys(joints, DEVIATIONS[name]), seed)
        found = ring_response(system, near, mistuning, options, modes=modes)
        largest = found.amplitude[found.converged][:, :, 0].max()
        ratios.append(largest / found.alike[0].max())
        seconds += found.seconds[1:].tolist()
        steps += found.iterations.tolist()
        converged += found.converged.tolist()
    cost = np.median(seconds) / np.median(tuned.seconds[1:])
    shares = " | ".join(f"{each:.4f}" for each in np.percentile(ratios, PERCENTILES))
    return (
        f"| × {force:g} | {name} | {rings} | {len(converged)} | {sum(converged)} | {cost:.1f} | "
        f"{cost / system.sectors:.2f} | {np.mean(steps):.1f} | {shares} | {max(ratios):.4f} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system; the default vane if not given")
    parser.add_argument("--size", default="medium", help="mesh of the default vane")
    parser.add_argument("--low", type=float, default=250.0, help="where peaks lie, Hz")
    parser.add_argument("--high", type=float, default=275.0)
    parser.add_argument("--rings", type=int, default=50)
    parser.add_argument("--quick", action="store_true", help="two small random rings a line")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    with threadpool_limits(limits=1):
        system = small()
        around = (0.9 * natural(system), 1.1 * natural(system))
        lines = [row(system, around, name, 1.0, 2) for name in DEVIATIONS]  # compiles kernels
        if options.quick:
            print("\n".join([*HEADER, *lines]))
            return
        system = System.load(options.system) if options.system else vane(options.size)
        limits, lines = (options.low, options.high), []
        about = ABOUT.strip().format(
            name=f"{system.sectors} segments", bound=whitehead(system.sectors)
        )
        print("\n".join(HEADER), flush=True)
        for force, name, share in LINES:
            rings = max(1, round(share * options.rings))
            lines.append(row(scaled(system, force), limits, name, force, rings))
            print(lines[-1], flush=True)
            report = [about, "", *HEADER, *lines]
            page("mistuned_rings", "Mistuned rings", report, options.write)


if __name__ == "__main__":
    main()
