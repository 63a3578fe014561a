"""Write the matrices of the Brake-Reuss beam, whole: two halves with a lap joint of three bolts.

Each half is a square bar that is half as thick over the lap; turned by half a turn about the middle
of the lap, one is the other, so that their nodes meet there. Bricks of 27 nodes, whose faces press
evenly; the nodes' shares of the area are in the table of pairs. The bolts have no stiffness: they
press the rings under their washers.

    python examples/brake_reuss/make.py

writes 534 pairs and matrices of 58,698 rows of each half, 70 MB, in a quarter of a minute, beside
scene.toml.

Length: Chen et al., Mechanical Systems and Signal Processing 166 (2022) 108401. Modulus, area of
the lap less its bores, and bolt forces: Porter and Brake, ibid. 192 (2023) 110210, and the example
of their program tmdsimpy.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree
from skfem import Basis, ElementHex2, FacetBasis, LinearForm, MeshHex

HERE = Path(__file__).parent
MODULUS, POISSON, DENSITY = 192.31e9, 0.3, 7784.0  # Pa, -, kg/m^3
LENGTH, LAP, SIDE = 0.72, 0.12, 25.4e-3  # m: whole, of the overlap, of the square section
APART, BORE, WASHER = 0.03, 3.67e-3, 8e-3  # m: of the bolts, radii
NORMAL, TANGENTIAL = 1e12, 0.8e12  # N/m^3 of the asperities
CORNERS = ((0, 0), (0, 1), (3, 0), (1, 0), (3, 1), (1, 1), (2, 0), (2, 1))
"""Corners of a brick in the order of scikit-fem: which of a quadrilateral's, and at which level."""


