"""Which row is which: from Ansys's mapping file, from a table, or from the order of the nodes.

Ansys's `HBMAT` and `*EXPORT` write matrices without labels; beside them, `HBMAT,,,,,,,YES` writes
`Fname.mapping`, a line for each row with its number, its node and the name of its freedom
(Mechanical APDL Command Reference, HBMAT).
"""

import re
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import text
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.fem.matrix_files.tables import load_pairs

NAMES = {
    **{"x": 0, "y": 1, "z": 2, "rx": 3, "ry": 4, "rz": 5},
    **{"ux": 0, "uy": 1, "uz": 2, "rotx": 3, "roty": 4, "rotz": 5},
    "modal": GENERALISED,
}
"""Directions by name."""
_MAPPED = re.compile(r"\s*(\d{1,12})\s+(\d{1,12})\s+([A-Za-z]\w{0,7})\s*")

Labels = tuple[Integers, Integers]


def read_labels(path: Path, size: int) -> Labels:
    """Node and direction of each row."""
    if path.suffix.lower() == ".mapping":
        order, node, direction = _mapping(path)
    else:
        order, node, direction = _table(path)
    if len(node) != size:
        raise InputError(f"{path}: {len(node):,} lines for a matrix of {size:,} rows")
    wrong = np.sort(order) != np.arange(1, size + 1)
    if wrong.any():
        raise InputError(
            f"{path}: rows are not numbered 1 to {size}, each once "
            f"({int(np.flatnonzero(wrong)[0]) + 1} is missing or repeated)"
        )
    place = np.argsort(order)
    return node[place], direction[place]


def check_labels(source: str, node: Integers, direction: Integers) -> Labels:
    """Refuse labels that are not unique; generalised coordinates have no node."""
    own = direction != GENERALISED
    if (wrong := own & (node < 1)).any():
        k = int(np.flatnonzero(wrong)[0])
        raise InputError(f"{source}: row {k + 1}: node {int(node[k])}: nodes are numbered from 1")
    keys = np.sort(node[own] * (GENERALISED + 1) + direction[own])
    again = keys[1:][keys[1:] == keys[:-1]]
    if len(again):
        at, way = divmod(int(again[0]), GENERALISED + 1)
        raise InputError(f"{source}: node {at}, direction {named(way)} labels two rows")
    return np.where(own, node, 0), direction


def named(direction: int) -> str:
    """A direction's name."""
    return next(name for name, number in NAMES.items() if number == direction)


def _mapping(path: Path) -> tuple[Integers, Integers, Integers]:
    """Lines of row, node and freedom under a heading."""
    rows: list[tuple[int, int, int]] = []
    for number, line in enumerate(text(path).splitlines(), start=1):
        found = _MAPPED.fullmatch(line)
        if found is None:
            if rows and line.strip():
                raise InputError(f"{path}: line {number}: not a row, a node and a freedom")
            continue
        direction = NAMES.get(found[3].lower())
        if direction is None:
            raise InputError(
                f"{path}: line {number}: {found[3]}: displacements and rotations are read "
                "(UX, UY, UZ, ROTX, ROTY, ROTZ)"
            )
        rows.append((int(found[1]), int(found[2]), direction))
    if not rows:
        raise InputError(f"{path}: no line with a row, a node and a freedom")
    order, node, direction = np.array(rows, np.int64).T
    return order, node, direction


def _table(path: Path) -> tuple[Integers, Integers, Integers]:
    columns = {name.lower(): values for name, values in load_pairs(path).items()}
    for name in ("node", "dof" if "dof" in columns else "direction"):
        if name not in columns:
            raise InputError(
                f"{path}: no column {name!r}: needed are node, and direction (x, y, z, rx, ry, rz, "
                "modal) or dof (1 to 6)"
            )
    node = _whole(path, "node", columns["node"])
    if "dof" in columns:
        dof = _whole(path, "dof", columns["dof"])
        if ((dof < 0) | (dof > 6)).any():
            raise InputError(f"{path}: column 'dof': 1 to 6 are directions, 0 is modal")
        direction = np.where(dof == 0, GENERALISED, dof - 1)
    else:
        words = [str(word).lower() for word in columns["direction"]]
        if unknown := next((word for word in words if word not in NAMES), None):
            raise InputError(
                f"{path}: column 'direction': {unknown[:20]!a}: x, y, z, rx, ry, rz or modal"
            )
        direction = np.array([NAMES[word] for word in words], np.int64)
    order = columns.get("row")
    rows = np.arange(1, len(node) + 1) if order is None else _whole(path, "row", order)
    return rows, node, direction


def _whole(path: Path, name: str, values: object) -> Integers:
    found = np.asarray(values)
    if found.dtype.kind != "i":
        raise InputError(f"{path}: column {name!r}: whole numbers are needed")
    return found.astype(np.int64)
