"""Small structured meshes built without a mesher, and the scene of the vane."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import meshio
import numpy as np
import pytest

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.golden.runs import GoldenRun, golden_run, made_once
from tests.mesh.files.archives import degenerated
from vanelock import fem, mesh, rom
from vanelock.mesh import Part
from vanelock.mesh.gmsh_session import session
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages, Step
from vanelock.stages.parts.segment import Joint, Segment

Place = Callable[[np.ndarray], np.ndarray]
FULL = os.environ.get("VANELOCK_VERIFY") == "full"


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of this test run, the same for all of its processes."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session")
def golden(shared: Path) -> Callable[[str], GoldenRun]:
    """Function that gives a golden run by its name; read it, and leave its folder as it is.

    VANELOCK_GOLDEN names a folder where they may be already, for work on a test.
    """
    place = Path(os.environ.get("VANELOCK_GOLDEN", shared / "golden"))
    return lru_cache(lambda name: golden_run(name, place))


@pytest.fixture(scope="session", autouse=True)
def steps_once(shared: Path) -> Iterator[None]:
    """Runs of all processes compute meshes, parts and linear responses once for each key.

    All else of a stage is as ever: what it needs, what it reports, and that it goes into the cache.
    """
    cache = Cache(shared / "steps", print)
    recent: dict[str, Any] = {}
    computed = Stages._computed

    def once(stages: Stages, step: Step[Any]) -> tuple[Any, float, float]:
        def compute(*given: Any) -> Any:
            product = recent.pop(step.key) if step.key in recent else None
            if (
                product is None
                and step.is_kept
                and (there := cache.load(name, step.key, step.kind))
            ):
                product = there.product
            if product is None:
                product = step.compute(*given)
                if step.is_kept:
                    product = cache.store(name, step.key, product, 0.0).product
            recent[step.key] = product
            if len(recent) > MOST:
                del recent[next(iter(recent))]
            return product

        name = step.stage
        once = name.startswith(ONCE) and not (step.pulls or step.resumes)
        return computed(stages, replace(step, compute=compute) if once else step)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Stages, "_computed", once)
        yield


ONCE = ("mesh ", "fem ", "rom ", "linear ")
"""How the names of the steps begin that are computed once."""
MOST = 24
"""Products that are remembered."""

# The six tetrahedra of a box (Kuhn): paths along the axes from its lowest to its highest corner.
# Neighbouring boxes, and the two faces of a mapped sector, are cut along the same diagonals.
_PATHS = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
_HEXA = np.array(
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]]
)
_HEXA_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
_HEXA_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
_HEXA_REST = np.array([[0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2], [1, 1, 1]])


def _tetrahedra() -> np.ndarray:
    """(6, 10, 3) nodes of a box's tetrahedra in half steps, positively oriented."""
    cells = []
    for path in _PATHS:
        corners = [np.zeros(3, int)]
        for axis in path:
            corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
        if np.linalg.det(np.diff(corners, axis=0)) < 0:
            corners[1], corners[2] = corners[2], corners[1]
        cells.append(corners + [(corners[a] + corners[b]) // 2 for a, b in _EDGES])
    return np.array(cells)


def _hexahedron() -> np.ndarray:
    middles = [(_HEXA[a] + _HEXA[b]) // 2 for a, b in _HEXA_EDGES]
    return np.vstack([_HEXA, middles, _HEXA_REST])[None]


_NODES = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27}


@pytest.fixture(scope="session")
def lattice() -> Callable[..., Part]:
    """Function that meshes the unit cube, mapped by `place`, with `counts` boxes a side.

    Its parts have the node sets x0, x1, y0, y1, z0, z1: the faces of the unit cube, each in the
    order of the other two coordinates. Straight-sided unless `curved`.
    """

    def build(
        counts: tuple[int, int, int],
        place: Place = lambda p: p,
        cell_type: str = "tetra10",
        curved: bool = False,
        sectors: int = 1,
    ) -> Part:
        tetra = cell_type.startswith("tetra")
        local = (_tetrahedra() if tetra else _hexahedron())[:, : _NODES[cell_type]]
        boxes = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
        index = 2 * boxes[:, None, None] + local  # (boxes, cells, nodes, 3)
        index = index.reshape(-1, *local.shape[1:])
        used, cells = np.unique(index.reshape(-1, 3), axis=0, return_inverse=True)
        cells = cells.reshape(index.shape[:2])
        steps = used / (2 * np.array(counts))
        points = place(steps)
        if not curved:
            if tetra:
                for m, (a, b) in enumerate(_EDGES[: cells.shape[1] - 4]):
                    points[cells[:, 4 + m]] = (points[cells[:, a]] + points[cells[:, b]]) / 2
            else:  # a straight-sided hexahedron is the trilinear image of its corners
                r = (local[0] / 2)[:, None]
                corner = np.prod(np.where(_HEXA / 2 == 1, r, 1 - r), axis=2)
                points[cells] = np.einsum("ac,eci->eai", corner, points[cells[:, :8]])
        sets = {
            f"{axis}{side}": np.flatnonzero(used[:, i] == side * 2 * counts[i])
            for i, axis in enumerate("xyz")
            for side in (0, 1)
        }
        return Part(cell_type, points, cells, cell_type, sets, {}, sectors)

    return build


JOINTS = (
    Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6),
    Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6),
)
VANE_MASTERS = ("hook_front", "hook_rear", "interlock_left", "interlock_right", "key", "output")
CASING_MASTERS = ("hook_front", "hook_rear", "key", "force", "output")