def rectangle(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(q, 4, 2) corners of quadrilaterals between lines x and y, m."""
    p = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    return np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=2).reshape(-1, 4, 2)


def round_bolt(middle: float, divisions: int) -> np.ndarray:
    """(q, 4, 2) corners of quadrilaterals in a rectangle with a bore, m."""
    along, side = np.linspace(0, 1, divisions + 1)[:-1], np.array([APART, SIDE]) / 2
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side
    edge = np.concatenate(
        [
            a + along[:, None] * (b - a)
            for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)
        ]
    )
    unit = edge / np.linalg.norm(edge, axis=1)[:, None]
    centre = np.array([middle, SIDE / 2])
    p = centre + np.stack([BORE * unit, WASHER * unit, edge])
    q = np.roll(p, -1, axis=1)
    return np.stack([p[:-1], p[1:], q[1:], q[:-1]], axis=2).reshape(-1, 4, 2)


def plan(columns: int, divisions: int) -> np.ndarray:
    """(q, 4, 2) corners of quadrilaterals of the left half and the lap, seen from above, m."""
    y, first = np.linspace(0, SIDE, divisions + 1), (LENGTH - LAP) / 2
    middle, reach = LENGTH / 2, 1.5 * APART
    bolts = [round_bolt(middle + APART * k, divisions) for k in (-1, 0, 1)]
    ends = [
        np.linspace(*span, 3) for span in ((first, middle - reach), (middle + reach, first + LAP))
    ]
    bar = rectangle(np.linspace(0, first, columns + 1), y)
    return np.concatenate([bar, *(rectangle(x, y) for x in ends), *bolts])


def left_half(columns: int, divisions: int, layers: int) -> MeshHex:
    """Bricks of the half whose lap lies above z = 0."""
    flat = plan(columns, divisions)
    thick = flat[flat[:, :, 0].mean(axis=1) < (LENGTH - LAP) / 2]
    bricks = []
    for quads, span in ((flat, (0, SIDE / 2)), (thick, (-SIDE / 2, 0))):
        z = np.linspace(*span, layers + 1)
        for levels in pairwise(z):
            each = [
                np.column_stack([quads[:, c], np.full(len(quads), levels[at])]) for c, at in CORNERS
            ]
            bricks.append(np.stack(each, axis=1))
    corners = np.concatenate(bricks)
    points, cells = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return MeshHex(points.T.copy(), cells.reshape(-1, 8).T.copy())


def assembled(basis: Basis) -> tuple[sp.csr_array, sp.csr_array]:
    """Stiffness and mass, rows x, y, z of each node."""
    values = np.stack([np.asarray(each[0]) for each in basis.basis], axis=1)  # e, i, q
    slopes = np.stack([each[0].grad for each in basis.basis]).transpose(2, 0, 1, 3)  # e, i, a, q
    e, n, _, q = slopes.shape
    flat = slopes.reshape(e, 3 * n, q)
    pairs = (flat * basis.dx[:, None]) @ flat.transpose(0, 2, 1)
    pairs = pairs.reshape(e, n, 3, n, 3)
    shear, bulk = MODULUS / (2 + 2 * POISSON), MODULUS * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    K = bulk * pairs + shear * pairs.transpose(0, 1, 4, 3, 2)
    K += shear * np.einsum("eicjc,ab->eiajb", pairs, np.eye(3))
    mass = (values * basis.dx[:, None]) @ values.transpose(0, 2, 1)
    M = DENSITY * np.einsum("eij,ab->eiajb", mass, np.eye(3))
    rows = (3 * basis.element_dofs.T[:, :, None] + np.arange(3)).reshape(e, -1)
    at = np.repeat(rows, 3 * n, axis=1).ravel(), np.tile(rows, 3 * n).ravel()
    each = [sp.csr_array(sp.coo_array((A.ravel(), at))) for A in (K, M)]
    for A in each:
        A.eliminate_zeros()
    return each[0], each[1]


def write_nodes(name: str, chosen: np.ndarray) -> None:
    """A list of nodes."""
    numbers = np.flatnonzero(chosen) + 1
    (HERE / f"{name}.csv").write_text("\n".join(["node", *map(str, numbers)]) + "\n")


def main(columns: int = 48, divisions: int = 4, layers: int = 4) -> None:
    """Write all files, of elements along the bar, across it and through half of it."""
    mesh = left_half(columns, divisions, layers)
    basis = Basis(mesh, ElementHex2(), intorder=4)
    K, M = assembled(basis)
    turn = sp.diags_array(np.tile([-1.0, 1.0, -1.0], K.shape[0] // 3))
    left = basis.doflocs.T
    places = {"left": left, "right": left * [-1, 1, -1] + [LENGTH, 0, 0]}
    for name, stiffness in (("left", K), ("right", turn @ K @ turn)):
        sp.save_npz(HERE / f"{name}_K.npz", sp.csr_array(stiffness))
        rows = [f"{n},{x:.9g},{y:.9g},{z:.9g}" for n, (x, y, z) in enumerate(places[name], 1)]
        (HERE / f"{name}_nodes.csv").write_text("\n".join(["node,x,y,z", *rows]) + "\n")
    sp.save_npz(HERE / "M.npz", M)  # of both
    lap = mesh.facets_satisfying(lambda x: np.isclose(x[2], 0), boundaries_only=True)
    share = LinearForm(lambda v, _: v).assemble(FacetBasis(mesh, ElementHex2(), facets=lap))
    (own,) = np.nonzero(share > 1e-6 * share.max())
    _, mate = cKDTree(places["right"]).query(places["left"][own], distance_upper_bound=1e-9)
    lines = [
        f"{a + 1},{b + 1},{NORMAL * share[a]:.6g},{TANGENTIAL * share[a]:.6g}"
        for a, b in zip(own, mate, strict=True)
    ]
    (HERE / "pairs.csv").write_text("\n".join(["node,mate,kn,kt", *lines]) + "\n")
    x, y, z = left.T
    pressed = [
        np.hypot(x - LENGTH / 2 - APART * k, y - SIDE / 2) < WASHER + 1e-9 for k in (-1, 0, 1)
    ]
    write_nodes("washers", np.any(pressed, axis=0) & np.isclose(z, SIDE / 2))
    write_nodes("tip", np.isclose(x, 0) & np.isclose(y, SIDE / 2) & np.isclose(z, 0))


if __name__ == "__main__":
    main()
