"""The sets of a mesh file as nodes and faces of its solid elements."""

import numpy as np

from vanelock.mesh.files.raw import Integers, RawMesh, distinct


def file_sets(
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
    if not raw.element_sets:
        return {}
    where = {
        int(number): (block, i) for block in raw.blocks for i, number in enumerate(block.numbers)
    }
    kind = "triangle" if corners == 3 else "quad"
    sets: dict[str, tuple[Integers, Integers | None]] = {}
    for name, elements in raw.element_sets.items():
        found = [where[int(e)] for e in elements if int(e) in where]
        if not found:
            continue
        own = distinct(np.concatenate([block.nodes[i] for block, i in found]))
        flat = None
        if all(block.cell_type.startswith(kind) for block, _ in found):
            flat = np.array([block.nodes[i][:corners] for block, i in found])
        sets[name] = own, flat
    return sets
