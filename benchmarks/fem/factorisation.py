"""Sparse factorisation and assembly on the parts of a real segment, backend against backend.

    python -m benchmarks.fem.factorisation [--sizes 0.0095 0.0055] [--write]

prints tables of the stiffness of the vane and of the casing, alone and cyclic; `--write` puts them
into docs/benchmarks/factorisation.md as well. Each measurement runs in a process of its own, on one
thread (isolated.py). All tables but the first are of the first size.
"""

import argparse
from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.isolated import COLUMNS, in_child, seconds, stored  # isort: skip  # it sets the threads
import numpy as np
import scipy.sparse as sp
import skfem
from skfem.helpers import dot
from skfem.models.elasticity import linear_elasticity
from threadpoolctl import threadpool_info

from benchmarks.pages import page
from vanelock import fem, mesh

MATERIAL = fem.Material(E=170e9, nu=0.3, rho=8200)
BACKENDS = ("cholmod", "pardiso", "superlu")
SLOW = 5.0  # s: a backend that took more for a matrix is left out where that is larger
WIDTHS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
MASTERS = ("left", "right", "hook_front", "hook_rear", "key", "force", "output")
CHOICE = """\
`factorise` takes CHOLMOD: PARDISO factorises large real matrices as fast, but its columns cost
several times as much, and complex matrices double its size. A backend that took more than five
seconds for a matrix is left out where that is larger.
"""
WIDTHS_TEXT = """\
CPU time of a column in units of a single one's: the factors come through memory once for a block.
"""
SCHUR_TEXT = """\
Of the dofs of the cyclic faces, the contacts, the forces and the outputs.

| | CPU time | factorisations of K |
|---|---:|---:|"""
ASSEMBLY_TEXT = """\
K and M together, in units of the factorisation of the clamped part's K, by `fem.assemble` and by
scikit-fem's `asm`.

| part | dofs | factorisation | assemble | asm | asm over assemble |
|---|---:|---:|---:|---:|---:|"""


class Case(NamedTuple):
    """A matrix to factorise."""

    name: str
    A: sp.csc_array


def parts(size: str | float) -> tuple[fem.Model, fem.Model]:
    """Vane and casing."""
    return (
        fem.assemble(mesh.vane_segment(size=size), MATERIAL),
        fem.assemble(mesh.casing_sector(size=size), MATERIAL),
    )


def cyclic(model: fem.Model, diameter: int) -> sp.csc_array:
    """Stiffness at one nodal diameter."""
    T = fem.cyclic_transform(model, diameter)
    return sp.csc_array(T.conj().T @ model.K @ T)


def cases(vane: fem.Model, casing: fem.Model) -> Iterator[Case]:
    """Stiffness of the vane, lifted as it is free, and of the casing, alone and cyclic."""
    size = float(np.linalg.norm(np.ptp(vane.part.points, axis=0)))
    low = (0.01 / size) ** 2 * MATERIAL.E / MATERIAL.rho
    yield Case("vane, K + σM", sp.csc_array(vane.K + low * vane.M))
    yield Case("casing, K", casing.K)
    yield Case("casing, ND 1", cyclic(casing, 1))


def solvers(vane: fem.Model, casing: fem.Model, slow: set[tuple[str, str]]) -> list[str]:
    """Table of the backends without the slow ones, which it adds to."""
    lines: list[str] = []
    for case in cases(vane, casing):
        unit = None
        with stored(case.A) as file:
            for backend in (b for b in BACKENDS if b in fem.backends()):
                if (case.name, backend) in slow:
                    continue
                r = in_child(file, backend)
                unit = unit or r
                if r["factor"] > SLOW:
                    slow.add((case.name, backend))
                ratios = [f"{r[k] / unit[k]:.2f}" for k in ("factor", "block", "single")]
                lines.append(
                    f"| {case.name} | {case.A.shape[0]} | {r['backend']} | {r['factor']:.2f} s | "
                    f"{1e3 * r['block']:.1f} ms | {1e3 * r['single']:.1f} ms | "
                    f"{' / '.join(ratios)} | {r['memory']:.0f} MB | {r['error']:.0e} |"
                )
                print(lines[-1], flush=True)
    return lines


def widths(A: sp.csc_array) -> list[str]:
    """Table of the cost of a column against the columns of a block."""
    factor = fem.factorise(A)
    b = np.asfortranarray(np.random.default_rng(0).standard_normal((A.shape[0], max(WIDTHS))))
    cost = [seconds(lambda k=k: factor.solve(b[:, :k]), 5) / k for k in WIDTHS]
    return [
        "",
        "| columns | " + " | ".join(map(str, WIDTHS)) + " |",
        "|---|" + "---:|" * len(WIDTHS),
        "| of the single one | " + " | ".join(f"{c / cost[0]:.2f}" for c in cost) + " |",
    ]


