"""Mesh files by libraries: Gmsh's .msh, VTK's .vtu and .vtk, and archives of Ansys.

Of the many formats that meshio knows, the former are tested here. They are read in a child process:
a small file can stand for a huge one, and a damaged one be read without end. The nodes' numbers in
a Gmsh file, which meshio does not keep, are read besides.

A part is written with its node sets as physical groups, since Gmsh knows none. Each set becomes a
point entity with a one-node element (`vertex`) for each of its nodes, in the set's order, and a
physical group of dimension 0 that bears its name; the solid is the physical group of dimension 3
that bears the part's.

An Ansys archive (`CDWRITE, DB, part, cdb`) has nodes, elements, and components as sets. It is read
by ansys-mapdl-reader (an optional library), which makes of the elements that Ansys degenerates, a
tetrahedron of a SOLID186 for one, what they are.
"""

import os
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import by_library, placed
from vanelock.common.lazy import library
from vanelock.mesh.files.raw import CellBlock, RawMesh, distinct
from vanelock.mesh.part import Part


def _node_numbers(path: Path) -> Integers | None:
    """Numbers of a .msh file's nodes, which meshio reads and drops, of version 2 or 4.1."""
    from meshio.gmsh import main

    try:
        with open(path, "rb") as file:
            for line in iter(file.readline, b""):
                if line.strip() == b"$MeshFormat":
                    version, size, is_text = main._read_header(file)
                elif line.strip() == b"$Nodes":
                    break
            if version in ("4", "4.1"):
                return np.asarray(main._gmsh41._read_nodes(file, is_text, size)[1] + 1, np.int64)
            if version.startswith("2"):
                return np.asarray(main._gmsh22._read_nodes(file, is_text)[1], np.int64)
    except (main.ReadError, ValueError, IndexError, OverflowError, MemoryError):
        pass
    return None


_FROM_ZERO = (".vtk", ".vtu")  # number their nodes from 0
FORMATS = {".msh": "gmsh", ".vtu": "vtu", ".vtk": "vtk"}
"""What meshio calls each ending."""


