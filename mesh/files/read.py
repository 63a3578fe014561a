"""Read a part's mesh from a file, by the reader of its format.

What the file says becomes one kind of solid elements, checked and without what is unused; its sets
become nodes and faces of these elements.
"""

import os
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import regular
from vanelock.common.quantities import si
from vanelock.mesh.cells import SOLIDS, Cell, exterior, solid
from vanelock.mesh.files.abaqus import read_abaqus
from vanelock.mesh.files.exchange import ARCHIVE, FORMATS, read_archive, read_exchange
from vanelock.mesh.files.nastran import read_nastran
from vanelock.mesh.files.raw import CellBlock, FileMesh, RawMesh, distinct
from vanelock.mesh.refinement import MOST

_DECKS = {
    ".inp": read_abaqus,
    ".bdf": read_nastran,
    ".nas": read_nastran,
    ".dat": read_nastran,
    ".fem": read_nastran,
}
_LARGEST = 1 << 30
"""Bytes of the largest file that is read: a mesh at the limit of its nodes has a tenth of that."""


def read_mesh(path: str | os.PathLike[str], unit: str = "m") -> FileMesh:
    """Read a mesh of solid elements with its sets.

    Parameters
    ----------
    path : path
        Abaqus or CalculiX deck (.inp), Nastran bulk data (.bdf, .nas, .dat, .fem), Ansys archive
        (.cdb), Gmsh (.msh) or VTK (.vtu, .vtk).
    unit : str
        Of its coordinates, such as "mm".

    Returns
    -------
    FileMesh
        Tetrahedra or hexahedra, with the file's numbers of nodes and elements.

    Raises
    ------
    InputError
        One line with the file's name: it cannot be read, is malformed, or its elements cannot be
        used.
    """
    path, source = Path(path), str(path)
    factor = metres(unit)
    try:
        if (size := regular(path, "a mesh file")) > _LARGEST:
            raise InputError(f"{source}: {size:,} bytes: at most {_LARGEST:,} are read")
        ending = path.suffix.lower()
        deck = _DECKS.get(ending)
        if deck is None:
            if ending == ARCHIVE:
                return _solid_mesh(read_archive(source, path), factor)
            if ending not in FORMATS:
                allowed = ", ".join((*_DECKS, ARCHIVE, *FORMATS))
                raise InputError(f"{source}: no mesh format that is read; allowed are {allowed}")
            return _solid_mesh(read_exchange(source, path), factor)
        text = path.read_bytes().decode("utf-8-sig", "replace")
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {error.strerror or error}") from None
    if "\0" in text:
        raise InputError(f"{source}: not a text file")
    return _solid_mesh(deck(source, text), factor)


def metres(unit: str) -> float:
    """Metres in one unit of length."""
    try:
        factor = si(f"1 {unit}", "m")
    except ValueError:
        factor = None
    if not isinstance(factor, float) or not 1e-9 <= factor <= 1e6:
        raise InputError(f'unit = "{unit}": expected a unit of length, such as "mm"')
    return factor


def _file_sets(
    raw: RawMesh, numbers: Integers, faces: Integers
) -> tuple[dict[str, Integers], dict[str, Integers], dict[str, Integers]]:
    """Nodes of every set, faces of those that have any, and what belongs to no solid element.

    A name that stands for several kinds of sets means nodes first, then faces, then elements.
    """
    corners = 3 if faces.shape[1] in (3, 6) else 4
    given = {name: np.array(own, np.int64) for name, own in raw.face_sets.items()}
    nodes = {name: distinct(own) for name, own in raw.node_sets.items()}
    for name, (own, flat) in _of_elements(raw, corners).items():
        if flat is not None:
            given.setdefault(name, flat)
        elif name not in given:
            nodes.setdefault(name, own)
    outside = {tuple(row): i for i, row in enumerate(np.sort(numbers[faces[:, :corners]]).tolist())}
    face_sets = {}
    for name, own in given.items():
        keys = [tuple(row) for row in np.sort(own.reshape(-1, own.shape[-1])).tolist()]
        here = [outside[key] for key in keys if key in outside]
        if here and name not in nodes:
            face_sets[name] = faces[here, :corners]
        stray = np.array([key for key in keys if key not in outside], np.int64).ravel()
        nodes.setdefault(name, distinct(np.concatenate([numbers[faces[here]].ravel(), stray])))
    order = np.argsort(numbers)
    node_sets, absent = {}, {}
    for name, own in nodes.items():
        known = np.isin(own, numbers)
        node_sets[name] = order[np.searchsorted(numbers, own[known], sorter=order)]
        if not known.all():
            absent[name] = own[~known]
    return node_sets, face_sets, absent


