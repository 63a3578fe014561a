"""At full count, what the verifications found becomes a table in docs/verification.

A test gives its figures by `record(name, text)`.
"""

import dataclasses
from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial import KDTree
from scipy.special import iv, ivp, jv, jvp, kv, kvp, yv, yvp

from benchmarks.pages import commit
from tests.conftest import FULL, scene_of
from tests.golden.runs import made_once
from tests.verification import vane
from vanelock import rom
from vanelock.common.cyclic import turn
from vanelock.fem import assemble, cyclic_transform, eigenpairs
from vanelock.mesh import Part

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
rows: dict[str, list[tuple[str, str, str]]] = defaultdict(list)


if not FULL:

    @pytest.fixture(scope="session")
    def scene(shared: Path) -> SimpleNamespace:
        """The scene with few elements and contacts; at full count it is the common one."""
        made = made_once(shared / "small_vane.pickle", vane.small_parts)
        return scene_of(*made, vane.JOINTS)


@pytest.fixture(scope="session")
def ring_of_vanes(scene: SimpleNamespace, shared: Path) -> rom.System:
    """The scene's system with all nodal diameters of its ring."""
    place = shared / "ring_of_vanes.pickle"
    return made_once(place, lambda: vane.with_all_diameters(scene))


def lowest_frequencies(part, material, count, nodal_diameter=None, **held):
    """Lowest frequencies, Hz, of a part supported component by component.

    `lowest_frequencies(part, material, 6, x0="yz")` holds y and z of the nodes of the set x0; with
    `nodal_diameter` the part is a sector, and what is held on one cut face is held on the other.
    """
    model = assemble(part, material, fixed=None)
    T = sp.eye_array(model.K.shape[0], format="csc")
    if nodal_diameter is not None:
        T = cyclic_transform(model, nodal_diameter)
    for node_set, axes in held.items():
        rows = model.rows(node_set)[:, ["xyz".index(axis) for axis in axes]]
        T = T[:, abs(T[rows.ravel()]).sum(axis=0) < 1e-9]
    K, M = ((T.conj().T @ A @ T).tocsc() for A in (model.K, model.M))
    values, _ = eigenpairs(K, M, count, shift=-1e4)
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi)


@pytest.fixture(scope="session")
def hollow_cylinder(lattice: Callable[..., Part]) -> Callable[..., Part]:
    """Function that meshes one sector between two walls, with the node sets ends and body."""

    def build(
        counts: tuple[int, int, int],
        walls: tuple[float, float],
        length: float,
        sectors: int,
        cell_type: str = "hexahedron27",
        curved: bool = True,
    ) -> Part:
        def place(p: Array) -> Array:
            r, angle = walls[0] + (walls[1] - walls[0]) * p[:, 0], 2 * np.pi / sectors * p[:, 1]
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), length * p[:, 2]])

        part = lattice(counts, place, cell_type, curved, sectors)
        sets = {
            "left": part.node_sets["y0"],
            "right": part.node_sets["y1"],
            "ends": np.concatenate([part.node_sets["z0"], part.node_sets["z1"]]),
            "body": np.arange(len(part.points)),
        }
        return dataclasses.replace(part, node_sets=sets)

    return build


def merged(points, within=1e-9):
    """The first node (k,) at each place, and the number (n,) of each node's place."""
    near = KDTree(points).query_ball_point(points, within)
    return np.unique([min(mates) for mates in near], return_inverse=True)


def whole_ring(part):
    """All sectors merged into one part, and the numbers (N, n) of each sector's nodes in it."""
    n = part.sectors
    points = np.concatenate([part.points @ turn(n, j).T for j in range(n)])
    first, number = merged(points)
    number = number.reshape(n, -1)
    sets = {name: np.unique(number[:, nodes]) for name, nodes in part.node_sets.items()}
    cells = np.concatenate([nodes[part.cells] for nodes in number])
    ring = dataclasses.replace(part, points=points[first], cells=cells, node_sets=sets, sectors=1)
    return ring, number


def potential(square, n, r):
    """Both solutions of f'' + f'/r + (square - n²/r²) f = 0 at r, with two derivatives."""
    s = np.sqrt(np.abs(square))
    for wave, d_wave, fading, d_fading in ((jv, jvp, iv, ivp), (yv, yvp, kv, kvp)):
        f = np.where(square > 0, wave(n, s * r), fading(n, s * r))
        slope = s * np.where(square > 0, d_wave(n, s * r), d_fading(n, s * r))
        yield f, slope, (n * n / r**2 - square) * f - slope / r


def traction_determinant(omega, n, wave, walls, part, material):
    """Zero where a free motion U cos nθ sin kz, V sin nθ sin kz, W cos nθ cos kz exists.

    u = ∇φ + ∇×(ψ e_z) + ∇×∇×(χ e_z) with two Bessel functions each, or with the one that is finite
    on the axis where there is one wall only. The tractions on the walls vanish: those of φ and ψ in
    the plane where nothing varies along the axis ("plane"), that of χ along the axis then
    ("axial"), else all ("solid"). Rows and columns are scaled, which keeps the sign.
    """
    lame, shear = material.lame
    square_p = omega**2 * material.rho / (lame + 2 * shear) - wave**2
    square_s = omega**2 * material.rho / shear - wave**2
    rows = []
    for r in walls:
        columns = []  # U, U', V, V', W, W' of each function
        p, s = (list(potential(square, n, r))[: len(walls)] for square in (square_p, square_s))
        for f, d, dd in p:
            columns.append((d, dd, -n * f / r, n * (f / r - d) / r, wave * f, wave * d))
        for f, d, dd in s:
            columns.append((n * f / r, n * (d - f / r) / r, -d, -dd, 0 * f, 0 * f))
        for f, d, dd in s:
            turned = wave * n * f / r, wave * n * (d - f / r) / r
            columns.append((-wave * d, -wave * dd, *turned, square_s * f, square_s * d))
        U, dU, V, dV, W, dW = np.moveaxis(np.array(columns), 1, 0)
        rows.append(lame * (dU + (U + n * V) / r - wave * W) + 2 * shear * dU)
        rows.append(shear * (dV - (V + n * U) / r))
        rows.append(shear * (dW + wave * U))
    components = {"plane": [0, 1], "axial": [2], "solid": [0, 1, 2]}[part]
    kept = np.concatenate([np.add(components, 3 * i) for i in range(len(walls))])
    functions = np.concatenate([np.arange(len(walls)) + len(walls) * c for c in components])
    matrix = np.moveaxis(np.array(rows)[np.ix_(kept, functions)], (0, 1), (-2, -1))
    for axis in (-2, -1):
        matrix = matrix / np.max(np.abs(matrix), axis=axis, keepdims=True)
    return np.linalg.det(matrix)


