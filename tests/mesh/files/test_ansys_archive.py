"""Ansys archives and mesh files broken in every way."""

import resource
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista
from ansys.mapdl import reader
from ansys.mapdl.reader import examples

from tests.mesh.files.archives import degenerated, with_surface
from tests.mesh.files.conftest import GRIDS, bent, complaint, same
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


def deck(nodes=("1, 0,0,0", "2, 1,0,0", "3, 0,1,0", "4, 0,0,1"), element="1, 1,2,3,4", kind="C3D4"):
    return "\n".join(["*NODE", *nodes, f"*ELEMENT, TYPE={kind}", element, ""])


CARDS = ("CELAS1", "CBUSH", "RBE2", "CONM2", "CIHEX1", "CMASS2", "CONROD")

BROKEN = {
    "an absent node": (deck(element="1, 1,2,3,7"), "an element has node 7, which is not in"),
    "inverted": (deck(element="12, 1,3,2,4"), "1 of 1 elements are turned inside out or flat, "
     "such"),
    "flat": (deck(element="12, 1,2,3,3"), "element 12"),
    "NaN": (deck(["1, 0,0,nan", "2, 1,0,0", "3, 0,1,0", "4, 0,0,1"]), "node 1 has a coordinate"),
    "infinite": (deck(["1, 0,0,1e999", "2, 1,0,0", "3, 0,1,0", "4, 0,0,1"]), "node 1 has a coord"),
    "far": (deck(["1, 0,0,999", "2, 1,0,0", "3, 0,1,0", "4, 0,0,1"]), "node 1 lies 999 m from"),
    "small": (deck(["1, 0,0,1e-4", "2, 1e-3,0,0", "3, 0,1e-3,0", "4, 0,0,1e-3"]), "0.001 m large"),
    "no number": (deck(["1, 0,0,x"]), 'line 2: "x" is not a number'),
    "two coordinates": (deck(["1, 0,0"]), "line 2: a node needs its number and three"),
    "twice": (deck(["1, 0,0,0"] * 2 + ["2, 1,0,0", "3, 0,1,0", "4, 0,0,1"]), "node 1 is given tw"),
    "wedges": (deck(element="1, 1,2,3,4,1,2", kind="C3D6"), "1 wedge elements: allowed are tetra"),
    "unknown solids": (deck(element="1, 1,2,3,4,5", kind="C3D14"), "1 C3D14 elements: allowed"),
    "shells only": (deck(element="1, 1,2,3", kind="S3"), "no solid elements (1 triangle)"),
    "too many nodes": (deck(element="1, 1,2,3,4,5"), "C3D4 has 4 nodes, 5 are given"),
    "cut off": (deck(element="1, 1,2,3"), "the last element has 3 nodes, C3D4 4"),
    "same element": (deck(element="1, 1,2,3,4\n2, 1,2,3,4"), "element 1 has the nodes of another"),
    "no type": ("*NODE\n1,0,0,0\n*ELEMENT\n1,1\n", "line 3: *ELEMENT: its TYPE is missing"),
    "include": ("*INCLUDE, INPUT=x.inp\n", "line 1: *INCLUDE is not read"),
    "input": ("*NODE, INPUT=x.inp\n", "line 1: *NODE is not read"),
    "cylindrical": ("*NODE, SYSTEM=C\n1,1,1,1\n", "only Cartesian coordinates"),
    "set in itself": (deck() + "*NSET, NSET=A\nB\n*NSET, NSET=B\nA\n", "contains itself"),
    "absent set": (deck() + "*NSET, NSET=A\nB\n", "the set A names an absent set B"),
    "long range": (deck() + "*NSET, NSET=A, GENERATE\n1, 999999999999\n", "is too long"),
    "huge number": (deck(element="1, 1,2,3," + 30 * "9"), "is too large"),
    "not a deck": ("hello\nworld\n", "line 1: not an Abaqus deck"),
    "empty": ("", "no solid elements (none)"),
    "no element": ("*NODE\n1,0,0,0\n", "no solid elements (none)"),
    "options cut off": ("*NODE, NSET=A,\n", "ends within a keyword's options"),
    "binary": ("*NODE\n\0\0\n", "not a text file"),
}  # fmt: skip


