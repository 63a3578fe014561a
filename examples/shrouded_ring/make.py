"""Write the matrices of one sector of a bladed ring whose shrouds touch, as SciPy saves them.

A sector of twelve: a piece of disk, clamped at its bore, a blade, and at its tip a shroud that
meets the next blade's. The faces of the disk are cyclic; those of the shrouds are in contact.
Twenty-node bricks in polar levels, in m, kg and N.

    python examples/shrouded_ring/make.py
"""

import io
import zipfile
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from skfem import Basis, BilinearForm, ElementHexS2, ElementVector, MeshHex
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

HERE = Path(__file__).parent
SECTORS = 12
MODULUS, POISSON, DENSITY = 200e9, 0.3, 7850.0  # Pa, -, kg/m^3
RADII = np.array([0.10, 0.115, 0.145, 0.175, 0.205, 0.211])  # m: bore, rim, blade, shroud
HALF = np.pi / SECTORS
ANGLES = np.array([-HALF, -0.35 * HALF, 0.35 * HALF, HALF])
DEPTH = np.array([-0.004, 0.004])  # m, along the axis
DISK, BLADE, SHROUD = RADII[1], ANGLES[2], RADII[-2]


def sector() -> Basis:
    """Bricks of disk, blade and shroud, from a grid of radius, angle and depth."""
    grid = MeshHex.init_tensor(RADII, ANGLES, DEPTH)
    radius, angle, _ = grid.p[:, grid.t].mean(axis=1)
    kept = (radius < DISK) | (np.abs(angle) < BLADE) | (radius > SHROUD)
    grid = grid.restrict(np.flatnonzero(kept))
    r, a, z = grid.p
    bent = MeshHex(np.array([r * np.cos(a), r * np.sin(a), z]), grid.t)
    return Basis(bent, ElementVector(ElementHexS2()), intorder=4)


@BilinearForm
def inertia(u, v, _):  # type: ignore[no-untyped-def]
    """Density times the product of displacements."""
    return DENSITY * dot(u, v)


def save(path: Path, matrix: sp.sparray) -> None:
    """As scipy.sparse.save_npz, with the same bytes every time."""
    matrix = matrix.tocsr()
    matrix.data[np.abs(matrix.data) < 1e-13 * np.abs(matrix.data).max()] = 0.0
    matrix.eliminate_zeros()
    matrix = (0.5 * (matrix + matrix.T)).tocsr()
    parts = {"format": np.array(b"csr"), "shape": np.array(matrix.shape), "data": matrix.data}
    parts |= {"indices": matrix.indices, "indptr": matrix.indptr}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, part in parts.items():
            held = io.BytesIO()
            np.lib.format.write_array(held, part, allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), held.getvalue(), zipfile.ZIP_DEFLATED)


def main() -> None:
    """Write all files."""
    basis = sector()
    save(HERE / "K.npz", linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis))
    save(HERE / "M.npz", inertia.assemble(basis))
    places = basis.doflocs[:, ::3].T
    rows = [f"{n + 1},{x:.9g},{y:.9g},{z:.9g}" for n, (x, y, z) in enumerate(places)]
    (HERE / "nodes.csv").write_text("\n".join(["node,x,y,z", *rows]) + "\n")

    radius, angle = np.hypot(*places[:, :2].T), np.arctan2(places[:, 1], places[:, 0])
    low, high = np.isclose(angle, -HALF), np.isclose(angle, HALF)
    bore, disk = radius < 0.101, radius < DISK + 1e-3

    def numbers(chosen: np.ndarray) -> np.ndarray:
        """Nodes in the order of radius and depth, the same on both faces."""
        found = np.flatnonzero(chosen)
        return found[np.lexsort((places[found, 2].round(9), radius[found].round(9)))] + 1

    lists = {
        "bore": bore,
        "low": low & disk & ~bore,
        "high": high & disk & ~bore,
        "tip": np.isclose(radius, RADII[-1], atol=1e-5)
        & np.isclose(np.abs(angle), 0.35 * HALF)
        & (places[:, 2] > 0)
        & (angle > 0),
    }
    for name, chosen in lists.items():
        (HERE / f"{name}.csv").write_text("\n".join(["node", *map(str, numbers(chosen))]) + "\n")
    # The high face of a shroud meets the low face of the next one, whose normal is its own.
    mine, theirs = numbers(high & ~disk), numbers(low & ~disk)
    normal = f"{-np.sin(HALF):.12g},{np.cos(HALF):.12g},0"
    table = [f"{a},{b},{normal},0,0,1" for a, b in zip(mine, theirs, strict=True)]
    (HERE / "shroud.csv").write_text("\n".join(["node,mate,nx,ny,nz,tx,ty,tz", *table]) + "\n")


if __name__ == "__main__":
    main()
