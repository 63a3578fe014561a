"""Cost of a point of the nonlinear response, in units of one dense complex solve of the model.

    python benchmarks/solver_cost.py --system results.h5 [--harmonics 1 3 5] [--write]

sweeps the system of a file (of `System.save`, or of a study's results) from micro-slip to gross
slip, upwards and downwards.
"""

import argparse
from typing import NamedTuple

import h5py
import numpy as np
from clock import Curve, Unit, dynamic_stiffness, page, scaled, sweep
from threadpoolctl import threadpool_limits

from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, System, frequency_response


class Regime(NamedTuple):
    """A factor on the force and one on the coefficients of friction, from those of the file."""

    name: str
    force: float
    mu: float


REGIMES = (
    Regime("micro-slip", 0.01, 1.0),
    Regime("strong micro-slip", 0.1, 1.0),
    Regime("slip and opening", 1.0, 1.0),
    Regime("gross slip, small μ", 1.0, 0.03),
    Regime("gross slip, large force", 30.0, 1.0),
)


def load(path: str) -> System:
    """The system of a file, be it alone there or in the group of a study's results."""
    with h5py.File(path, "r") as file:
        return System.load(file["system"] if "system" in file else file)


def row(regime: Regime, harmonics: int, direction: str, curve: Curve) -> str:
    """One line of the table."""
    response, cost = curve.response, curve.units
    sliding = np.isin(response.state, (SLIP, SLIP_OPEN)).sum(axis=1)
    opening = np.isin(response.state, (OPEN, SLIP_OPEN)).sum(axis=1)
    total = curve.setup + curve.seconds.sum()
    return (
        f"| {harmonics} | {regime.name} | {direction} | "
        f"{np.count_nonzero(response.converged)} / {response.points} | "
        f"{np.median(cost):.3f} | {cost.mean():.3f} | {cost.max():.1f} | "
        f"{np.median(response.iterations):.0f} | {sliding.max()} | {opening.max()} | "
        f"{total / curve.unit:.0f} | {total:.2f} s |"
    )


def vane(
    path: str, harmonics: list[int], low: float, high: float, points: int, only: str
) -> list[str]:
    """Lines of the report on the system of a file."""
    system = load(path)
    hertz = np.linspace(low, high, points)
    unit = Unit(dynamic_stiffness(system, 0.5 * (low + high)))
    for _ in range(5):
        unit.sample()
    frequency_response(scaled(system, 0.01), hertz[:2], harmonics[0])  # kernels are compiled here
    size, contacts = len(unit.matrix), system.contacts.count
    lines = [
        f"A system of {size} coordinates a nodal diameter and {contacts} contacts; {points}",
        f"frequencies from {low:g} to {high:g} Hz, closed list. Force and friction are scaled:",
        "; ".join(f"{r.name}: force × {r.force:g}, μ × {r.mu:g}" for r in REGIMES) + ".",
        "",
        "Median, mean, worst: CPU of a point after the first one, in units of one dense complex",
        "solve. Steps: median of Newton's. Slip, open: most contacts that slip, or open, at any",
        "point. Curve: the whole call, set-up and recovery included, in units and CPU seconds.",
        "",
        "| H | regime | direction | converged | median | mean | worst | steps | slip | open |"
        " curve | curve |",
        "|---:|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    print("\n".join(lines), flush=True)
    for H in harmonics:
        for regime in REGIMES:
            if only and only not in regime.name:
                continue
            changed = scaled(system, regime.force, regime.mu)
            for direction in ("up", "down"):
                curve = sweep(changed, hertz, H, unit, direction=direction)
                lines.append(row(regime, H, direction, curve))
                print(lines[-1], flush=True)
    return [*lines, "", f"The unit took {1e3 * unit.time():.1f} ms of CPU here (median)."]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system")
    parser.add_argument("--harmonics", type=int, nargs="+", default=[1, 3, 5])
    parser.add_argument("--points", type=int, default=100)
    parser.add_argument("--low", type=float, default=245.0, help="Hz")
    parser.add_argument("--high", type=float, default=300.0, help="Hz")
    parser.add_argument("--only", default="", help="regimes whose name contains this")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    with threadpool_limits(limits=1):
        lines = vane(
            options.system,
            options.harmonics,
            options.low,
            options.high,
            options.points,
            options.only,
        )
    page("solver_cost_vane", "Cost of a point of the nonlinear response", lines, options.write)


if __name__ == "__main__":
    main()
