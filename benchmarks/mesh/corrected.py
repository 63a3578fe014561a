"""What a study's meshes are off by, as they are and without what they add to the stiffness.

    python -m benchmarks.mesh.corrected [--write]

prints two tables; `--write` puts them into docs/benchmarks/mesh_correction.md. The joined sector of
the default study, contacts on areas, one harmonic, 30 N: a limit that no correction touches is
extrapolated from its last two meshes. The vanes of thirteen designs by themselves, each against a
much finer mesh of its own. Runs are kept in runs/corrected and go on where they were stopped. An
hour.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.mesh.reference import ORDER, extrapolated
from benchmarks.pages import page
from benchmarks.segment import MATERIAL
from vanelock import fem, mesh, open_results, parse_study, rom, run_study
from vanelock.mesh import VaneDimensions
from vanelock.stages.response.limits import Limits

Floats = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
MESHES = (("coarse", 3), ("medium", 3), ("medium", 1), ("fine", 1))
FRICTION = (0.15, 0.3)
STUDY = """
[mesh]
size = "{size}"
stretch = {stretch}
[response]
harmonics = 1
[joints]
patch = "area"
[outputs]
show = []
[sweep]
"mesh.correction" = ["none", "modal"]
"joints.interlock.mu" = [{mu}]
"""
DESIGNS: dict[str, dict[str, float]] = {
    "default": {},
    "sharp roots": {"root_fillet": 0},
    "1 aerofoil": {"aerofoils": 1},
    "2 aerofoils": {"aerofoils": 2},
    "6 aerofoils": {"aerofoils": 6, "chord": 0.032, "thickness": 0.0035, "edge_thickness": 0.0018},
    "thick aerofoils": {"thickness": 0.0058, "edge_thickness": 0.0029},
    "thin aerofoils": {"thickness": 0.0033, "edge_thickness": 0.0016},
    "twist 10°, three aerofoils": {"aerofoils": 3, "twist": 10},
    "lean 8°": {"lean": 8},
    "stagger 15°, slant 20°": {"stagger": 15, "interlock_slant": 20},
    "camber 0.2": {"camber": 0.2},
    "thick outer shroud": {"outer_shroud_inner_radius": 0.564, "outer_shroud_outer_radius": 0.574},
    "fillets of leg and foot, 1.5 mm": {"fillet": 0.0015},
}
SIZES = (0.016, 0.007)
"""Of the vanes by themselves, m: "medium", and what it is compared with."""
RIGID, MODES, COUNT = 6, 16, 10
JOINED = """\
Frequency of the mode of interest with the interlock free and stuck, Hz, and the friction peak, µm,
at μ = {mu}. Errors are relative to the limit, in %: that of the last two meshes, one of
half the size of the other, as they are, extrapolated with the order {order:.2f} of sharp edges.

| vane, casing | dofs | as it is | off by | corrected | off by |
|---|---:|---:|---:|---:|---:|"""
VANES = """\
The ten first elastic modes of vanes that nothing holds, {} elements, against {}, corrected:
mean and largest difference in %. Of the vane with sharp roots graded hexahedra of degree 3 give
the limit ([verification](../verification/mesh_correction.md)): from it the finer mesh, corrected,
differs by 0.1 % on average and 0.2 at most, as it is by 1.0. Extrapolation would be no better
reference: unstructured meshes are not similar, and from 7 and 5 mm it ends 0.4 % below that limit.

| design | dofs | dofs of the finer | as it is | corrected |
|---|---:|---:|---:|---:|"""


class Answers(NamedTuple):
    """Of one mesh: degrees of freedom, and frequencies [Hz] and peaks [µm] by correction."""

    name: str
    dofs: int
    values: dict[str, Floats]


def joined(size: str, stretch: float) -> Answers:
    """Run the default study on a mesh."""
    text = STUDY.format(size=size, stretch=stretch, mu=", ".join(map(str, FRICTION)))
    folder = ROOT / "runs" / "corrected" / f"{size}-{stretch:g}"
    found = run_study(parse_study(text), folder, text=text)
    values = {}
    with open_results(folder / "results.h5") as file:
        for kind in ("none", "modal"):
            own = [each for each in found if each.values["mesh.correction"] == kind]
            linear = Limits.load(file["limits"][next(n for n in file["limits"] if kind in n)])
            hertz = [linear.free[linear.free_mode], linear.stuck[linear.stuck_mode]]
            peaks = [1e6 * each.peak.amplitude for each in own if each.peak]
            values[kind] = np.array([*hertz, *peaks])
        fixed = len(file["mesh/casing/node_sets/fixed"])
        nodes = sum(len(file[f"mesh/{part}/points"]) for part in ("vane", "casing"))
    return Answers(f"{size}, stretch {stretch:g}", 3 * (nodes - fixed), values)


def joined_table(rows: list[Answers]) -> Iterator[str]:
    """Lines of the first table, the limit last."""
    exact = extrapolated(rows[-2].values["none"], rows[-1].values["none"])

    def cells(values: Floats) -> str:
        return "{:.2f}, {:.2f}; ".format(*values[:2]) + ", ".join(f"{v:.1f}" for v in values[2:])

    def off(values: Floats) -> str:
        return ", ".join(f"{e:+.2f}" for e in 100 * (values / exact - 1))

    yield JOINED.format(mu=" and ".join(map(str, FRICTION)), order=ORDER)
    for row in rows:
        both = " | ".join(f"{cells(v)} | {off(v)}" for v in row.values.values())
        yield f"| {row.name} | {row.dofs:,} | {both} |"
    yield f"| limit of the last two as they are | | {cells(exact)} | | | |"


def vane(dimensions: VaneDimensions, size: str | float) -> tuple[int, Floats, Floats]:
    """Degrees of freedom, and ten frequencies [Hz] as they are and corrected."""
    model = fem.assemble(mesh.vane_segment(dimensions, size=size), MATERIAL)
    found = fem.modes(model, RIGID + MODES)
    hertz, shapes = found.frequency[RIGID:], found.shapes[:, :, RIGID:]
    stiffness = np.diag((2 * np.pi * hertz) ** 2)  # in coordinates of the modes
    added = [fem.excess_stiffness(model, shapes)]
    excess = rom.modal_excess(np.eye(MODES), hertz, added, [stiffness])
    corrected = np.sqrt(np.linalg.eigvalsh(stiffness - excess.stiffness[0])) / (2 * np.pi)
    return model.K.shape[0], hertz[:COUNT], corrected[:COUNT]


def design(name: str, changes: dict[str, float]) -> str:
    """A row of the second table."""
    dimensions = VaneDimensions(**changes)  # type: ignore[arg-type]
    (dofs, as_it_is, corrected), (most, _, exact) = (vane(dimensions, size) for size in SIZES)

    def off(hertz: Floats) -> str:
        e = 100 * abs(hertz / exact - 1)
        return f"{e.mean():.2f} / {e.max():.2f}"

    return f"| {name} | {dofs:,} | {most:,} | {off(as_it_is)} | {off(corrected)} |"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    given = parser.parse_args()
    lines: list[str] = []

    def tell(text: str) -> None:
        print(text, flush=True)
        lines.append(text)

    with threadpool_limits(1):
        tell("## Vanes of thirteen designs\n")
        tell(VANES.format(*(f"{1e3 * size:g} mm" for size in SIZES)))
        for name, changes in DESIGNS.items():
            tell(design(name, changes))
        tell("\n## The joined sector\n")
        for line in joined_table([joined(*each) for each in MESHES]):
            tell(line)
    page("mesh_correction", "What the correction leaves", lines, given.write)


if __name__ == "__main__":
    main()