def scene_of(models, vane, casing, joints) -> SimpleNamespace:
    """Models and components, their system under 30 N, and the truth of the unreduced sector."""
    system = Segment(joints, 1, force=30.0, damping_ratio=0.003).join(vane, casing)

    @lru_cache
    def truth(k, interlock):
        """Six frequencies, Hz, and vectors of the unreduced sector."""
        closed = joints if interlock == "closed" else joints[:1]
        omega2, vectors = fem.eigenpairs(*unreduced(*models, closed, k), 6)
        return np.sqrt(omega2) / (2 * np.pi), vectors

    return SimpleNamespace(
        truth=truth,
        vane_model=models[0],
        casing_model=models[1],
        vane=vane,
        casing=casing,
        system=system,
        joints=joints,
        joined_dofs=next(iter(system.diameters.values())).parts[vane.masters.part],
        interlock=np.array([name == "interlock" for name in system.contacts.joint]),
    )


@pytest.fixture(scope="session")
def scene(coarse):
    """Models, components and system of the scene: coarse, or medium at full count."""
    parts = coarse
    if FULL:
        parts = mesh.vane_segment(size="medium"), mesh.casing_sector(size="medium")
    steel = fem.Material(E=170e9, nu=0.3, rho=8200)
    vane_model, casing_model = (fem.assemble(part, steel) for part in parts)
    vane = rom.reduce(vane_model, VANE_MASTERS)
    casing = rom.reduce(
        casing_model, CASING_MASTERS, nodal_diameters=[0, 1, 2, 3, 8], band=vane.band
    )
    return scene_of((vane_model, casing_model), vane, casing, JOINTS)


_ABAQUS = {
    "tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20R",
    "hexahedron27": "C3D27",
}  # fmt: skip
# Abaqus lists the middle of a hexahedron before those of its faces, S1 to S6.
_TO_ABAQUS = {"hexahedron27": [*range(20), 26, 24, 25, 22, 21, 23, 20]}
# Nastran lists a hexahedron's upright sides before those of its top.
_TO_NASTRAN = {"hexahedron20": [*range(12), *range(16, 20), *range(12, 16)]}


