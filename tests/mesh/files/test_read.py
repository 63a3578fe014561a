"""Mesh files written and read back, by Gmsh and meshio too."""

import meshio
import numpy as np
import pytest

from tests.mesh.conftest import refusal
from tests.mesh.files.conftest import GRIDS, complaint, same
from vanelock.common.errors import InputError
from vanelock.mesh import Part, read_mesh, write_msh
from vanelock.mesh.cells import SOLIDS, solid, surface
from vanelock.mesh.files.nastran import read_nastran
from vanelock.mesh.gmsh_session import session

TYPES = {
    ".inp": SOLIDS, ".bdf": ("tetra", "tetra10", "hexahedron", "hexahedron20"), ".msh": SOLIDS,
    ".gmsh.msh": ("tetra10",), ".vtu": SOLIDS,
}  # fmt: skip
CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


@pytest.mark.parametrize(
    ("ending", "cell_type"), [(ending, kind) for ending, kinds in TYPES.items() for kind in kinds]
)
def test_reads_back(tmp_path, ring, write_mesh, ending, cell_type):
    part = ring(cell_type)
    path = tmp_path / f"part{ending}"
    called = write_mesh(path, part)
    found = read_mesh(path, "mm")
    assert found.cell_type == cell_type
    same(part, found, called, 1e-13 * 0.6)
    assert ending != ".gmsh.msh" or found.numbers.min() >= 1000  # gmsh's own numbers


def test_middle_nodes_in_another_order_are_put_right(tmp_path, ring):
    """Abaqus's order in a VTK file: the coordinates decide which node belongs to which side."""
    part = ring("hexahedron27")
    wrong = part.cells[:, [*range(8), *np.roll(np.arange(8, 27), 5)]]
    path = tmp_path / "part.vtu"
    meshio.Mesh(part.points, [("hexahedron27", wrong)]).write(path)
    found = read_mesh(path)
    assert np.array_equal(found.cells, part.cells)


def test_set_keeps_the_order_of_a_deck(tmp_path):
    path = tmp_path / "one.inp"
    path.write_text(
        "\ufeff*NODE, NSET=all\n5, 0,0,0\n6, 1,0,0\n7, 0,1,0\n8, 0,0,1\n9, 3,3,3\n"
        "*ELEMENT, TYPE=C3D4, ELSET=solid\n1, 5,6,7,8\n*NSET, NSET=Some\n8, 6\n"
        "*NSET, NSET=some\n5\n*NSET, NSET=steps, GENERATE\n5, 7, 2\n"
        "*NSET, NSET=both\nsteps, 6\n*NSET, NSET=of, ELSET=solid\n"
        "*SURFACE, NAME=faces\nsolid, S2\n1, S3\n*SURFACE, NAME=few, TYPE=NODE\nsome, 1.\n7\n"
        "*NODE PRINT\n*STEP\n"
    )
    found = read_mesh(path)
    numbers = {name: found.numbers[nodes].tolist() for name, nodes in found.node_sets.items()}
    assert numbers == {
        "ALL": [5, 6, 7, 8],
        "SOME": [8, 6, 5],
        "STEPS": [5, 7],
        "BOTH": [5, 7, 6],
        "OF": [5, 6, 7, 8],
        "SOLID": [5, 6, 7, 8],
        "FACES": [5, 6, 8, 7],
        "FEW": [8, 6, 5, 7],
    }
    faces = {frozenset(found.numbers[face].tolist()) for face in found.face_sets["FACES"]}
    assert faces == {frozenset({5, 6, 8}), frozenset({6, 7, 8})}
    assert found.absent["ALL"].tolist() == [9]
    found.save(tmp_path / "one.h5")
    again = type(found).load(tmp_path / "one.h5")
    assert np.array_equal(again.cells, found.cells)
    assert again.node_sets.keys() == found.node_sets.keys()


