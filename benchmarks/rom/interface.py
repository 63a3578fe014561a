"""What many interface nodes cost: half a Brake-Reuss beam, its lap joint kept, against its parts.

    python -m benchmarks.rom.interface [--size 0.00475] [--nodes 661] [--write]

prints the table; `--write` puts it into docs/benchmarks/large_interface.md as well. CPU times on
one thread, the median of three runs in turn.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import benchmarks.isolated  # noqa: F401  # isort: skip  # it sets the threads

import numpy as np

from benchmarks.pages import page
from vanelock import fem, rom
from vanelock.fem import Model
from vanelock.fem.block_lanczos import krylov_space
from vanelock.mesh import Part
from vanelock.mesh.generate.mesher import generate
from vanelock.mesh.gmsh_session import session

LENGTH, JOINT, WIDTH = 0.36, 0.12, 25.4e-3
MODES = 20
STEEL = fem.Material(E=200e9, nu=0.3, rho=7800)
TEXT = """\
A bar of 0.36 m x 25.4 mm x 25.4 mm, half as thick over the last third, where it meets its other
half: {dofs} dofs in quadratic tetrahedra, the {rows} of {nodes} nodes there kept, and {modes}
fixed-interface modes. The parts of the work, each alone: a factorisation of the stiffness of all
other dofs, solutions for as many right-hand sides as rows are kept with factors at hand, the mass
times as many columns, their Gram matrix, and the modes with factors at hand. CPU times, one thread.

| | CPU time | over the parts | by |
|---|---:|---:|---|"""


def beam(size: float, nodes: int) -> tuple[Model, np.ndarray]:
    """Half a beam, and the rows of the joint's nodes."""
    with session("beam") as gmsh:
        occ = gmsh.model.occ
        thick = occ.addBox(0, 0, 0, LENGTH - JOINT, WIDTH, WIDTH)
        thin = occ.addBox(LENGTH - JOINT, 0, 0, JOINT, WIDTH, WIDTH / 2)
        occ.fuse([(3, thick)], [(3, thin)])
        occ.synchronize()
        found = generate(gmsh, size)
    x, _, z = found.points.T
    joint = np.flatnonzero((abs(z - WIDTH / 2) < 1e-8) & (x > LENGTH - JOINT - 1e-8))
    joint = joint[np.argsort(-x[joint], kind="stable")][:nodes]
    model = fem.assemble(Part("beam", found.points, found.cells, "tetra10", {}, {}, 1), STEEL)
    return model, model.dofs[joint].ravel()


def spent(times: dict[str, list[float]], name: str, run: Callable[[], Any]) -> Any:
    """What it returns; its CPU time, s, is added to those of this name."""
    begin = time.process_time()
    found = run()
    times.setdefault(name, []).append(time.process_time() - begin)
    return found


def measured(model: Model, rows: np.ndarray) -> dict[str, list[float]]:
    """CPU times of the reduction and of the parts of its work, three of each in turn."""
    times: dict[str, list[float]] = {}
    rest = np.setdiff1d(np.arange(model.K.shape[0]), rows)
    K_ss, M_ss = model.K[rest][:, rest].tocsc(), model.M[rest][:, rest].tocsc()
    _, interior = fem.schur_complement(model.K, rows)
    sides = np.random.default_rng(0).standard_normal((len(rest), len(rows)))
    wanted = rom.Selection(modes=MODES)
    for _ in range(3):
        spent(times, "reduction", lambda: rom.reduce_rows(model.K, model.M, rows, wanted))
        spent(times, "factorisation", lambda: fem.factorise(K_ss))
        spent(times, "solutions", lambda: interior.solve(sides))
        spent(times, "mass", lambda: M_ss @ sides)
        spent(times, "Gram matrix", lambda: sides.T @ sides)
        spent(times, "modes", lambda: wanted.modes_in(krylov_space(interior.solve, M_ss)))
    return times


def report(size: float, nodes: int) -> list[str]:
    """Lines of the page."""
    model, rows = beam(size, nodes)
    times = {name: float(np.median(all_)) for name, all_ in measured(model, rows).items()}
    whole = times.pop("reduction")
    parts = sum(times.values())
    ways = {
        "factorisation": fem.backends()[0].upper(),
        "solutions": "the panels of the reduction's own factors",
        "mass": "scipy.sparse",
        "Gram matrix": "BLAS",
        "modes": "block Lanczos",
    }
    counts = {"dofs": model.K.shape[0], "rows": len(rows), "nodes": len(rows) // 3}
    lines = TEXT.format(**counts, modes=MODES).splitlines()
    for name, seconds in times.items():
        lines.append(f"| {name} | {seconds:.2f} s | {seconds / parts:.2f} | {ways[name]} |")
    lines += [
        f"| parts together | {parts:.2f} s | 1 | |",
        f"| reduction | {whole:.2f} s | {whole / parts:.2f} | `rom.reduce_rows` |",
    ]
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=float, default=0.00475, help="of the elements, m")
    parser.add_argument("--nodes", type=int, default=661, help="of the joint that are kept")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    lines = report(options.size, options.nodes)
    print("\n".join(lines))
    page("large_interface", "Cost of a large interface", lines, options.write)


if __name__ == "__main__":
    main()