def _of_elements(raw: RawMesh, corners: int) -> dict[str, tuple[Integers, Integers | None]]:
    """Nodes of each set of elements, and corners of the faces if they are faces of the solids."""
    kind = "triangle" if corners == 3 else "quad"
    sets: dict[str, tuple[Integers, Integers | None]] = {}
    for name, elements in raw.element_sets.items():
        if not (found := raw.elements(elements)):
            continue
        own = distinct(np.concatenate([nodes for _, nodes in found]))
        flat = None
        if all(block.cell_type.startswith(kind) for block, _ in found):
            flat = np.array([nodes[:corners] for _, nodes in found])
        sets[name] = own, flat
    return sets


_LOWER = ("vertex", "line", "triangle", "quad", "polygon", "poly_", "pixel", "empty")
"""Elements that serve sets, those of a deck where they have no section."""
_FURTHEST = 100.0  # largest coordinate, m
_LEAST = 2e-3  # smallest extent of a part, m
_OFF_PLACE = 0.25
"""How far a middle node may lie from the middle of its side, in lengths of the element's sides."""


def _solid_mesh(raw: RawMesh, unit: float) -> FileMesh:
    """The solid elements of a file.

    Middle nodes in another order than meshio's are put in that order where the coordinates show it
    without doubt.
    """
    kind, block = _only_solid(raw)
    cells, elements = _once(raw, _rows(raw, block.nodes), block.numbers)
    points = raw.points * unit
    used = np.unique(cells)
    bad = used[~np.isfinite(points[used]).all(axis=1)]
    if len(bad):
        raise InputError(
            f"{raw.source}: node {raw.numbers[bad[0]]} has a coordinate that is not a finite number"
        )
    far = np.abs(points[used]).max(axis=1)
    if far.max() > _FURTHEST:
        node = raw.numbers[used[far.argmax()]]
        raise InputError(
            f"{raw.source}: node {node} lies {far.max():.3g} m from the origin: at most "
            f"{_FURTHEST:g} m are allowed; is the unit right?"
        )
    size = float(np.ptp(points[used], axis=0).max())
    if size < _LEAST:
        raise InputError(
            f"{raw.source}: {size:.3g} m large: at least {_LEAST:g} m are needed; is the "
            "unit right?"
        )
    if 3 * len(used) > MOST:
        raise InputError(
            f"{raw.source}: {len(used):,} nodes: at most {MOST // 3:,} can be computed"
        )
    reference = solid(kind)
    cells = _in_order(raw, reference, points, cells, elements)
    _right_way_round(raw, reference, points, cells, elements)
    _in_one_piece(raw, cells, used)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    cells, numbers = place[cells], raw.numbers[used]
    sets = _file_sets(raw, numbers, exterior(cells, reference))
    return FileMesh(raw.source, points[used], numbers, cells, elements, kind, *sets)


def _rows(raw: RawMesh, nodes: Integers) -> Integers:
    """From the file's numbers of the elements' nodes to rows of its table of nodes."""
    if not len(raw.numbers):
        raise InputError(f"{raw.source}: no nodes")
    order = np.argsort(raw.numbers, kind="stable")
    ascending = raw.numbers[order]
    twice = ascending[:-1][np.diff(ascending) == 0]
    if len(twice):
        raise InputError(f"{raw.source}: node {twice[0]} is given twice")
    rank = np.searchsorted(ascending, nodes).clip(max=len(ascending) - 1)
    absent = ascending[rank] != nodes
    if absent.any():
        raise InputError(
            f"{raw.source}: an element has node {nodes[absent][0]}, which is not in the file"
        )
    return np.asarray(order[rank])


def _only_solid(raw: RawMesh) -> tuple[str, CellBlock]:
    counts = raw.unread.copy()
    for block in raw.blocks:
        counts[block.cell_type] += len(block.numbers)
    kinds = [kind for kind in counts if kind in SOLIDS and counts[kind]]
    others = [kind for kind in counts if kind not in SOLIDS and not kind.startswith(_LOWER)]
    allowed = ", ".join(SOLIDS)
    if others:
        listed = ", ".join(f"{counts[kind]} {kind}" for kind in others)
        raise InputError(
            f"{raw.source}: {listed} elements: allowed are {allowed}; leave others out, or give "
            "the part as matrices, which a scene takes (vanelock manual own_matrices)"
        )
    if not kinds:
        listed = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "none"
        raise InputError(f"{raw.source}: no solid elements ({listed}): allowed are {allowed}")
    if len(kinds) > 1:
        listed = " and ".join(f"{counts[kind]} {kind}" for kind in kinds)
        raise InputError(f"{raw.source}: {listed} elements: use one kind of solid elements")
    blocks = [block for block in raw.blocks if block.cell_type == kinds[0]]
    numbers = np.concatenate([block.numbers for block in blocks])
    return kinds[0], CellBlock(kinds[0], numbers, np.concatenate([block.nodes for block in blocks]))


