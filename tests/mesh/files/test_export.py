"""What Gmsh itself and meshio read from a `.msh` file."""

import meshio
import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import Part, write_msh
from vanelock.mesh.gmsh_session import session

# Corners at the ends of the edges in whose middle the nodes 4 to 9 lie, in Gmsh's manual
# ("Node ordering", Tetrahedron10) and in VTK's (vtkQuadraticTetra).
GMSH = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
VTK = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


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


def test_middle_nodes_lie_where_gmsh_and_meshio_expect_them(lattice, tmp_path):
    part = lattice((2, 1, 2), lambda p: p * [1.0, 1.3, 0.7] + 0.2 * p[:, [1]])  # straight edges
    path = write_msh(tmp_path / "part.msh", part)
    points, elements, _, _ = read_by_gmsh(path)
    read = meshio.read(path)
    for at, edges in ((points[elements], GMSH), (read.points[read.cells[0].data], VTK)):
        for node, (a, b) in enumerate(edges, start=4):
            np.testing.assert_allclose(at[:, node], (at[:, a] + at[:, b]) / 2, atol=1e-15)


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
