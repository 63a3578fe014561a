"""Cost of a point of the nonlinear response, in units of one dense complex solve of the model.

    python -m benchmarks.solver.cost --system vane [--harmonics 1 3 5] [--write]

sweeps the default vane, or the system of a file (of `System.save`, or of a study's results) from
micro-slip to gross slip, upwards and downwards. Without a file,

    python -m benchmarks.solver.cost [--quick] [--write]

varies harmonics, contacts, size of the model, samples and friction of random cyclic systems
(`cyclic.py`).
"""

import argparse
from dataclasses import replace
from typing import NamedTuple

import h5py
import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.clock import Curve, Floats, Unit, dynamic_stiffness, scaled, sweep
from benchmarks.pages import page
from benchmarks.solver import mistuned_rings
from benchmarks.solver.cyclic import natural, ring
from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, Options, System, frequency_response
from vanelock.nonlinear.balance.balance import structure


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
    """The default vane's system, or that of a file: alone there, or in a study's results."""
    if path == "vane":
        return mistuned_rings.vane("medium")
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
    # Kernels are compiled here.
    frequency_response(scaled(system, 0.01), hertz[:2], Options(harmonics[0]))
    size, contacts = len(unit.matrix), system.contacts.count
    lines = [
        f"A system of {size} coordinates a nodal diameter and {contacts} contacts; {points}",
        f"frequencies from {low:g} to {high:g} Hz, closed list. Force and friction: those",
        "of the file by the factors:",
        "",
        *(f"- {r.name}: force × {r.force:g}, μ × {r.mu:g}" for r in REGIMES),
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
                curve = sweep(changed, hertz, Options(H, direction=direction), unit)
                lines.append(row(regime, H, direction, curve))
                print(lines[-1], flush=True)
    return [*lines, "", f"The unit took {1e3 * unit.time():.1f} ms of CPU here (median)."]


class Drawn(NamedTuple):
    """Size of a random system, and what is asked of it."""

    size: int = 250
    contacts: int = 30
    harmonics: int = 3
    samples: int | None = None
    friction: str = "orthogonal"
    even: bool = False  # as stiff in both tangential directions


# Name, coefficient of friction, severity (see `cyclic.ring`).
DRAWN_REGIMES = (
    ("micro-slip", 0.3, 1.5),
    ("gross slip, small μ", 0.01, 60.0),
    ("gross slip, large force", 0.3, 60.0),
)
VARIED = {
    "harmonics": (1, 3, 5, 7, 9),
    "contacts": (5, 20, 66, 200),
    "size": (50, 100, 250, 500, 1000),
    "samples": (64, 128, 256, 1024, None),
    "friction": ("orthogonal", "isotropic"),
}
VARIED_QUICK = {"harmonics": (1,), "samples": (64, None)}
BASES = {"contacts": Drawn(size=500, harmonics=1), "friction": Drawn(even=True)}
RICH = 15  # harmonics of the reference
LARGE, MANY = 1650, (66, 129, 258, 516)  # coordinates and contacts of the table of growth


def truncation(curve: Curve, rich: Curve) -> float:
    """Largest difference of the contacts' displacements from the reference, all its harmonics."""
    a, b = curve.response.contact, rich.response.contact
    full = np.zeros_like(b)
    full[:, : a.shape[1]] = a[:, : b.shape[1]]
    return float(np.abs(full - b).max() / np.abs(b[:, 1:]).max())


def measure(drawn: Drawn, mu: float, severity: float, points: int) -> Curve:
    """One curve around the resonance of a random system."""
    system = ring(drawn.size, drawn.contacts, max(drawn.harmonics, 3), mu, severity)
    if drawn.even:
        kt = system.contacts.kt[:, [0, 0]]
        system = replace(system, contacts=replace(system.contacts, kt=kt))
    top = natural(system)
    unit = Unit(dynamic_stiffness(system, top))
    hertz = np.linspace(0.8 * top, 1.05 * top, points)
    asked = Options(drawn.harmonics, friction=drawn.friction, samples=drawn.samples)
    return sweep(system, hertz, asked, unit)


def varied(name: str, values: tuple[int | str | None, ...], base: Drawn, points: int) -> list[str]:
    """One table: one number varied, three regimes."""
    error = {"harmonics": f"H = {RICH}", "samples": "located events"}.get(name)
    last = f" error against {error} |" if error else ""
    lines = [
        f"| {name} | regime | median | mean | slip | open | converged | unit |{last}",
        "|---:|---|" + "---:|" * (7 if error else 6),
    ]
    print("\n".join(lines), flush=True)
    for regime, mu, severity in DRAWN_REGIMES:
        rich = base._replace(harmonics=RICH) if name == "harmonics" else base
        reference = measure(rich, mu, severity, points) if error else None
        for value in values:
            curve = measure(base._replace(**{name: value}), mu, severity, points)
            response, cost = curve.response, curve.units
            most = [
                np.isin(response.state, states).sum(axis=1).max()
                for states in ((SLIP, SLIP_OPEN), (OPEN, SLIP_OPEN))
            ]
            lines.append(
                f"| {'located' if value is None else value} | {regime} | "
                f"{np.median(cost):.2f} | {cost.mean():.2f} | {most[0]} | {most[1]} | "
                f"{np.count_nonzero(response.converged)} / {points} | {1e3 * curve.unit:.1f} ms |"
                + (f" {truncation(curve, reference):.0e} |" if reference else "")
            )
            print(lines[-1], flush=True)
    return [*lines, ""]


def growth(counts: tuple[int, ...], size: int, harmonics: int, points: int) -> list[str]:
    """A table over contacts of one large model, with exponents of growth from row to row."""
    names = [name for name, _, _ in DRAWN_REGIMES]
    lines = [
        "| contacts | regime | median | exponent | mean | exponent | slip | open | converged |"
        " unit |",
        "|---:|---|" + "---:|" * 8,
    ]
    print("\n".join(lines), flush=True)
    found: dict[str, list[str]] = {name: [] for name in names}
    last: dict[str, Floats] = {}
    for place, count in enumerate(counts):
        drawn = ring(size, count, max(harmonics, 3), 1.0, 1.0)
        top = natural(drawn)
        unit = Unit(dynamic_stiffness(drawn, top))
        hertz = np.linspace(0.8 * top, 1.05 * top, points)
        modes = structure(drawn, harmonics).modes
        for name, mu, severity in DRAWN_REGIMES:
            system = scaled(drawn, severity * mu, mu)
            curve = sweep(system, hertz, Options(harmonics), unit, modes=modes)
            state, cost = curve.response.state, curve.units
            slip, open_ = (
                np.isin(state, states).sum(axis=1).max()
                for states in ((SLIP, SLIP_OPEN), (OPEN, SLIP_OPEN))
            )
            now = np.array([np.median(cost), cost.mean()])
            shown = ["", ""]
            if place:
                exponents = np.log(now / last[name]) / np.log(count / counts[place - 1])
                shown = [f"{exponent:.2f}" for exponent in exponents]
            last[name] = now
            found[name].append(
                f"| {count} | {name} | {np.median(cost):.3f} | {shown[0]} | {cost.mean():.3f} | "
                f"{shown[1]} | {slip} | {open_} | "
                f"{np.count_nonzero(curve.response.converged)} / {points} | "
                f"{1e3 * curve.unit:.0f} ms |"
            )
            print(found[name][-1], flush=True)
    return [*lines, *(line for name in names for line in found[name]), ""]


def scaling(quick: bool, only: str) -> list[str]:
    """Lines of the report on random systems, of the tables whose names contain `only`."""
    points = 6 if quick else 20
    base = Drawn(size=40, contacts=4, harmonics=1) if quick else Drawn()
    measure(base, 0.3, 1.0, 2)  # kernels are compiled here
    lines = [
        "CPU of a point after the first one of a curve, in units of one dense complex solve of the",
        "same model, timed between the points. Random cyclic systems whose modes spread like a",
        f"vane's; {points} frequencies from 0.8 to 1.05 of the stuck resonance.",
        "Slip, open: most contacts that slip, or open, at any point. Errors are of the contacts'",
        "displacements, relative to the largest at h >= 1.",
        "",
    ]
    for name, values in (VARIED_QUICK if quick else VARIED).items():
        if only not in name:
            continue
        where = base if quick else BASES.get(name, base)
        lines += [
            f"## {name.capitalize()}",
            "",
            f"{where.size} coordinates, {where.contacts} contacts, H = {where.harmonics}, "
            "but for what varies.",
            "",
            *varied(name, values, where, points),
        ]
    if only not in "large model":
        return lines
    size, counts = (60, (5, 10)) if quick else (LARGE, MANY)
    return [
        *lines,
        "## Contacts of a large model",
        "",
        f"{size} coordinates, H = {base.harmonics}. Exponent: the power of the number of contacts",
        "by which a point's cost grows from the row before; 2 is quadratic.",
        "",
        *growth(counts, size, base.harmonics, points),
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--system", help="file with a system; random ones if not given")
    parser.add_argument("--harmonics", type=int, nargs="+", default=[1, 3, 5])
    parser.add_argument("--points", type=int, default=100)
    parser.add_argument("--low", type=float, default=245.0, help="Hz")
    parser.add_argument("--high", type=float, default=300.0, help="Hz")
    parser.add_argument("--only", default="", help="regimes or tables whose name contains this")
    parser.add_argument("--quick", action="store_true", help="a few small random systems")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    with threadpool_limits(limits=1):
        if options.system is None:
            title = "Cost of a point against harmonics, contacts, size, samples and friction"
            page("solver_cost", title, scaling(options.quick, options.only), options.write)
            return
        lines = vane(
            options.system,
            options.harmonics,
            options.low,
            options.high,
            options.points,
            options.only,
        )
        page("solver_cost_vane", "Cost of a point of a vane's response", lines, options.write)


if __name__ == "__main__":
    main()
