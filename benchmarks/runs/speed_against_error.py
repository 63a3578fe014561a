"""Error against cost of every setting of the example vane, as `vanelock converge` measures it.

    python -m benchmarks.runs.speed_against_error [--sizes coarse medium] [--dofs 150000] [--write]

prints the tables; `--write` puts them into docs/benchmarks/speed-against-error.md, with pictures.
What was computed before in runs/speed-against-error is used again; delete that folder for costs
that come from one run.
"""

import argparse
import shutil
from pathlib import Path

from benchmarks.pages import FOLDER, page
from vanelock import choose_listener, converge_study
from vanelock.commands.converge.settings import markdown
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study

ROOT = Path(__file__).parents[2]
NAME = "speed-against-error"
MU = 0.15
INTRODUCTION = """\
`vanelock converge` makes the same of any study. The default study at μ = 0.15, each setting raised alone, the others as the
study has them (bold: its own value). Error: relative distance of the peak, its amplitude and its
frequency, from that of the finest value of the same setting, which says nothing of what the finest
one itself is off by; for frequencies, from the peak located among the most points. Cost: CPU time
of the stages that the setting affects, in units of all stages of the study as it is (1.00).

Peaks are located to about 4e-5 of their frequency and 2e-5 of their amplitude, since the curve has
kinks where contacts change state. Differences below that mean nothing.

Nodal springs (`joints.patch = "node"`) do not converge as the mesh is refined: part of what
`mesh.size` changes there is that. What an `accuracy` makes of these curves: [accuracy](../accuracy.md)."""


def vane(size: str) -> Study:
    """The default study on a mesh of some size."""
    changes = {
        "mesh.size": size,
        "joints.interlock.mu": MU,
        "damping.joints": "stuck",
        "name": f"vane, {size} mesh",
    }
    return with_values(Study(), changes)


def main() -> None:
    """Measure, print, and write the page if wanted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", nargs="+", default=["coarse", "medium"])
    parser.add_argument("--dofs", type=float, default=150_000)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    lines = [INTRODUCTION]
    for size in given.sizes:
        folder = ROOT / "runs" / NAME / size
        with choose_listener(False, False) as listener:
            found = converge_study(vane(size), folder, listener, dofs=given.dofs)
        picture = f"{NAME}-{size}.png"
        if given.write:
            shutil.copyfile(
                folder / "figures" / "converge.png", FOLDER / picture
            )
        lines += [f"\n## Mesh size {size}\n", f"![error against cost]({picture})\n"]
        lines.append(markdown(found))
    page(NAME, "Speed against error", lines, given.write)


if __name__ == "__main__":
    main()