def test_abaqus_faces_are_those_of_the_cube(tmp_path):
    """S1 to S6 of a unit cube, with the middle nodes: the manual's faces by their centres."""
    steps = solid("hexahedron20").nodes
    path = tmp_path / "cube.inp"
    nodes = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(steps.tolist(), 1))
    faces = "".join(f"*SURFACE, NAME=F{i}\n1, S{i}\n" for i in range(1, 7))
    path.write_text(
        f"*NODE\n{nodes}*ELEMENT, TYPE=C3D20\n1, {', '.join(map(str, range(1, 16)))},\n"
        f"16, 17, 18, 19, 20\n{faces}"
    )
    found = read_mesh(path)
    centres = [found.points[found.node_sets[f"F{i}"]].mean(axis=0) for i in range(1, 7)]
    wanted = [[0.5, 0.5, 0], [0.5, 0.5, 1], [0.5, 0, 0.5], [1, 0.5, 0.5], [0.5, 1, 0.5]]
    assert np.abs(centres - np.array([*wanted, [0, 0.5, 0.5]])).max() < 1e-15
    assert [len(found.node_sets[f"F{i}"]) for i in range(1, 7)] == [8] * 6


@pytest.mark.parametrize(("card", "nodes"), [
    ("SET1,7,1,THRU,3", [1, 2, 3]), ("SET1    7       4       1       THRU    2", [4, 1, 2]),
    ("SET1*   7               4               2               1\n*       3", [4, 2, 1, 3]),
    ("SET1,7,1,2,3,4,5,6,7,+A\n+A,8,9", [1, 2, 3, 4, 5, 6, 7, 8, 9]),
    ("SET3,7,GRID,4,3", [4, 3]), ("SET3,7,ELEM,4,3", None),
    ("SET 7 = 1 THRU 9 EXCEPT 3, 5, 12", [1, 2, 4, 6, 7, 8, 9, 12]),
    ("SET 7 = 4,\n  2, 3", [4, 2, 3]), ("set 7 = 1 thru 9 by 4", [1, 5, 9]),
])  # fmt: skip
def test_nastran_sets(card, nodes):
    raw = read_nastran("deck", f"{card}\n{GRIDS}")
    found = raw.node_sets.get("7")
    assert (None if found is None else found.tolist()) == nodes


@pytest.mark.parametrize(("card", "place"), [
    ("GRID,9,,1.5-3,-2.+1,7.", (1.5e-3, -20.0, 7.0)),
    ("GRID    9               1.5-3   -2.+1   7.0E0", (1.5e-3, -20.0, 7.0)),
    ("GRID    9               1.      -.5D1", (1.0, -5.0, 0.0)),
    ("GRID*   9                               1.234567890123-1 2.\n*       -3.", None),
    ("GRID*,9,,.1234567890123,2.\n*,-3.", None),
])  # fmt: skip
def test_nastran_numbers(card, place):
    raw = read_nastran("deck", f"BEGIN BULK\n{card}  $ a comment\nENDDATA\nnothing")
    assert raw.numbers.tolist() == [9]
    assert tuple(raw.points[0]) == (place or (0.1234567890123, 2.0, -3.0))


