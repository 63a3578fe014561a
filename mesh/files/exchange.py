"""Read a mesh file through meshio, Gmsh's .msh, VTK's .vtu and .vtk; write one of Gmsh.

Of the many formats that meshio knows, these are tested here. They are read in a child process: a
small file can stand for a huge one, and a damaged one be read without end.
The nodes' numbers in a Gmsh file, which meshio does not keep, are read besides.

A part is written with its node sets as physical groups, since Gmsh knows none. Each set becomes a
point entity with a one-node element (`vertex`) for each of its nodes, in the set's order, and a
physical group of dimension 0 that bears its name; the solid is the physical group of dimension 3
that bears the part's.
"""

import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.common.files.limited import by_library
from vanelock.mesh.files.raw import CellBlock, RawMesh, distinct
from vanelock.mesh.part import Part


def _node_numbers(data: bytes) -> Integers | None:
    """Numbers of the nodes in the order of a .msh file of version 2 or 4.1; None of any other."""
    words = _after(data, b"$MeshFormat", 200)[:200].split()
    try:
        version, binary = words[0].decode(), words[1] == b"1"
        nodes = _after(data, b"$Nodes", None)
        if version.startswith("2"):
            return _version_2(nodes, binary)
        if version in ("4", "4.1"):
            return _binary(nodes) if binary else _text(nodes)
    except (ValueError, IndexError, UnicodeDecodeError, OverflowError, MemoryError):
        pass
    return None


def _after(data: bytes, name: bytes, count: int | None) -> bytes:
    start = data.find(name + b"\n")
    skip = len(name) + 1
    if start < 0:
        start, skip = data.find(name + b"\r\n"), len(name) + 2
    if start < 0:
        return b""
    begin = start + skip
    return data[begin:] if count is None else data[begin : begin + count]


def _version_2(nodes: bytes, binary: bool) -> Integers:
    first, _, rest = nodes.partition(b"\n")
    count = int(first)
    if binary:
        record = np.dtype([("number", "<i4"), ("place", "<f8", 3)])
        return np.frombuffer(rest, record, count)["number"].astype(np.int64)
    lines = rest.split(b"\n", count)[:count]
    return np.array([int(line.split(None, 1)[0]) for line in lines], np.int64)


def _text(nodes: bytes) -> Integers:
    lines = iter(nodes[: max(nodes.find(b"$EndNodes"), 0)].splitlines())
    blocks = int(next(lines, b"").split()[0])
    found: list[int] = []
    for _ in range(blocks):
        count = int(next(lines, b"").split()[3])
        found += [int(next(lines, b"")) for _ in range(count)]
        for _ in range(count):
            next(lines, b"")
    return np.array(found, np.int64)


def _binary(nodes: bytes) -> Integers:
    blocks = int(np.frombuffer(nodes, "<u8", 4)[0])
    at, found = 32, [np.empty(0, np.int64)]
    for _ in range(blocks):
        parametric = int(np.frombuffer(nodes, "<i4", 3, at)[2])
        count = int(np.frombuffer(nodes, "<u8", 1, at + 12)[0])
        found.append(np.frombuffer(nodes, "<u8", count, at + 20).astype(np.int64))
        at += 20 + count * (8 + 24)
        if parametric:
            raise ValueError
    return np.concatenate(found)


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
        own = _node_numbers(path.read_bytes())
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