def condensed(model: fem.Model) -> list[str]:
    """Table of the Schur complement of all master dofs."""
    rows = np.unique(np.concatenate([model.rows(name).ravel() for name in MASTERS]))
    rows = rows[rows >= 0]
    K = model.K
    unit = seconds(lambda: fem.factorise(K))
    factor, interior = fem.factorise(K), fem.schur_complement(K, rows)[1]
    rest = np.setdiff1d(np.arange(K.shape[0]), rows)
    ties = K[rest][:, rows]
    inside = fem.factorise(K[rest][:, rest])
    one = cyclic(model, 1)
    b = np.asfortranarray(np.random.default_rng(0).standard_normal((len(rows), COLUMNS)))
    full = np.asfortranarray(np.zeros((K.shape[0], COLUMNS)))
    timed = {
        "factorisation of K": unit,
        "factorisation at nodal diameter 1": seconds(lambda: fem.factorise(one)),
        f"Schur complement of {len(rows)} dofs": seconds(lambda: fem.schur_complement(K, rows)),
        "the same by solves, K of the rest factorised": seconds(
            lambda: ties.T @ inside.solve(ties), 1
        ),
        f"{COLUMNS} columns: solve with K": seconds(lambda: factor.solve(full)),
        f"{COLUMNS} columns: static following of the rest": seconds(lambda: interior.extend(b)),
    }
    return [f"| {name} | {t:.2f} s | {t / unit:.2f} |" for name, t in timed.items()]


def assembly(models: tuple[fem.Model, ...]) -> list[str]:
    """Table of assembly over factorisation."""
    lines = []
    for model in models:
        part = model.part
        space = skfem.MeshTet2(part.points.T, part.cells.T)
        basis = skfem.Basis(space, skfem.ElementVector(skfem.ElementTetP2()), intorder=4)
        weight = skfem.BilinearForm(lambda u, v, w: MATERIAL.rho * dot(u, v))
        forms = (linear_elasticity(*MATERIAL.lame), weight)
        theirs = seconds(lambda basis=basis, forms=forms: [f.assemble(basis) for f in forms], 1)
        mine = seconds(lambda part=part: fem.assemble(part, MATERIAL, fixed="hook_front"))
        held = fem.assemble(part, MATERIAL, fixed="hook_front" if part.name == "vane" else "fixed")
        unit = seconds(lambda held=held: fem.factorise(held.K))
        lines.append(
            f"| {part.name} | {held.K.shape[0]} | {unit:.2f} s | {mine / unit:.2f} | "
            f"{theirs / unit:.2f} | {theirs / mine:.1f} |"
        )
    return lines


def report(sizes: list[str | float]) -> list[str]:
    """Lines of the page."""
    missing = [name for name in BACKENDS if name not in fem.backends()]
    blas = {
        f"{info['internal_api']} {info['version']} ({info.get('architecture', 'unknown')})"
        for info in threadpool_info()
        if info["user_api"] == "blas"
    }
    lines = [
        f"BLAS of NumPy and SciPy: {', '.join(sorted(blas))}; CHOLMOD takes the system's, PARDISO",
        f"brings its own. Not installed, and left out: {', '.join(missing) or 'none'}. CPU times,",
        "one thread.",
        "",
        "## Backends",
        "",
        "Column: of a block of 128; alone: a single one. Ratios to the first backend:",
        "factorisation / column / alone. Memory: peak above what was there before. Error:",
        "backward error of a solution.",
        "",
        *CHOICE.splitlines(),
        "",
        "| matrix | rows | backend | factor | column | alone | ratios | memory | error |",
        "|---|---:|---|---:|---:|---:|---|---:|---:|",
    ]
    print("\n".join(lines), flush=True)
    first = models = parts(sizes[0])
    slow: set[tuple[str, str]] = set()
    for size in sizes:
        models = models if size == sizes[0] else parts(size)
        lines += solvers(*models, slow)
    casing = first[1]
    n = casing.K.shape[0]
    for title, text, table in (
        (f"Columns of a block (casing, {n} dofs)", WIDTHS_TEXT, lambda: widths(casing.K)),
        (f"Dense Schur complement (casing, {n} dofs)", SCHUR_TEXT, lambda: condensed(casing)),
        ("Assembly", ASSEMBLY_TEXT, lambda: assembly(first)),
    ):
        section = ["", f"## {title}", "", *text.splitlines(), *table()]
        print("\n".join(section), flush=True)
        lines += section
    return lines


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", nargs="+", default=["0.0095", "0.0055"])
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    sizes = [float(s) if s[0].isdigit() else s for s in options.sizes]
    page("factorisation", "Sparse factorisation", report(sizes), options.write)


if __name__ == "__main__":
    main()
