"""What the vane's frequencies cost in several element families, and what each size is off by.

    python -m benchmarks.mesh.study [--sizes coarse medium paper fine] [--write]

prints the tables; `--write` puts them into docs/benchmarks/mesh_study.md, with a picture.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.mesh.families import CURVED, Row, rows
from benchmarks.mesh.named import Joined, Named, casing_reference, joined, named
from benchmarks.mesh.pictures import errors
from benchmarks.mesh.reference import ORDER, Reference, extrapolated, reference
from benchmarks.mesh.words import INTRODUCTION, JOINED, NAMED, RATES, REFERENCE, conclusion
from benchmarks.pages import FOLDER, page
from benchmarks.segment import CASES
from vanelock.mesh.element_size import SIZES

Floats = NDArray[np.float64]

TARGETS = (0.05, 0.03, 0.02)


def off(row: Row, exact: Floats) -> Floats:
    """Relative errors of a mesh's frequencies."""
    return np.asarray(row.frequency / exact - 1)


def mean(row: Row, exact: Floats) -> float:
    """Mean of the absolute errors of ten frequencies."""
    return float(abs(off(row, exact)).mean())


def by_family(found: list[Row]) -> dict[str, list[Row]]:
    """The meshes of each family, from coarse to fine."""
    return {
        name: [r for r in found if r.family == name]
        for name in dict.fromkeys(r.family for r in found)
    }


def families(found: list[Row], exact: Floats, unit: float) -> list[str]:
    """All meshes, costs in units of one of them."""
    lines = [
        "| elements | size | dofs | entries of K | first | mean of ten | worst "
        "| order | meshing | assembly | factorisation | modes | all but meshing |",
        "|---|" + "---:|" * 12,
    ]
    before: Row | None = None
    for row in found:
        order = ""
        if before and before.family == row.family:
            finer = np.log(before.size / row.size)
            order = f"{np.log(mean(before, exact) / mean(row, exact)) / finer:.1f}"
        before = row
        e = off(row, exact)
        spent = " | ".join(f"{s / unit:.2f}" for s in row.seconds)
        lines.append(
            f"| {row.family} | {row.name} | {row.dofs} | {row.nonzeros / 1e6:.1f} M | "
            f"{e[0]:+.2%} | {mean(row, exact):.2%} | "
            f"{e[np.argmax(abs(e))]:+.2%} | {order} | {spent} | {row.solving / unit:.2f} |"
        )
    return lines


def needed(family: list[Row], exact: Floats, target: float) -> tuple[float, float] | None:
    """Dofs and CPU time at which a family's mean error falls to a target, along straight lines.

    In logarithms, between its meshes; None where the target lies beyond them.
    """
    error = np.array([mean(row, exact) for row in family])
    if not error.min() <= target <= error.max():
        return None
    order = np.argsort(error)
    at = [
        np.exp(np.interp(np.log(target), np.log(error[order]), np.log(np.array(value)[order])))
        for value in ([row.dofs for row in family], [row.solving for row in family])
    ]
    return float(at[0]), float(at[1])


def rates(found: list[Row], exact: Floats) -> list[str]:
    """What each family needs for the same error, as multiples of curved tetrahedra."""
    heads = " | ".join(f"{t:.1%}: dofs | time" for t in TARGETS)
    lines = [f"| mean error | {heads} |", "|---" + "|---:" * 2 * len(TARGETS) + "|"]
    groups = by_family(found)
    for name, group in groups.items():
        cells = []
        for target in TARGETS:
            own, usual = needed(group, exact, target), needed(groups[CURVED], exact, target)
            if own is None:
                cells.append("not reached | " if group[-1].dofs else "")
            elif usual is None:
                cells.append(f"{own[0]:.0f} | {own[1]:.1f} s")
            else:
                ratio = own[0] / usual[0], own[1] / usual[1]
                cells.append(f"{own[0]:.0f} ({ratio[0]:.2f}) | {own[1]:.1f} s ({ratio[1]:.2f})")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


