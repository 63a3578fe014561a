"""Forces on nodes of a component from a file, such as a gas or thermal load of another program.

None of their nodes becomes a coordinate: the reduction holds the static answer to all of them
together, and they act on its coordinates as Tᵀ f (`vanelock.rom.routes.rows`). What acts on clamped
nodes the ground bears.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import load_pairs
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.pipeline.cache import content_digest

COLUMNS = ("fx", "fy", "fz")


@dataclass(frozen=True)
class NodalForces:
    """A load from a file.

    Attributes
    ----------
    where : str
        Who asks, in messages.
    part : str
        Whose nodes.
    digest : str
        Of what the file holds.
    nodes : (k,) int
        The file's.
    forces : (k, 3) float
        On each of them, N.
    factor : complex
        What multiplies them: scale and phase.
    harmonic : int
        0: a static load.
    """

    where: str
    part: str
    digest: str
    nodes: Integers
    forces: Floats
    factor: complex
    harmonic: int


def read_forces(path: Path) -> tuple[str, Integers, Floats]:
    """Digest of a file with the columns node, fx, fy, fz, its nodes (k,) and forces (k, 3), N."""
    digest = content_digest(path)
    return digest, *_read(path, digest)


@lru_cache(maxsize=16)
def _read(path: Path, digest: str) -> tuple[Integers, Floats]:
    """Nodes and forces, once for all cases."""
    table = load_pairs(path)
    if content_digest(path) != digest:
        raise InputError(f"{path}: changed while it was read: run again")
    nodes, given = table.get("node"), [each for each in COLUMNS if each in table]
    if nodes is None or nodes.dtype.kind != "i" or nodes.min() < 1:
        raise InputError(f"{path}: a column 'node' of node numbers is needed")
    if unknown := [each for each in table if each not in ("node", *COLUMNS)]:
        raise InputError(f"{path}: column {unknown[0]!r}: allowed are node, {', '.join(COLUMNS)}")
    if not given:
        raise InputError(f"{path}: at least one of the columns {', '.join(COLUMNS)} is needed")
    for each in given:
        if table[each].dtype.kind not in "if":
            raise InputError(f"{path}: column {each!r} does not hold numbers")
    distinct, count = np.unique(nodes, return_counts=True)
    if np.any(count > 1):
        raise InputError(f"{path}: node {distinct[count > 1][0]} is listed twice")
    none = np.zeros(len(nodes))
    forces = np.column_stack([np.asarray(table.get(each, none), float) for each in COLUMNS])
    if not forces.any():
        raise InputError(f"{path}: all its forces are 0")
    return np.asarray(nodes), forces


def on_rows(
    given: Sequence[NodalForces], node: Integers, direction: Integers, fixed: Integers
) -> sp.csc_array:
    """(n, p) forces on a component's rows, one load a column, in unit size, N."""
    key = (GENERALISED + 1) * node + direction
    order = np.argsort(key, kind="stable")
    rows, columns, values = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty(0)]
    for i, each in enumerate(given):
        of = f"of components.{each.part}"
        free = ~np.isin(each.nodes, fixed)
        nodes, forces = each.nodes[free], each.forces[free]
        if len(missing := nodes[~np.isin(nodes, node)]):
            raise InputError(f"{each.where}.file: node {missing[0]} is not among the nodes {of}")
        wanted = (GENERALISED + 1) * nodes[:, None] + np.arange(3)
        at = order[np.searchsorted(key[order], wanted).clip(max=len(order) - 1)]
        there, acts = key[at] == wanted, forces != 0
        if np.any(lost := acts & ~there):
            k, d = np.argwhere(lost)[0]
            raise InputError(
                f"{each.where}.file: node {nodes[k]} {of} has no row for its {COLUMNS[d]}"
            )
        rows.append(at[acts])
        columns.append(np.full(np.count_nonzero(acts), i))
        values.append(forces[acts])
    where = np.concatenate(rows), np.concatenate(columns)
    return sp.csc_array((np.concatenate(values), where), shape=(len(node), len(given)))