def test_what_is_not_solid_serves_sets_only(tmp_path):
    """Shells on a face make a set of it; nodes that no solid uses are dropped."""
    points = np.vstack([CUBE, [[5.0, 5.0, 5.0]]])
    cells = [("hexahedron", np.arange(8)[None]), ("quad", np.array([[0, 1, 2, 3]]))]
    path = tmp_path / "cube.msh"
    tags = [np.array([1]), np.array([2])]
    names = {"body": np.array([1, 3]), "low": np.array([2, 2])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    meshio.Mesh(points, cells, cell_data=data, field_data=names).write(path, file_format="gmsh22")
    found = read_mesh(path)
    assert len(found.points) == 8
    assert sorted(found.points[found.node_sets["low"]].tolist()) == sorted(CUBE[:4].tolist())
    assert len(found.face_sets["low"]) == 1


def test_paths_and_units(tmp_path, ring):
    assert complaint(tmp_path / "none.inp") == "none.inp: no such file"
    folder = tmp_path / "folder.inp"
    folder.mkdir()
    assert complaint(folder) == "folder.inp: is a folder, a mesh file is needed"
    path = tmp_path / "part.msh"
    write_msh(path, ring())
    size = np.ptp(read_mesh(path).points, axis=0)
    assert np.allclose(np.ptp(read_mesh(path, "inch").points, axis=0), 0.0254 * size, rtol=1e-14)
    assert 'unit = "kg": expected a unit of length' in refusal(lambda: read_mesh(path, unit="kg"))


@pytest.mark.parametrize("cell_type", SOLIDS)
def test_reference_cells(cell_type):
    """Shape functions are one at their node; the faces look outwards and close the cell."""
    cell = solid(cell_type)
    assert np.abs(cell.functions(cell.nodes)[0] - np.eye(len(cell.nodes))).max() < 1e-12
    middle = cell.nodes[: cell.corners].mean(axis=0)
    for face in cell.faces:
        flat = surface(len(face))
        tangents = np.einsum("kx,qkd->qdx", cell.nodes[face], flat.functions(flat.nodes)[1])
        normal = np.cross(tangents[:, 0], tangents[:, 1])
        assert (np.sum(normal * (cell.nodes[face] - middle), axis=1) > 0).all()


def read_by_gmsh(path):
    """Coordinates by node tag, node tags of the elements, and of each physical group by name."""
    with session("test") as gmsh:
        gmsh.open(str(path))
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        points = np.full((int(tags.max()) + 1, 3), np.nan)
        points[np.asarray(tags, int)] = np.reshape(coordinates, (-1, 3))
        (kind,) = gmsh.model.mesh.getElementTypes(3)
        elements, nodes = gmsh.model.mesh.getElementsByType(kind)
        determinants = gmsh.model.mesh.getElementQualities(elements, "minDetJac")
        groups = {}
        for dim, group in gmsh.model.getPhysicalGroups():
            (entity,) = gmsh.model.getEntitiesForPhysicalGroup(dim, group)
            _, _, held = gmsh.model.mesh.getElements(dim, entity)
            groups[dim, gmsh.model.getPhysicalName(dim, group)] = np.concatenate(held)
    return points, np.reshape(nodes, (len(elements), -1)).astype(int), groups, determinants


def bent(part):
    """The part with its circles a little out of round, so that no two nodes are exchangeable."""
    x, y, z = part.points.T
    points = np.column_stack([x + 0.1 * y * z, y + 0.05 * x**2, z + 0.1 * x * y])
    return Part(part.name, points, part.cells, part.cell_type, part.node_sets, {}, part.sectors)


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_gmsh_and_meshio_read_the_same_elements(lattice, tmp_path, cell_type):
    part = bent(lattice((2, 2, 2), cell_type=cell_type))
    path = write_msh(tmp_path / "made" / "part.msh", part)
    points, elements, _, determinants = read_by_gmsh(path)
    np.testing.assert_array_equal(points[1:], part.points)  # node numbers count from 1
    read = meshio.read(path)
    assert read.cells[0].type == cell_type
    np.testing.assert_array_equal(read.points[read.cells[0].data], part.points[part.cells])
    assert determinants.min() > 0
    corners = 4 if cell_type.startswith("tetra") else 8
    np.testing.assert_array_equal(elements[:, :corners] - 1, part.cells[:, :corners])
    np.testing.assert_array_equal(np.sort(elements - 1), np.sort(part.cells))


def test_sets_come_back_in_their_order(coarse, tmp_path):
    part, _ = coarse
    path = write_msh(tmp_path / "vane.msh", part)
    _, _, groups, determinants = read_by_gmsh(path)
    assert set(groups) == {(3, "vane"), *((0, name) for name in part.node_sets)}
    assert determinants.min() > 0
    read = meshio.read(path)
    for name, nodes in part.node_sets.items():
        np.testing.assert_array_equal(groups[0, name].astype(int) - 1, nodes)
        (block,) = (i for i, chosen in enumerate(read.cell_sets[name]) if len(chosen))
        assert read.cells[block].type == "vertex"
        at = read.points[read.cells[block].data[:, 0]]
        np.testing.assert_array_equal(at, part.points[nodes])


def test_sets_that_share_all_their_nodes(lattice, tmp_path):
    """There is no node left for the second one to own."""
    part = lattice((1, 1, 1))
    part.node_sets.update(force=np.array([3, 1]), output=np.array([3, 1]), none=np.empty(0, int))
    part.node_sets["last"] = np.array([3])
    path = write_msh(tmp_path / "part.msh", part)
    _, _, groups, _ = read_by_gmsh(path)
    assert groups[0, "force"].tolist() == groups[0, "output"].tolist() == [4, 2]
    assert groups[0, "last"].tolist() == [4]
    assert (0, "none") not in groups
    read = meshio.read(path)
    group = read.field_data["output"][0]
    vertices = read.cells_dict["vertex"][read.get_cell_data("gmsh:physical", "vertex") == group]
    assert vertices.ravel().tolist() == [3, 1]


def test_what_cannot_be_written(lattice, tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(InputError, match=r"taken/part.msh: cannot be written"):
        write_msh(tmp_path / "taken" / "part.msh", lattice((1, 1, 1)))