BULK = [
    ("GRID,1,5,0.,0.,0.\n", "line 1: node 1 is given in coordinate system 5"),
    ("GRDSET,,5\n", "write the nodes in the basic coordinate system"),
    ("GRID,1,,a,0.,0.\n", 'line 1: "a" is not a number'),
    (GRIDS + "CTETRA,1,1,1,2,3\n", "line 5: CTETRA with 3 nodes: it must have 4 or 10"),
    (GRIDS + "CPENTA,1,1,1,2,3,4,1,2\n", "1 wedge elements: allowed are"),
    (GRIDS + "CTETRA,1,1,1,2,3,4\nSET1,3,1,THRU\n", "line 6: THRU without an end"),
    (GRIDS + "CTETRA,1,1,1,2,3,4\nSET1,3,9,THRU,1\n", "9 to 1 by 1 is no range"),
    (GRIDS + "SET1,1,1,THRU,4999999\n" * 40, "more than 10,000,000 members"),
    ("SET 1 = 1 THRU 4999999, EXCEPT 5\nCEND\n", "no solid elements"),
    ("INCLUDE 'other.bdf'\n", "line 1: INCLUDE is not read"),
    ("SOL 103\nCEND\n", "no solid elements (none)"),
]
OTHERS = [
    ("part.xyz", "1 2 3", "allowed are .inp, .bdf, .nas, .dat, .fem, .cdb, .msh, .vtu, .vtk"),
    ("part.tec", "VARIABLES = X\n" * 9, "part.tec: no mesh format that is read; allowed are"),
    ("part.msh", "(0 grid written by\n(2 3)\n", "not a mesh that can be read"),  # Fluent's
    ("part.vtu", "<VTKFile", "not a mesh that can be read"),
    ("part.msh", "$MeshFormat\n4.1 1 8\n", "not a mesh that can be read"),
    ("part.msh", "\x00\x01", "not a mesh that can be read"),
    ("part.xdmf", "<Xdmf/>", "allowed are"),
    ("part.stl", "solid\nendsolid\n", "allowed are"),
]
FILES = [("part.inp", *row) for row in BROKEN.values()]
FILES += [("part.bdf", *row) for row in BULK] + OTHERS


@pytest.mark.parametrize(("name", "text", "expected"), FILES)
def test_broken_files(tmp_path, capfd, name, text, expected):
    path = tmp_path / name
    path.write_text(text)
    assert expected in complaint(path)
    assert capfd.readouterr() == ("", "")


SKIN = "*ELEMENT, TYPE={}, ELSET=skin\n8, 1,2,3\n"


@pytest.mark.parametrize(("text", "listed"), [
    *((f"*ELEMENT, TYPE={kind}\n8, 1,2\n9, 2,3\n", f"2 {kind}") for kind in ("MASS", "SPRINGA",
     "B31", "DCOUP3D", "SC8R", "COH3D8", "CONN3D2")),
    (SKIN.format("S3") + "*SHELL SECTION, ELSET=skin\n0.1\n", "1 S3"),
    (SKIN.format("M3D3") + "*MEMBRANE SECTION, ELSET=skin\n0.1\n", "1 M3D3"),
    (SKIN.format("SFM3D3") + "*SURFACE SECTION, ELSET=skin, DENSITY=1.\n", "1 SFM3D3"),
    (SKIN.format("SFM3D3") + "*SURFACE SECTION, ELSET=skin\n", ""),
    (SKIN.format("S3") + "*ELEMENT, TYPE=T3D2\n9, 1,2\n", ""),
    *((f"{card},8,1,1,2\n{card},9,1,2,3\n", f"2 {card}") for card in CARDS),
    ("CTRIA3,8,1,1,2,3\nCBAR,9,2,1,2\nPSHELL,1,1,0.1\n", "1 CTRIA3"),
    ("CTRIA3,8,1,1,2,3\nCBAR,9,2,1,2\nPBAR,2,1,0.1\n", "1 CBAR"),
    ("CTRIA3,8,1,1,2,3\nCBAR,9,2,1,2\nPLOTEL,10,1,2\nPSOLID,1,1\n", ""),
])  # fmt: skip
def test_what_has_stiffness_or_mass_and_is_not_read_is_named(tmp_path, text, listed):
    """With counts; elements that have neither are passed over, shells without a section, too."""
    abaqus = text.startswith("*")
    path = tmp_path / ("part.inp" if abaqus else "part.bdf")
    path.write_text((deck() if abaqus else f"{GRIDS}CTETRA,1,1,1,2,3,4\n") + text)
    if listed:
        assert f"{path.name}: {listed} elements: allowed are tetra, " in complaint(path)
    else:
        assert len(read_mesh(path).cells) == 1


def test_meshes_that_cannot_be_used(tmp_path, lattice, ring):
    def refused(points, *cells):
        path = tmp_path / "part.vtu"
        meshio.Mesh(points, [(part.cell_type, nodes) for part, nodes in cells]).write(path)
        return complaint(path)

    tetra, hexa = (lattice((1, 1, 1), lambda p: p, kind) for kind in ("tetra", "hexahedron"))
    said = refused(tetra.points, (tetra, tetra.cells), (hexa, hexa.cells))
    assert "6 tetra and 1 hexahedron elements: use one kind" in said
    apart = np.vstack([hexa.points, hexa.points + 3])
    said = refused(apart, (hexa, np.vstack([hexa.cells, hexa.cells + 8])))
    assert "2 pieces that share no nodes; the smallest has 8 of them" in said
    part = ring("tetra")
    said = refused(part.points * [1, 1, -1], (part, part.cells))  # mirrored
    assert "every element is turned inside out" in said
    part = ring("tetra10")
    points = part.points.copy()
    points[part.cells[3, 6]] += [0.05, 0, 0]  # a middle node
    assert f"node {part.cells[3, 6]} lies" in refused(points, (part, part.cells))


def test_a_small_file_that_stands_for_a_huge_mesh(tmp_path):
    """A packed file of 0.5 MB, whose nodes take 240 MB."""
    path = tmp_path / "part.vtu"
    points = np.zeros((10_000_000, 3))
    meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]).write(path, compression="zlib")
    assert path.stat().st_size < 1_000_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert complaint(path) == "part.vtu: not a mesh that can be read: it asks for too much memory"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss == before