def waves_within(walls, n, wave, top, material, part="solid"):
    """Frequencies below `top` [Hz] of the waves of circumferential order n and axial wave number.

    Exact: D. C. Gazis, J. Acoust. Soc. Am. 31 (1959) 568-578.
    """
    lame, shear = material.lame
    speeds = np.sqrt(np.array([shear, lame + 2 * shear]) / material.rho)
    twist, pressure = wave * speeds / (2 * np.pi)

    def function(f):
        return traction_determinant(2 * np.pi * f, n, wave, walls, part, material)

    # Where a potential turns from Bessel's functions to modified ones its columns are dependent:
    # no motion, but for the twist u_θ ∝ r, which needs no wall.
    sides = [f * (1 + e) for f in (twist, pressure) if 0 < f < top for e in (-1e-9, 1e-9)]
    grid = np.sort(np.concatenate([np.linspace(top / 2000, top, 2000), sides]))
    values = function(grid)
    change = np.flatnonzero((values[:-1] * values[1:] < 0) & (np.diff(grid) > 1e-8 * grid[1:]))
    found = [brentq(function, grid[i], grid[i + 1], xtol=1e-13 * top) for i in change]
    rigid = (n == 0 and part != "solid") + (n == 1 and part == "plane")
    return found + [0.0] * rigid + [float(twist)] * int(n == 0 and 0 < twist < top)


@lru_cache
def waves_between_diaphragms(walls, n, length, top, material):
    """The same of a cylinder whose ends slide axially and are held otherwise: a stretch of it."""
    found = waves_within(walls, n, 0.0, top, material, "axial")
    for half_waves in range(1, 100):
        more = waves_within(walls, n, half_waves * np.pi / length, top, material)
        if not more:
            return found
        found += more
    raise AssertionError("more axial orders below that frequency than were tried")


def seen_by_a_sector(nodal_diameter, sectors, of_order):
    """Frequencies of all orders that a sector sees as this nodal diameter, ascending.

    A wave of order n and its mirror image make one mode at n and one at N - n; at 0 and N/2 both
    belong to the same problem.
    """
    found = []
    for n in range(2 * sectors):
        if (n - nodal_diameter) % sectors == 0 or (n + nodal_diameter) % sectors == 0:
            twice = n > 0 and 2 * nodal_diameter % sectors == 0
            found += of_order(n) * (2 if twice else 1)
    return np.sort(found)


@pytest.fixture
def record(record_property: Callable[[str, object], None]) -> Callable[[str, object], None]:
    """Function that gives the page a figure by its name."""
    return record_property


@pytest.fixture
def below(record: Callable[[str, object], None]) -> Callable[[str, float, float], None]:
    """Function that records an error and asserts that it is below a bound."""

    def check(name: str, error: float, most: float) -> None:
        record(name, f"{error:.1e}")
        assert error < most

    return check


@pytest.fixture
def compare(record: Callable[[str, object], None]) -> Callable[..., None]:
    """Function that records frequencies, Hz, beside their targets and asserts the differences."""

    def within(
        targets: Sequence[float],
        found: Sequence[float],
        least: float,
        most: float,
        source: str = "target",
    ) -> None:
        difference = np.divide(found, targets) - 1
        pairs = zip(found, targets, difference, strict=True)
        text = ", ".join(f"{f:.5g} Hz ({t:.5g}, {d:+.2%})" for f, t, d in pairs)
        record(f"found ({source})", text)
        assert np.all(difference > least)
        assert np.all(difference < most)

    return within


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if FULL and (report.when == "call" or report.failed) and "verification" in report.nodeid:
        file, _, name = report.nodeid.partition("::")
        figures = "; ".join(f"{key} {value}" for key, value in report.user_properties)
        rows[Path(file).stem.removeprefix("test_")].append((name, figures, report.outcome))


def pytest_sessionfinish(session: pytest.Session) -> None:
    if not FULL or hasattr(session.config, "workerinput"):
        return
    folder = ROOT / "docs" / "verification"
    folder.mkdir(parents=True, exist_ok=True)
    for page, found in rows.items():
        passed = sum(outcome == "passed" for *_, outcome in found)
        lines = [
            f"# Verification: {page.replace('_', ' ')}\n",
            f"Written by `make verify` at commit {commit()}: {passed} of {len(found)} passed.\n",
            "| test | figures | outcome |",
            "|---|---|---|",
            *(f"| `{name}` | {figures} | {outcome} |" for name, figures, outcome in sorted(found)),
            "",
        ]
        (folder / f"{page}.md").write_text("\n".join(lines))