def _shuffled(part: Part, seed: int) -> SimpleNamespace:
    """A part in mm, its nodes, elements and sets in another order, its nodes' numbers with gaps."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(part.points))
    new = np.argsort(order)
    return SimpleNamespace(
        points=1e3 * part.points[order],
        cells=new[part.cells][random.permutation(len(part.cells))],
        sets={name: random.permutation(new[nodes]) for name, nodes in part.node_sets.items()},
        numbers=1000 + np.sort(random.choice(5 * len(order), len(order), replace=False)),
    )


def _in_lines(words, count):
    """Comma-separated lines of a deck, of so many words each."""
    words = [str(word) for word in words]
    return [", ".join(words[i : i + count]) for i in range(0, len(words), count)]


def _write_abaqus(path, part, seed=1):
    given = _shuffled(part, seed)
    lines = ["*HEADING", "** a part", "*NODE"]
    places = zip(given.numbers.tolist(), given.points.tolist(), strict=True)
    lines += [f"{n}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in places]
    lines.append(f"*Element, type={_ABAQUS[part.cell_type]}, elset=solid")
    cells = given.cells[:, _TO_ABAQUS.get(part.cell_type, slice(None))]
    for number, nodes in enumerate(given.numbers[cells].tolist(), start=7):
        rows = _in_lines([number, *nodes], 8)
        lines += [*(row + "," for row in rows[:-1]), rows[-1]]
    for name, nodes in given.sets.items():
        lines += [f"*NSET, NSET={name}", *_in_lines(given.numbers[nodes], 16)]
    path.write_text("\n".join(lines) + "\n")
    return {}


def _write_nastran(path, part, seed=2):
    """Odd sets in the case control, even ones in the bulk data; returns their numbers."""
    given = _shuffled(part, seed)
    case, bulk = ["SOL 103", "CEND"], ["BEGIN BULK"]
    for n, place in zip(given.numbers.tolist(), given.points.tolist(), strict=True):
        x, y, z = (f"{value:16.13f}"[:16] for value in place)
        bulk += [f"GRID*   {n:16d}{'':16}{x}{y}*", f"*       {z}"]
    name = "CTETRA" if part.cell_type.startswith("tetra") else "CHEXA"
    cells = given.cells[:, _TO_NASTRAN.get(part.cell_type, slice(None))]
    for number, nodes in enumerate(given.numbers[cells].tolist(), start=7):
        fields = [f"{value:8d}" for value in (number, 1, *nodes)]
        bulk.append(f"{name:8}" + "".join(fields[:8]))
        bulk += ["+       " + "".join(fields[i : i + 8]) for i in range(8, len(fields), 8)]
    for number, nodes in enumerate(given.sets.values(), start=1):
        own = given.numbers[nodes].tolist()
        if number % 2:
            rows = _in_lines(own, 8)
            case += [f"SET {number} = " + ",\n".join(rows)]
        else:
            bulk += [f"SET1,{number},{row}" if i == 0 else f",{row}" for i, row in _set1(own)]
    path.write_text("\n".join([*case, *bulk, "ENDDATA"]) + "\n")
    return {name: str(number) for number, name in enumerate(given.sets, start=1)}


def _set1(numbers):
    """Rows of a SET1 card: seven numbers follow its own, eight a continuation's comma."""
    return enumerate([",".join(map(str, numbers[:7])), *_in_lines(numbers[7:], 8)])


def _write_msh(path, part, seed=3):
    given = _shuffled(part, seed)
    mesh.write_msh(
        path, replace(part, points=given.points, cells=given.cells, node_sets=given.sets)
    )
    return {}


def _write_gmsh(path, part, seed=4):
    """By gmsh itself, the sets as physical points."""
    given = _shuffled(part, seed)
    to_gmsh = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
    with session(part.name) as gmsh:
        model = gmsh.model
        model.addDiscreteEntity(3, 1)
        model.mesh.addNodes(3, 1, given.numbers, given.points.ravel())
        cells = given.numbers[given.cells[:, to_gmsh]].ravel()
        model.mesh.addElementsByType(1, gmsh.model.mesh.getElementType("Tetrahedron", 2), [], cells)
        model.addPhysicalGroup(3, [1], name="solid")
        for i, (name, nodes) in enumerate(given.sets.items(), start=1):
            model.addDiscreteEntity(0, i)
            model.mesh.addElementsByType(
                i, model.mesh.getElementType("Point", 1), [], given.numbers[nodes]
            )
            model.addPhysicalGroup(0, [i], name=name)
        gmsh.write(str(path))
    return {}


def _write_vtu(path, part, seed=5):
    given = _shuffled(part, seed)
    fields = {name: np.zeros(len(given.points), np.uint8) for name in given.sets}
    for name, nodes in given.sets.items():
        fields[name][nodes] = 1
    meshio.Mesh(given.points, [(part.cell_type, given.cells)], point_data=fields).write(path)
    return {}


def _write_cdb(path, part, seed=6):
    given = _shuffled(part, seed)
    degenerated(
        path, replace(part, points=1e-3 * given.points, cells=given.cells, node_sets=given.sets)
    )
    return {}


@pytest.fixture(scope="session")
def write_mesh() -> Callable[..., dict[str, str]]:
    """Function that writes a part to a file, in mm and shuffled, and returns its sets' names.

    The file's ending decides the format; ".gmsh.msh" is written by gmsh itself.
    """
    writers = {
        ".inp": _write_abaqus,
        ".bdf": _write_nastran,
        ".gmsh.msh": _write_gmsh,
        ".msh": _write_msh,
        ".vtu": _write_vtu,
        ".cdb": _write_cdb,
    }

    def write(path, part, **options):
        ending = next(ending for ending in writers if path.name.endswith(ending))
        return writers[ending](path, part, **options)

    return write


@pytest.fixture(scope="session")
def coarse(shared: Path) -> tuple[Part, Part]:
    """The program's coarse vane and casing."""
    return made_once(
        shared / "coarse.pickle",
        lambda: (mesh.vane_segment(size="coarse"), mesh.casing_sector(size="coarse")),
    )
