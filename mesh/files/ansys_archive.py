"""Read an Ansys archive (`CDWRITE, DB, part, cdb`): nodes, elements, and components as sets.

By ansys-mapdl-reader (an optional library), which makes of the elements that Ansys degenerates, a
tetrahedron of a SOLID186 for one, what they are.
"""

import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError
from vanelock.common.files.limited import by_library
from vanelock.common.lazy import library
from vanelock.mesh.files.raw import CellBlock, RawMesh, distinct

ARCHIVE = ".cdb"
_MESH_ONLY = 200  # ansys's element type MESH200, which has no stiffness
_TYPE, _HEAD = 1, 10
"""Of an element as the library has it: the place of its type, and where its nodes begin."""
_SOLIDS = {
    5, 45, 46, 62, 64, 65, 69, 70, 73, 87, 90, 92, 95, 96, 97, 98, 122, 123, 127, 128, 147, 148,
    185, 186, 187, 226, 227, 231, 232, 236, 237, 239, 240, 278, 279, 285, 291,
}  # fmt: skip
_SHELLS = {28, 41, 43, 57, 63, 91, 93, 99, 131, 132, 143, 150, 157, 163, 181, 281}
"""They serve sets, unless a section or a real constant gives them a thickness."""
_WITHOUT = {_MESH_ONLY, *range(151, 157), *range(169, 179), 201}
"""Surface, contact and target elements, and those that a load follows."""
_NAMES = {
    "MASS": {21}, "COMBIN": {7, 14, 37, 39, 40, 214}, "MATRIX": {27, 50}, "MPC": {184},
    "LINK": {1, 8, 10, 11, 160, 180}, "BEAM": {3, 4, 23, 24, 44, 54, 161, 188, 189},
    "PIPE": {16, 17, 18, 20, 59, 60, 288, 289}, "ELBOW": {290}, "SOLSH": {190},
    "INTER": {192, 193, 194, 195, 202, 203, 204, 205}, "SHELL": _SHELLS, "REINF": {263, 264, 265},
}  # fmt: skip
_THICKNESS = re.compile(rb"^ *(SECT[A-Z]*,[^,]*, *SHEL|SECB|RLBLOCK)", re.IGNORECASE | re.MULTILINE)
_VTK = {
    1: "vertex", 3: "line", 5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron", 13: "wedge",
    14: "pyramid", 21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20",
    26: "wedge15", 27: "pyramid13",
}  # fmt: skip


def read_archive(source: str, path: Path) -> RawMesh:
    """Read the blocks NBLOCK, EBLOCK and CMBLOCK; all else in the file is passed over."""
    reader = library("ansys.mapdl.reader", "ansys", source, "ansys-mapdl-reader")
    read = partial(_contents, reader, source, path)
    return by_library(read, source, path.stat().st_size, "an Ansys archive")


def _contents(reader: Any, source: str, path: Path) -> RawMesh:
    """What an archive says, its elements as VTK has them."""
    archive = reader.Archive(str(path), parse_vtk=False)
    if not len(archive.nnum) or not len(archive.enum):
        raise ValueError("no nodes and elements in blocks, as CDWRITE writes them")
    numbers = np.asarray(archive.nnum, np.int64)
    _refuse_unknown(source, archive, numbers)
    raw = RawMesh(source, numbers, np.asarray(archive.nodes, float)[:, :3])
    for name, nodes in archive.node_components.items():
        raw.node_sets[str(name).strip()] = distinct(nodes)
    for name, elements in archive.element_components.items():
        raw.element_sets[str(name).strip()] = distinct(elements)
    thick = _THICKNESS.search(path.read_bytes()) is not None
    called = dict(np.asarray(archive.ekey)[:, :2].tolist())
    for kind in (called[int(element[_TYPE])] for element in archive.elem):
        if kind not in _SOLIDS | _WITHOUT and (thick or kind not in _SHELLS):
            name = next((name for name, kinds in _NAMES.items() if kind in kinds), "type ")
            raw.unread[f"{name}{kind}"] += 1
    if not raw.unread:
        _add_cells(raw, reader.Archive(str(path)).grid)
    return raw


def _refuse_unknown(source: str, archive: Any, numbers: Integers) -> None:
    """Refuse nodes and types that are not in the file, which the library would look up blindly."""
    types = np.asarray(archive.ekey)[:, 0]
    for element in archive.elem:
        if element[_TYPE] not in types:
            raise InputError(f"{source}: element type {element[_TYPE]} is not in the file")
    nodes = np.concatenate([element[_HEAD:] for element in archive.elem])
    absent = nodes[~np.isin(nodes, numbers) & (nodes != 0)]
    if len(absent):
        raise InputError(f"{source}: an element has node {absent[0]}, which is not in the file")


def _add_cells(raw: RawMesh, grid: Any) -> None:
    """Elements by type, with the file's numbers."""
    of_node = np.asarray(grid.point_data["ansys_node_num"], np.int64)
    of_element = np.asarray(grid.cell_data["ansys_elem_num"], np.int64)
    kinds = np.asarray(grid.celltypes)
    stiff = np.asarray(grid.cell_data["ansys_elem_type_num"]) != _MESH_ONLY
    for kind, cells in grid.cells_dict.items():
        of_kind = kinds == kind
        kept = stiff[of_kind]
        nodes, own = of_node[cells][kept], of_element[of_kind][kept]
        absent = ~np.isin(nodes, raw.numbers)
        if absent.any():
            element = own[absent.any(axis=1)][0]
            raise InputError(
                f"{raw.source}: element {element} lacks middle nodes: write it with all of them"
            )
        if len(own):
            raw.blocks.append(CellBlock(_VTK.get(int(kind), f"VTK_{kind}"), own, nodes))