def read_exchange(source: str, path: Path) -> RawMesh:
    """Read a file in a format that its ending gives.

    Sets are meshio's sets of points and of cells, Gmsh's physical groups, and whole-number fields
    at the nodes: a set holds the nodes where the field is not zero, in the order of its values.
    """
    import meshio

    kind = FORMATS[path.suffix.lower()]
    read = partial(meshio.read, path, file_format=kind)
    mesh = by_library(read, source, path.stat().st_size, "a mesh")
    points = np.asarray(mesh.points, float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{source}: its nodes do not have three coordinates")
    numbers = np.arange(len(points)) + (0 if path.suffix.lower() in _FROM_ZERO else 1)
    gmsh = path.suffix.lower() == ".msh"
    if gmsh:
        own = _node_numbers(path)
        if own is not None and len(own) == len(points) == len(np.unique(own)):
            numbers = own
    raw = RawMesh(source, numbers, points, repeated=gmsh)
    _add_cells(raw, mesh)
    for name, nodes in mesh.point_sets.items():
        raw.node_sets[str(name)] = distinct(numbers[np.asarray(nodes, np.int64)])
    for name, values in mesh.point_data.items():
        if not str(name).startswith("gmsh:"):
            _add_field(raw, str(name), np.asarray(values))
    return raw


def _add_cells(raw: RawMesh, mesh: Any) -> None:
    """Elements with numbers from 1, and the sets of them."""
    first, starts = 1, []
    for block in mesh.cells:
        table = _table(raw, block)
        starts.append(first)
        own = np.arange(first, first + len(table))
        raw.blocks.append(CellBlock(str(block.type), own, table))
        first += len(table)
    groups: dict[str, list[Integers]] = {}
    for name, parts in mesh.cell_sets.items():
        if str(name).startswith("gmsh:"):
            continue
        for start, part in zip(starts, parts, strict=False):
            if part is not None and len(part):
                groups.setdefault(str(name), []).append(np.asarray(part, np.int64) + start)
    physical = mesh.cell_data.get("gmsh:physical")
    for name, (tag, dimension) in mesh.field_data.items() if physical is not None else ():
        if name in groups:
            continue
        for start, block, tags in zip(starts, mesh.cells, physical, strict=True):
            inside = np.flatnonzero(np.asarray(tags) == tag)
            if block.dim == dimension and len(inside):
                groups.setdefault(str(name), []).append(inside + start)
    for name, parts in groups.items():
        raw.element_sets[name] = np.concatenate(parts)


def _table(raw: RawMesh, block: Any) -> Integers:
    try:
        table = np.asarray(block.data, np.int64)
    except (TypeError, ValueError):
        table = np.empty(0, np.int64)
    if table.ndim != 2:
        raise InputError(f"{raw.source}: {len(block.data)} {block.type} elements cannot be used")
    if table.size and not (table.min() >= 0 and table.max() < len(raw.numbers)):
        raise InputError(f"{raw.source}: an element has a node that is not in the file")
    return np.asarray(raw.numbers[table])


def _add_field(raw: RawMesh, name: str, values: Floats) -> None:
    """A set from a whole-number field at the nodes: those that are not zero, in their order."""
    if values.ndim == 2 and values.shape[1] == 1:
        values = values[:, 0]
    if values.ndim != 1 or values.dtype.kind not in "iub" or len(values) != len(raw.numbers):
        return
    inside = np.flatnonzero(values)
    order = np.argsort(values[inside], kind="stable")
    raw.node_sets[name] = np.asarray(raw.numbers[inside[order]])


_SOLID = 1  # number of the solid's entity and physical group; the sets' follow


def write_msh(path: str | os.PathLike[str], part: Part) -> Path:
    """Write a part as a binary file of MSH 4.1, as a whole or not at all, and return the path.

    Node numbers are the part's, counted from 1.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    import meshio

    sets = {name: nodes for name, nodes in part.node_sets.items() if len(nodes)}
    tags = range(_SOLID + 1, _SOLID + 1 + len(sets))
    blocks = [(part.cell_type, part.cells), *(("vertex", n[:, None]) for n in sets.values())]
    numbers = [np.full(len(cells), i) for i, (_, cells) in enumerate(blocks, start=_SOLID)]
    owners = _owners(len(part.points), list(sets.values()))
    mesh = meshio.Mesh(
        part.points,
        blocks,
        point_data={} if owners is None else {"gmsh:dim_tags": owners},
        cell_data={"gmsh:physical": numbers, "gmsh:geometrical": numbers},
        field_data={part.name: [_SOLID, 3]} | {n: [t, 0] for n, t in zip(sets, tags, strict=True)},
    )
    target = Path(path)
    with placed(target) as temporary:
        # "gmsh" is version 4.1, which needs an entity for each group and a node for each entity.
        mesh.write(temporary, file_format="gmsh22" if owners is None else "gmsh", binary=True)
    return target


def _owners(count: int, sets: list[Integers]) -> Integers | None:
    """Dimension and tag (n, 2) of the entity that each node belongs to.

    A node has one owner though it may be in several sets; each set must own one at least, so the
    smaller sets choose first. None if a set is left with none, since others hold the same nodes.
    """
    owners = np.tile([3, _SOLID], (count, 1))
    for place in sorted(range(len(sets)), key=lambda i: len(sets[i])):
        free = sets[place][owners[sets[place], 0] == 3]
        if not len(free):
            return None
        owners[free[0]] = 0, _SOLID + 1 + place
    return owners


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
        _add_archive_cells(raw, reader.Archive(str(path)).grid)
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


def _add_archive_cells(raw: RawMesh, grid: Any) -> None:
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
