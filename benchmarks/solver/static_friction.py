"""What undetermined static friction does to the vane's peak, and what finding it costs.

    python -m benchmarks.solver.static_friction [--system file.h5] [--quick] [--write]

The system is one of `System.save`; without one, the vane of examples/vane.toml is meshed and
reduced. Costs are CPU time over that of one dense complex solve, and of one swept curve over the
same range, both taken in between.
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from benchmarks.clock import Unit, dynamic_stiffness
from benchmarks.pages import page
from benchmarks.solver.mistuned_rings import vane
from vanelock.nonlinear import (
    Options,
    System,
    audit_response,
    frequency_response,
    harmonic_modes,
    peak_bounds,
    static_bounds,
)

JOINT = "interlock"
HEAD = [
    "| mu | H | share | between | um | Hz | interlock at rest, N | points | curves | audited |",
    "|---:|---:|---:|---|---|---|---|---:|---:|---:|",
]


def with_friction(system: System, mu: float) -> System:
    """The system with another coefficient in its interlock."""
    slips = np.array(system.contacts.joint) == JOINT
    return replace(
        system, contacts=replace(system.contacts, mu=np.where(slips, mu, system.contacts.mu))
    )


def three(values: np.ndarray, digits: int) -> str:
    """Least, at zero and largest."""
    return " / ".join(f"{value:.{digits}f}" for value in values)


def row(system: System, mu: float, harmonics: int, share: float, near: tuple[float, float]) -> str:
    """One search, its ends audited."""
    options = Options(harmonics)
    modes = harmonic_modes(system, harmonics).diameters
    spent = []
    for _ in range(2):
        begin = time.process_time()
        frequency_response(system, near, options, modes=modes, find_jumps=False)
        spent.append(time.process_time() - begin)
    begin = time.process_time()
    found = peak_bounds(system, near, options, share=share, modes=modes)
    cost = (time.process_time() - begin) / min(spent)
    ratio = found.amplitude / found.amplitude[1]
    residual = max(
        audit_response(found.system_at(system, i), found.response.at([i])).residual[0]
        for i in range(3)
    )
    load = found.rest_load[:, found.joints.index(JOINT)]
    return (
        f"| {mu:g} | {harmonics} | {share:g} | x {ratio[0]:.3f} ... {ratio[2]:.3f} "
        f"| {three(1e6 * found.amplitude, 2)} | {three(found.frequency, 1)} | {three(load, 1)} "
        f"| {found.solved} | {cost:.0f} | {residual:.0e} |"
    )


def rest(system: System) -> str:
    """Bounds of the load at rest, and their cost."""
    modes = harmonic_modes(system, 0).diameters
    unit = Unit(dynamic_stiffness(system, 250.0))
    spent = []
    for _ in range(5):
        unit.sample()
        begin = time.process_time()
        found = static_bounds(system, JOINT, modes=modes)
        spent.append(time.process_time() - begin)
    low, nominal, high = found.rest_load[0]
    cost = np.median(spent) / np.median(unit.seconds)
    return (
        f"At rest static friction can hold the interlock at {low:.1f} to {high:.1f} N a sector "
        f"({nominal:.1f} N with all sliders assembled at zero); finding that takes {cost:.0f} "
        "dense complex solves."
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system; the default vane if not given")
    parser.add_argument("--size", default="medium", help="mesh of the default vane")
    parser.add_argument("--low", type=float, default=235.0, help="Hz")
    parser.add_argument("--high", type=float, default=300.0, help="Hz")
    parser.add_argument("--quick", action="store_true", help="H = 1, one share")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    system = System.load(options.system) if options.system else vane(options.size)
    near = (options.low, options.high)
    lines = [
        f"A vane's system of {len(system.at(1).K)} coordinates and {system.contacts.count} "
        f"contacts, damping of the structure with joints {system.damping_joints}, {near[0]:g} to "
        f"{near[1]:g} Hz. Least peak, that with all sliders "
        "assembled at zero, and largest; share: that of Coulomb's limit by which friction at rest "
        "may differ. Curves: CPU time of the search over that of one swept curve; points: "
        "frequencies solved; audited: residual of an independent check.",
        "",
        *HEAD,
    ]
    print("\n".join(lines))
    for mu in (0.15, 0.3):
        for share in (1.0,) if options.quick else (0.1, 0.3, 1.0):
            harmonics = 1 if options.quick else 3
            lines.append(row(with_friction(system, mu), mu, harmonics, share, near))
            print(lines[-1], flush=True)
    lines += ["", rest(with_friction(system, 0.3))]
    print("\n".join(lines[-2:]))
    page("static_friction", "Peaks that static friction allows", lines, options.write)


if __name__ == "__main__":
    main()
