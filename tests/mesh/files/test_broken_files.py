"""Mesh files broken in every way: each refused in one line that says why."""

import resource

import meshio
import numpy as np
import pytest

from tests.mesh.files.conftest import GRIDS, complaint
from vanelock.mesh import read_mesh


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
