"""Ansys archives: written by the library and by Ansys itself, and the frequencies Ansys found."""

from pathlib import Path

import numpy as np
import pytest
import pyvista
from ansys.mapdl import reader
from ansys.mapdl.reader import examples

from tests.mesh.files.archives import degenerated, with_surface
from tests.mesh.files.conftest import bent, complaint, same
from vanelock import fem
from vanelock.mesh import Part, read_mesh
from vanelock.mesh.cells import exterior, solid

VTK = {"tetra": 10, "tetra10": 24, "hexahedron": 12, "hexahedron20": 25, "wedge15": 26}


def write(path: Path, part: Part) -> Path:
    """A part in mm, its nodes' numbers from 101 on, its sets as components."""
    k = part.cells.shape[1]
    cells = np.column_stack([np.full(len(part.cells), k), part.cells]).ravel()
    kinds = np.full(len(part.cells), VTK[part.cell_type], np.uint8)
    grid = pyvista.UnstructuredGrid(cells, kinds, 1e3 * part.points)
    grid.point_data["ansys_node_num"] = np.arange(101, 101 + len(part.points))
    for name, nodes in part.node_sets.items():
        inside = np.zeros(len(part.points), bool)
        inside[nodes] = True
        grid.point_data[name.upper()] = inside
    reader.save_as_archive(str(path), grid)
    return path


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron", "hexahedron20", "degenerated"])
def test_reads_back(tmp_path, lattice, cell_type):
    """Tetrahedra that Ansys degenerated are tetrahedra."""
    by_hand = cell_type == "degenerated"
    kind = "tetra10" if by_hand else cell_type
    part = lattice((2, 2, 2), bent, kind, curved=True)
    found = read_mesh((degenerated if by_hand else write)(tmp_path / "part.cdb", part), "mm")
    assert found.cell_type == kind
    same(part, found, {}, 1e-9)
    assert found.numbers.min() == (11 if by_hand else 101)


def test_a_beam_has_the_frequencies_that_ansys_found():
    """Its results lie beside the archive. Ansys's SOLID186 integrates at fewer points: softer."""
    found = read_mesh(examples.hexarchivefile, "m")
    assert found.cell_type == "hexahedron20"
    assert (len(found.points), len(found.cells)) == (321, 40)
    assert set(found.node_sets) == {"NCOMP2", "NODE_SELECTION", "ECOMP1", "ECOMP2"}
    elements = found.cells[np.isin(found.elements, [17, 18, *range(21, 41)])]
    assert set(found.node_sets["ECOMP1"].tolist()) == set(elements.ravel().tolist())
    results = reader.read_binary(examples.rstfile)
    given = results.materials[1]
    metal = fem.Material(E=given["EX"], nu=given["NUXY"], rho=given["DENS"])
    modes = fem.modes(fem.assemble(found.part(), metal), 14)
    known = np.asarray(results.time_values)
    assert len(known) == 6
    error = np.asarray(modes.frequency)[6:12] / known - 1  # behind the rigid-body motions
    assert error.min() >= 0
    assert error.max() < 4e-3


def test_a_component_of_surface_elements_is_a_set_of_faces(tmp_path, lattice):
    part = lattice((2, 2, 1), bent, "hexahedron", curved=True)
    sides = exterior(part.cells, solid("hexahedron"))
    faces = sides[np.isin(sides, part.node_sets["x0"]).all(axis=1)]
    assert len(faces) == 2
    found = read_mesh(with_surface(tmp_path / "part.cdb", part, faces, "side"), "mm")
    assert found.cell_type == "hexahedron"
    assert len(found.cells) == 4
    given = {frozenset(each) for each in (faces + 1).tolist()}
    assert {frozenset(found.numbers[each].tolist()) for each in found.face_sets["SIDE"]} == given
    assert set(found.node_sets["SIDE"].tolist()) == set(part.node_sets["x0"].tolist())


@pytest.mark.parametrize(("kind", "section", "named"), [
    (21, "", "MASS21"), (14, "", "COMBIN14"), (188, "", "BEAM188"), (190, "", "SOLSH190"),
    (181, "SECTYPE,1,SHELL", "SHELL181"), (181, "", ""), (174, "", ""), (200, "", ""),
])  # fmt: skip
def test_what_has_stiffness_or_mass_and_is_no_solid_is_named(
    tmp_path, lattice, kind, section, named
):
    part = lattice((1, 1, 1), bent, "hexahedron", curved=True)
    path = with_surface(tmp_path / "part.cdb", part, part.cells[:, :4], "side")
    path.write_text(path.read_text().replace("ET,2,154", f"ET,2,{kind}\n{section}"))
    if named:
        assert f"part.cdb: 1 {named} elements: allowed are tetra, " in complaint(path, "mm")
    else:
        assert len(read_mesh(path, "mm").cells) == 1


def test_what_cannot_be_used_is_refused_in_one_line(tmp_path, lattice):
    path = tmp_path / "part.cdb"
    path.write_text("/PREP7\nFINISH\n")
    begin = "part.cdb: not an Ansys archive that can be read: no nodes and elements in blocks, as"
    assert complaint(path, "mm").startswith(begin)
    path.write_bytes(bytes(1000))
    assert complaint(path, "mm").startswith("part.cdb: not an Ansys archive that can be read: ")
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
    sides = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    points = np.vstack([points, [points[[a, b]].mean(axis=0) for a, b in sides]])
    wedge = Part("w", points, np.arange(15)[None], "wedge15", {}, {}, 1)
    assert "1 wedge15 elements: allowed are tetra, tetra10" in complaint(write(path, wedge), "mm")
    part = lattice((1, 1, 1), bent, "hexahedron20", curved=True)
    lines = write(path, part).read_text().splitlines()
    block = next(i for i, line in enumerate(lines) if line.startswith("EBLOCK"))
    last = lines[block + 3]
    width = len(last) - len(last.rstrip()[: last.rstrip().rfind(" ")])
    lines[block + 3] = last[:-width] + "0".rjust(width)
    path.write_text("\n".join(lines) + "\n")
    assert "lacks middle nodes: write it with all of them" in complaint(path, "mm")
    tetra = degenerated(path, lattice((1, 1, 1), bent, "tetra10", curved=True)).read_text()
    path.write_text(tetra.replace("ET,1,186", "ET,7,186"))
    assert "part.cdb: element type 1 is not in the file" in complaint(path, "mm")
    lines[block + 3] = last[:-width] + "9999".rjust(width)
    path.write_text("\n".join(lines) + "\n")
    assert "an element has node 9999, which is not in the file" in complaint(path, "mm")