def limits(made: Reference) -> list[str]:
    """The frequencies that errors are relative to."""
    return [
        "| mode | " + " | ".join(f"{k}" for k in range(1, 11)) + " |",
        "|---|" + "---:|" * 10,
        "| limit, Hz | " + " | ".join(f"{f:.1f}" for f in made.frequency) + " |",
        "| order seen | " + " | ".join(f"{p:.2f}" for p in made.order) + " |",
    ]


def sizes(part: str, found: list[Named], exact: Floats) -> list[str]:
    """Curved against straight sides, and long elements along the bands."""
    lines = [
        f"| {part} | dofs | elements | straightened | curved: mean | worst | straight: mean "
        "| worst | time, curved over straight | long band elements: mean | worst |",
        "|---|" + "---:|" * 10,
    ]
    for row in found:
        cells = {}
        for name, frequency in row.frequency.items():
            e = frequency / exact - 1
            cells[name] = f"{abs(e).mean():.2%} | {e[np.argmax(abs(e))]:+.2%}"
        ratio = row.seconds["curved"] / row.seconds["straight"]
        long = cells.get("long", "turned inside out | ")
        lines.append(
            f"| {row.size} | {row.dofs} | {row.elements} | {row.straightened:.1%} | "
            f"{cells['curved']} | {cells['straight']} | {ratio:.2f} | {long} |"
        )
    return lines


def together(found: list[Joined]) -> list[str]:
    """The second frequency of vane and casing joined."""
    heads = " | ".join(f"interlock {case}: Hz | more than the last" for case in CASES)
    lines = [f"| size | vane, dofs | casing, dofs | {heads} |", "|---" + "|---:" * 6 + "|"]
    for row in found:
        cells = " | ".join(
            f"{f:.2f} | {f / found[-1].second[case] - 1:.2%}" for case, f in row.second.items()
        )
        lines.append(f"| {row.size} | {row.dofs[0]} | {row.dofs[1]} | {cells} |")
    return lines


@dataclass(frozen=True)
class Findings:
    """All that the page shows."""

    rows: list[Row]
    reference: Reference
    vanes: list[Named]
    casings: list[Named]
    casing_limit: Floats
    joined: list[Joined]


def measure(names: list[str]) -> Findings:
    """Take all figures; those of sizes with names for some of them."""
    return Findings(
        list(rows()),
        reference(),
        [named("vane", size) for size in names],
        [named("casing", size) for size in names],
        casing_reference(),
        [joined(size) for size in names],
    )


def report(made: Findings, folder: Path | None) -> list[str]:
    """Lines of the page; its picture goes into a folder, if there is one."""
    exact = made.reference.frequency
    f = [row.frequency for row in made.reference.rows]
    doubt = 1 - extrapolated(f[-2], f[-1], made.reference.order) / exact
    found = made.rows + made.reference.rows
    groups = by_family(found)
    base = groups[CURVED][2]
    unit, above = base.solving, off(groups[CURVED][-1], exact)
    assert above.min() > 0
    told = REFERENCE.format(order=ORDER, doubt=doubt.mean(), worst=doubt.max(), above=above.mean())
    lines = [*INTRODUCTION.format(unit=unit, base=base.name, dofs=base.dofs).splitlines(), ""]
    lines += ["![error against dofs and CPU time](mesh_study.png)", ""]
    lines += conclusion(groups, exact, needed, mean)
    lines += ["", "## Families", "", *families(found, exact, unit), ""]
    lines += [*RATES.splitlines(), "", *rates(found, exact), "", "## The reference", ""]
    lines += [*told.splitlines(), "", *limits(made.reference), "", "## Sizes with names", ""]
    lines += [*NAMED.splitlines(), "", *sizes("vane", made.vanes, exact), ""]
    lines += [*sizes("casing", made.casings, made.casing_limit), ""]
    lines += ["## Vane and casing joined", "", *JOINED.splitlines(), "", *together(made.joined)]
    if folder:
        errors(groups, exact, mean, unit, folder / "mesh_study.png")
    return lines


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    parser.add_argument("--sizes", nargs="+", default=list(SIZES), help="sizes with names")
    options = parser.parse_args()
    with threadpool_limits(1):
        made = measure(options.sizes)
    lines = report(made, FOLDER if options.write else None)
    print("\n".join(lines))
    page("mesh_study", "Elements and their sizes", lines, options.write)


if __name__ == "__main__":
    main()
