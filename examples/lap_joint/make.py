"""Write the matrices of two blocks with a lap joint, as Abaqus would export them.

Two steel blocks, each clamped at its outer end, overlap in the middle, where a bolt presses them
together. In bending the surfaces that meet move against one another, as far as friction lets them.
Twenty-node bricks, in m, kg and N; `*MATRIX OUTPUT` of stiffness and mass, which names node and
freedom of every entry and marks what is clamped by 1e36 on the diagonal.

    python examples/lap_joint/make.py
"""

import gzip
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from skfem import Basis, BilinearForm, ElementHexS2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

HERE = Path(__file__).parent
MODULUS, POISSON, DENSITY = 210e9, 0.3, 7850.0  # Pa, -, kg/m^3
LONG, WIDE, THICK = 0.12, 0.02, 0.008  # m
LAP = 0.04  # m, of the overlap
CLAMPED = 1e36
FIRST = {"lower": 1, "upper": 1001}
"""Number of the first node."""


def block(low: float, high: float, under: float, top: float) -> Basis:
    """Bricks of one block, five along it."""
    levels = np.linspace(low, high, 7), np.array([0, WIDE]), np.array([under, top])
    return Basis(MeshHex.init_tensor(*levels), ElementVector(ElementHexS2()), intorder=4)


@BilinearForm
def inertia(u, v, _):  # type: ignore[no-untyped-def]
    """Density times the product of displacements."""
    return DENSITY * dot(u, v)


def write_abaqus(path: Path, matrix: sp.sparray, first: int, clamped: np.ndarray) -> None:
    """Row node, freedom, column node, freedom, entry: one triangle."""
    lower = sp.tril(matrix).tocoo()
    small = 1e-13 * np.abs(lower.data).max()
    lines = []
    for i, j, value in zip(lower.row, lower.col, lower.data, strict=True):
        if abs(value) > small:
            value = CLAMPED if i == j and clamped[i] else value
            lines.append(
                f"{i // 3 + first},{i % 3 + 1}, {j // 3 + first},{j % 3 + 1}, {value:.11e}"
            )
    path.write_bytes(gzip.compress(("\n".join(lines) + "\n").encode(), 9, mtime=0))


def write_part(name: str, basis: Basis, clamp: float) -> np.ndarray:
    """Matrices and nodes of one block; the places of its nodes."""
    places, first = basis.doflocs[:, ::3].T, FIRST[name]
    clamped = np.repeat(places[:, 0] == clamp, 3)
    K = linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis)
    write_abaqus(HERE / f"{name}_STIF1.mtx.gz", K, first, clamped)
    M = inertia.assemble(basis)
    write_abaqus(HERE / f"{name}_MASS1.mtx.gz", M, first, np.zeros_like(clamped))
    rows = [f"{first + n},{x:.6g},{y:.6g},{z:.6g}" for n, (x, y, z) in enumerate(places)]
    (HERE / f"{name}_nodes.csv").write_text("\n".join(["node,x,y,z", *rows]) + "\n")
    return places


def main() -> None:
    """Write all files."""
    end = 2 * LONG - LAP
    lower = write_part("lower", block(0, LONG, -THICK, 0), 0.0)
    upper = write_part("upper", block(LONG - LAP, end, 0, THICK), end)
    pairs = ["node,mate"]
    for n, place in enumerate(lower):
        (meets,) = np.nonzero(np.linalg.norm(upper - place, axis=1) < 1e-9)
        pairs += [f"{FIRST['lower'] + n},{FIRST['upper'] + m}" for m in meets]
    (HERE / "pairs.csv").write_text("\n".join(pairs) + "\n")
    middle = LONG - LAP / 2
    for name, places, outside in (("lower", lower, -THICK), ("upper", upper, THICK)):
        bolt = np.isclose(places[:, 0], middle) & (places[:, 2] == outside)
        numbers = np.flatnonzero(bolt) + FIRST[name]
        (HERE / f"{name}_bolt.csv").write_text("\n".join(["node", *map(str, numbers)]) + "\n")


if __name__ == "__main__":
    main()
