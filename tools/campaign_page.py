"""Write docs/campaign.md and its pictures from the folder of a finished campaign.

    python tools/campaign_page.py runs/paper

The text between the tables is written here; every number comes from the run.
"""

import csv
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "campaign.md"
PICTURES = ("map_interference", "optimum", "fig15_coupling_friction", "campbell")

HEAD = """# The published study at its own scale

What `vanelock run examples/paper.toml` finds, on a model of the published one's size, with the
statements of Lassalle and Firrone's study of a vane segment with friction joints beside it. The
study withholds friction coefficients, interferences, load and dimensions. Friction, interference
and load of the example are where its trends hold and waves are stable
([where](benchmarks/trends_and_stability.md)); no other parameter was chosen to agree. "waves": of
the coupled peaks that a statement is judged by. Those of three and five harmonics are stable; those
of one harmonic are undecided, since one and three harmonics differ on them. This page is made from
a run by `tools/campaign_page.py`.
"""

MAPS = """## Where each statement holds

Each cell of the maps is a response over the whole range of frequencies by five methods; points
that do not converge would leave a gap. Peaks fall with friction and with interference below what
damps best, and rise beyond; the uncoupled peak lies higher in frequency and lower in amplitude on
the same side, and the order turns round on the other. Friction bounded by the load at rest
(constant-load) does the same where contacts stay closed; where they lift off, their mean load
grows, and friction with it, which a load held at rest misses. One harmonic is right to some per
cent where contacts slip all the time, off by a fifth near what damps best, and by half where
contacts under much friction lift off.
"""


def main() -> None:
    """Write the page."""
    if len(sys.argv) != 2:
        sys.exit("usage: python tools/campaign_page.py FOLDER")
    folder = Path(sys.argv[1])
    for name in PICTURES:
        source = folder / "figures" / f"{name}.png"
        shutil.copyfile(source, ROOT / "docs" / "pictures" / f"{name}.png")
    PAGE.write_text(page(folder), "utf-8")


def page(folder: Path) -> str:
    """The page of a run."""
    parts = [HEAD, "## Statements and agreement\n", agreement(folder), MAPS, shares(folder)]
    parts += [picture("map_interference", "where each statement holds, and errors of methods")]
    parts += ["## Friction and interference that damp best\n"]
    parts += [picture("optimum", "the peak over decades of friction and interference")]
    parts += ["## Coupled and uncoupled\n", picture("fig15_coupling_friction", "Figure 15")]
    parts += ["## Campbell diagram\n", picture("campbell", "natural frequencies over rotor speed")]
    parts += ["## Time\n", times(folder)]
    return "\n".join(parts)


def agreement(folder: Path) -> str:
    """The table of statements."""
    with (folder / "figures" / "agreement.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    body = [
        (
            row["figure"],
            row["says"],
            row["found"].lstrip("'"),
            f"**{row['agrees']}**",
            row["waves"],
            row["why"],
        )
        for row in rows
    ]
    heads = ("figure", "the study states", "we find", "agrees", "waves", "why not, or where")
    return table(heads, body)


def shares(folder: Path) -> str:
    """Shares of each map in which statements hold."""
    from vanelock.published.maps.map_figures import holds
    from vanelock.published.maps.plane import Plane

    with h5py.File(folder / "results.h5") as file:
        planes = {
            name: Plane.load(group) for name, group in file["campaign"].items() if "map" in name
        }
    names = list(holds(planes["map_interference"]))
    body = []
    for name, plane in planes.items():
        found = holds(plane)
        cells = [f"{100 * found[each].mean():.0f}" if each in found else "" for each in names]
        lost = int(plane.lost.sum())
        body.append((name.removeprefix("map_"), *cells, f"{plane.points.sum():,}", f"{lost}"))
    head = ("map", *names, "frequencies solved", "lost")
    return "Share of each map in per cent.\n\n" + table(head, body)


def times(folder: Path) -> str:
    """Seconds by kind of stage."""
    spent: dict[str, float] = {}
    with h5py.File(folder / "results.h5") as file:
        for name, group in file["provenance/stages"].items():
            word = name.partition(" ")[0]
            spent[word] = spent.get(word, 0.0) + float(group.attrs["seconds"])
    body = [(word, f"{s:.1f}") for word, s in sorted(spent.items(), key=lambda item: -item[1])]
    body.append(("**all**", f"{sum(spent.values()):.1f}"))
    above = (
        "What computing each kind of stage took on two cores; pictures and page come on top.\n\n"
    )
    return above + table(("stage", "s"), body)


def picture(name: str, words: str) -> str:
    """A picture of the page."""
    return f"![{words}](pictures/{name}.png)\n"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
