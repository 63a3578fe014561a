"""Write the matrices and lists of a blade with a platform, as another program would export them.

A steel blade, clamped at its root, has a platform at a third of its height; a damper at rest
presses on the platform's underside. Twenty-node bricks, in mm, t and N; Matrix Market files with
the mapping of rows that Ansys's HBMAT writes beside its matrices.

    python examples/ground_damper/make.py
"""

import gzip
import io
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp
from skfem import Basis, BilinearForm, ElementHexS2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

HERE = Path(__file__).parent
MODULUS, POISSON, DENSITY = 200e3, 0.3, 7.85e-9  # MPa, -, t/mm^3
THICK, WIDE, OUT = (0, 6), (0, 20, 32), (0, 18, 36, 44, 63, 82, 101, 120)  # mm
FOOT, TOP = 36, 44  # of the platform


def blade() -> Basis:
    """Bricks of blade and platform."""
    grid = MeshHex.init_tensor(*(np.array(levels, float) for levels in (THICK, WIDE, OUT)))
    _, y, z = grid.p[:, grid.t].mean(axis=1)
    kept = (y < WIDE[1]) | ((z > FOOT) & (z < TOP))
    return Basis(grid.restrict(np.flatnonzero(kept)), ElementVector(ElementHexS2()), intorder=4)


@BilinearForm
def inertia(u, v, _):  # type: ignore[no-untyped-def]
    """Density times the product of displacements."""
    return DENSITY * dot(u, v)


def nodes_of(basis: Basis) -> np.ndarray:
    """(n, 3) places of the nodes; freedom 3 n + d is node n's displacement d."""
    return basis.doflocs[:, ::3].T


def write_market(path: Path, matrix: sp.csr_array) -> None:
    """The lower triangle, packed with the same bytes every time."""
    held = io.BytesIO()
    lower = sp.tril(matrix).tocoo()
    scipy.io.mmwrite(held, lower, symmetry="symmetric", precision=12)
    path.write_bytes(gzip.compress(held.getvalue(), 9, mtime=0))


def main() -> None:
    """Write all files."""
    basis = blade()
    K = linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis)
    M = inertia.assemble(basis)
    for name, matrix in (("stiffness.mtx.gz", K), ("mass.mtx.gz", M)):
        kept = matrix.tocoo()
        kept.data[np.abs(kept.data) < 1e-13 * np.abs(kept.data).max()] = 0.0
        kept.eliminate_zeros()
        write_market(HERE / name, kept.tocsr())
    places = nodes_of(basis)
    x, y, z = places.T
    rows = [
        f"{3 * n + d + 1:12d}{n + 1:12d}{'U' + 'XYZ'[d]:>8}"
        for n in range(len(x))
        for d in range(3)
    ]
    head = f"{'Matrix Eqn':>12}{'Node':>12}{'DOF':>8}"
    (HERE / "rows.mapping").write_text("\n".join([head, *rows]) + "\n")
    table = [f"{n + 1},{a:g},{b:g},{c:g}" for n, (a, b, c) in enumerate(places)]
    (HERE / "nodes.csv").write_text("\n".join(["node,x,y,z", *table]) + "\n")
    lists = {
        "root": z == 0,
        "underside": (z == FOOT) & (y > WIDE[1]),
        "tip": (z == OUT[-1]) & (x == 0) & (y == WIDE[1] / 2),
    }
    for name, chosen in lists.items():
        numbers = np.flatnonzero(chosen) + 1
        (HERE / f"{name}.csv").write_text("\n".join(["node", *map(str, numbers)]) + "\n")


if __name__ == "__main__":
    main()
