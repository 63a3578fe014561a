"""Frequencies of the reduced model against the unreduced cyclic sector's.

The vane of examples/vane.toml at nodal diameter 1: hooks as linear springs, the interlock free and
as linear springs, for both bases of the casing's face.

    python benchmarks/reduction_error.py [--size medium] [--write]

prints the table; `--write` puts it into docs/benchmarks/reduction_error.md as well.
"""

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, mesh, rom

DIAMETER = 1
COUNT = 6
HOOK = rom.Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6)
INTERLOCK = rom.Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6)
CASES = {"free": (HOOK,), "closed": (HOOK, INTERLOCK)}
SETS = ("hook_front", "hook_rear", "key")
VANE_MASTERS = (*SETS, "interlock_left", "interlock_right", "accessory")
CASING_MASTERS = (*SETS, "force", "accessory")


def truth(
    vane: fem.Model, casing: fem.Model, joints: tuple[rom.Joint, ...]
) -> tuple[NDArray[np.float64], int]:
    """Frequencies of the unreduced sector, Hz, and its size."""
    K, M = rom.unreduced(vane, casing, joints, DIAMETER)
    return np.sqrt(fem.eigenpairs(K, M, COUNT)[0]) / (2 * np.pi), K.shape[0]


def table(size: str) -> list[str]:
    """Lines of the report, in Markdown."""
    material = fem.Material(E=170e9, nu=0.3, rho=8200)
    vane = fem.assemble(mesh.vane_segment(size=size), material)
    casing = fem.assemble(mesh.casing_sector(size=size), material)
    lines = [
        f"Mesh size {size}: vane {vane.K.shape[0]} dofs, casing {casing.K.shape[0]} dofs; ten",
        "fixed-interface modes a part, ten face modes; nodal diameter 1.",
        "",
        "| interlock | face basis | size | f1 | f2 | f3 | f4 | f5 | f6 |",
        "|---|---|---" + "|---:" * COUNT + "|",
    ]
    references = {name: truth(vane, casing, joints) for name, joints in CASES.items()}
    for name, (frequencies, unknowns) in references.items():
        values = " | ".join(f"{f:.3f} Hz" for f in frequencies)
        lines.append(f"| {name} | unreduced | {unknowns} | {values} |")
    small_vane = rom.reduce(vane, VANE_MASTERS, 10)
    for interface in ("published", "followed"):
        small_casing = rom.reduce(
            casing, CASING_MASTERS, 10, nodal_diameters=[DIAMETER], interface=interface
        )
        for name, joints in CASES.items():
            system = rom.join(small_vane, small_casing, joints, rom.Excitation(1, force=1.0))
            found, _ = rom.linear_modes(system, DIAMETER, COUNT)
            errors = " | ".join(f"{e:.1e}" for e in found / references[name][0] - 1)
            lines.append(f"| {name} | {interface} | {len(system.at(DIAMETER).K)} | {errors} |")
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="medium", help="mesh size by name")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    lines = table(options.size)
    print("\n".join(lines))
    if options.write:
        page = Path(__file__).parents[1] / "docs" / "benchmarks" / "reduction_error.md"
        page.parent.mkdir(parents=True, exist_ok=True)
        title = "# Frequencies of the reduced model against the unreduced sector's\n"
        command = "Made by `python benchmarks/reduction_error.py --write`. Relative errors.\n"
        page.write_text("\n".join([title, command, *lines, ""]))


if __name__ == "__main__":
    main()