def _once(raw: RawMesh, cells: Integers, elements: Integers) -> tuple[Integers, Integers]:
    """Each element once: Gmsh's older format repeats one in every group that it belongs to."""
    _, first, count = np.unique(
        np.sort(cells, axis=1), axis=0, return_index=True, return_counts=True
    )
    if len(first) < len(cells) and not raw.repeated:
        raise InputError(
            f"{raw.source}: element {elements[first[count > 1].min()]} has the nodes of another one"
        )
    first.sort()
    return cells[first], elements[first]


def _in_order(
    raw: RawMesh, reference: Cell, points: Floats, cells: Integers, elements: Integers
) -> Integers:
    """Cells with middle nodes in meshio's order, by where they lie."""
    n = reference.corners
    if cells.shape[1] == n:
        return cells
    shape, _ = solid("tetra" if n == 4 else "hexahedron").functions(reference.nodes[n:])
    expected = np.einsum("mc,ecx->emx", shape, points[cells[:, :n]])
    given = points[cells[:, n:]]
    size = np.linalg.norm(points[cells[:, :n]] - points[cells[:, [1]]], axis=2).max(axis=1)
    size = np.where(size > 0, size, 1.0)
    off = np.stack(
        [
            np.linalg.norm(given - expected[:, [m]], axis=2) / size[:, None]
            for m in range(len(shape))
        ]
    )  # (place, element, given)
    from scipy.optimize import linear_sum_assignment  # slow to load, and seldom needed

    _, order = linear_sum_assignment(off.mean(axis=1))
    cells = np.concatenate([cells[:, :n], cells[:, n + order]], axis=1)
    away = off[np.arange(len(order)), :, order]
    if away.max() > _OFF_PLACE:
        node, element = np.unravel_index(away.argmax(), away.shape)
        raise InputError(
            f"{raw.source}: element {elements[element]}: node "
            f"{raw.numbers[cells[element, n + node]]} lies {100 * away.max():.0f} % of the "
            f"element's size from its place: at most {100 * _OFF_PLACE:.0f} % is allowed"
        )
    return cells


def _right_way_round(
    raw: RawMesh, reference: Cell, points: Floats, cells: Integers, elements: Integers
) -> None:
    """Refuse elements that are turned inside out, half-way from their middle to any node."""
    middle = reference.nodes[: reference.corners].mean(axis=0)
    inside = np.vstack([middle, 0.5 * (reference.nodes + middle)])
    _, slopes = reference.functions(inside)
    worst = np.empty(len(cells))
    for start in range(0, len(cells), 4096):  # a quarter of a gigabyte at most
        block = slice(start, start + 4096)
        J = np.einsum("eia,qib->eqab", points[cells[block]], slopes)
        worst[block] = np.linalg.det(J).min(axis=1)
    wrong = np.flatnonzero(~(worst > 0))
    if not len(wrong):
        return
    first = f"element {elements[wrong[np.argmin(worst[wrong])]]}"
    if len(wrong) == len(cells) > 1:
        raise InputError(
            f"{raw.source}: every element is turned inside out, such as {first}: the mesh is "
            "mirrored, or its nodes are in another order than the format's"
        )
    raise InputError(
        f"{raw.source}: {len(wrong)} of {len(cells)} elements are turned inside out or flat, such "
        f"as {first}"
    )


def _in_one_piece(raw: RawMesh, cells: Integers, used: Integers) -> None:
    """Refuse a mesh whose pieces share no nodes, such as aerofoils not merged with a shroud."""
    first = np.repeat(cells[:, 0], cells.shape[1] - 1)
    size = int(used.max()) + 1
    links = sp.coo_array((np.ones(len(first)), (first, cells[:, 1:].ravel())), shape=(size, size))
    _, label = connected_components(links, directed=False)
    pieces, where, count = np.unique(label[used], return_index=True, return_counts=True)
    if len(pieces) > 1:
        small = int(count.argmin())
        node = raw.numbers[used[where[small]]]
        raise InputError(
            f"{raw.source}: {len(pieces)} pieces that share no nodes; the smallest has "
            f"{count[small]} of them, such as {node}: merge those where they meet"
        )
