"""From a component's matrices to a piece: reduced by Craig and Bampton, or used as they are."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock import rom
from vanelock.common.arrays import Integers
from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.fem import SingularError
from vanelock.fem.matrix_files import Matrices, load_matrices
from vanelock.fem.matrix_files.model import GENERALISED
from vanelock.fem.solvers.singular import SOUGHT
from vanelock.input.schema.scene import ND, ComponentKeys, Scene, SceneRingKeys
from vanelock.rom.fixed_interface.selection import DEFAULT
from vanelock.rom.system.system import Matrix, common_band
from vanelock.stages.matrices.gather import Gathered, nodes
from vanelock.stages.matrices.piece import (
    NodalForces,
    Piece,
    Seen,
    among,
    kept_rows,
    on_rows,
    rows_of,
    seen_from,
)

LARGEST = 5000
"""Most coordinates of a superelement: its matrices are dense."""
TOGETHER = 1e-6
"""Largest distance of a high face's node from its mate turned, over its distance from the axis."""
WORDS = ("x", "y", "z", "rotation x", "rotation y", "rotation z")


def clamped(keys: ComponentKeys, name: str) -> Integers:
    """Nodes that a component says are held."""
    if keys.fixed is None:
        return np.empty(0, np.int64)
    return nodes(keys.fixed, f"components.{name}.fixed")


def matrices(name: str, keys: ComponentKeys, nodal_diameter: int = 0) -> Matrices:
    """A component's matrices, read from its files; at a nodal diameter where names say so."""

    def at(key: str) -> Path | None:
        value = getattr(keys, key)
        return None if value is None else Path(value.replace(ND, str(nodal_diameter)))

    stiffness, units = at("stiffness"), keys.units
    assert stiffness is not None
    others = map(at, ("mass", "damping", "dofs", "nodes"))
    kinds = ("stiffness", "mass", "damping")
    names = {kind: key for kind in kinds if (key := getattr(keys, f"{kind}_name")) is not None}
    scale = {"length": units.length, "mass_unit": units.mass, "force": units.force}
    try:
        return load_matrices(stiffness, *others, names, **scale)
    except InputError as error:
        raise InputError(f"components.{name}: {error}") from None


def superelement(
    scene: Scene, name: str, forces: Sequence[NodalForces], nodal_diameter: int = -1
) -> Piece:
    """Matrices as they are, of a nodal diameter or, without one, of all."""
    given = matrices(name, scene.components[name], max(nodal_diameter, 0))
    if given.size > LARGEST:
        raise InputError(
            f"components.{name}: {given.size:,} rows: a superelement has at most {LARGEST:,}; "
            'choose kind = "full" to reduce it'
        )
    blocks = {nodal_diameter: _whole_block(given.K, _mass(name, given), given.C)}
    act = _whole(forces, on_rows(forces, given.node, given.direction, np.empty(0, np.int64)))
    return _piece(name, scene.ring, given, given.node, given.direction, blocks, forces=act)


def reduced(
    scene: Scene, name: str, gathered: Gathered, nodal_diameters: Sequence[int], least: float | None
) -> Piece:
    """A component whose rest becomes fixed-interface vectors: nodes that are named stay.

    The second of these with their rotations.

    A component that can move as a whole although its kept nodes are held, such as by turning about
    a single one, keeps as many further displacements as it takes to hold it.

    Nodes that are loaded or shown, and nothing else, are not kept: the static answers to their
    loads are vectors. They are in a cyclic component, and where they lack a direction, a mass or a
    stiffness of their own, or where it takes them to hold the component.
    """
    keys, ring, named = scene.components[name], scene.ring, gathered.kept[name]
    forces, where, wanted = gathered.forces_on(name), f"components.{name}", named[0]
    fixed, faces = clamped(keys, name), None
    if keys.low is not None:
        faces = nodes(keys.low, f"{where}.low"), nodes(keys.high, f"{where}.high")
    given = matrices(name, keys)
    refuse_unknown(f"{where}.fixed", given, fixed)
    free = np.flatnonzero(~np.isin(given.node, fixed))
    node, direction = given.node[free], given.direction[free]
    K, M = given.K[free][:, free], _mass(name, given)[free][:, free]
    C = None if given.C is None else given.C[free][:, free]
    if len(both := np.intersect1d(wanted, fixed)):
        raise InputError(f"{where}.fixed: node {both[0]} carries a contact, tie, load or output")
    rows = np.flatnonzero(kept_rows(node, direction, named))
    for n in wanted:
        if n not in node[rows]:
            raise InputError(f"{where}: node {n} has no displacement among its {given.size} rows")
    columns = on_rows(forces, node, direction, fixed)
    if faces is None and len(rows) == len(node):
        block = _whole_block(K, M, C)
        act = _whole(forces, columns)
        return _piece(name, ring, given, node, direction, {-1: block}, forces=act)
    chosen = keys.modes, keys.cutoff, keys.accuracy
    if chosen == (None, None, None):
        chosen = None, None, DEFAULT
    selection = rom.Selection(*chosen, keys.band, least)
    joined, seen = None, Seen((), (), rows)
    if faces is None:
        seen = seen_from(gathered.followed(name), rows, node, direction, K, M)
        if forces:
            seen = replace(seen, digests=tuple(each.digest for each in forces), forces=columns)
    else:
        joined = _faces(where, ring, given, node, direction, faces)
        if len(shared := np.intersect1d(wanted, np.concatenate(faces))):
            raise InputError(
                f"{where}: node {shared[0]} carries a contact, tie, load or output and lies on "
                "a cyclic face"
            )
    try:
        if joined is None:
            found, rows, seen = _held(K, M, seen, rows, selection, C)
        else:
            found = rom.reduce_sector(K, M, rows, joined, nodal_diameters, selection, C)
    except SingularError as error:
        gone = rows if joined is None else np.concatenate([rows, joined.high])
        at = int(np.setdiff1d(np.arange(len(node)), gone)[error.rows[0]])
        moving = f"node {node[at]}, {WORDS[direction[at]]}" if direction[at] < 6 else f"row {at}"
        raise InputError(
            f"{where}: can still move although its contact, tie, load and output nodes are held "
            f"({error.count} free motions, most at {moving}): clamp nodes by fixed, or tie it"
        ) from None
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    first = next(iter(found.values()))
    none = np.zeros(first.vectors, np.int64)
    return _piece(
        name,
        ring,
        given,
        np.concatenate([node[rows], none]),
        np.concatenate([direction[rows], none + GENERALISED]),
        {k: each.matrices for k, each in found.items()},
        common_band(each.reach for each in found.values()),
        **seen.by(first),
    )


def _held(
    K: sp.csc_array,
    M: sp.csc_array,
    seen: Seen,
    every: Integers,
    selection: rom.Selection,
    C: sp.csc_array | None,
) -> tuple[dict[int, rom.ReducedRows], Integers, Seen]:
    """A component reduced to rows, and to those beside that it takes to hold it; which they are.

    Where the rows of what is followed hold it, these are kept, and nothing is followed.
    """
    rows, columns = seen.rows, seen.columns(K.shape[0])
    try:
        return {-1: rom.reduce_rows(K, M, rows, selection, C, *columns)}, rows, seen
    except SingularError as error:
        if len(rows) < len(every):
            held = replace(seen, pushed=(), shown=(), rows=every)
            return _held(K, M, held, every, selection, C)
        alone = np.count_nonzero(error.motions) == error.count  # rows without stiffness
        if error.count == SOUGHT or alone:
            raise
        pivots = sl.qr(error.motions.T, mode="r", pivoting=True)[1][: error.count]
        rest = np.setdiff1d(np.arange(K.shape[0]), rows)
        rows = np.sort(np.append(rows, rest[pivots]))
        try:
            return {-1: rom.reduce_rows(K, M, rows, selection, C, *columns)}, rows, seen
        except SingularError:
            raise error from None


def _whole(forces: Sequence[NodalForces], columns: sp.csc_array) -> dict[str, Matrix]:
    """Forces (n,) of files by their digests, on coordinates that are the rows."""
    return {f.digest: column for f, column in zip(forces, columns.toarray().T, strict=True)}


def _whole_block(K: sp.csc_array, M: sp.csc_array, C: sp.csc_array | None) -> rom.Reduced:
    """Matrices that leave nothing out."""
    own = None if C is None else C.toarray()
    return rom.Reduced(K.toarray(), M.toarray(), complete=np.inf, C=own)


def _piece(
    name: str,
    ring: SceneRingKeys,
    matrices: Matrices,
    node: Integers,
    direction: Integers,
    blocks: dict[int, rom.Reduced],
    band: float | None = None,
    **more: Any,
) -> Piece:
    for block in blocks.values():
        try:
            rom.refuse_negative_mass(block.M)
        except InputError as error:
            raise InputError(f"components.{name}: {error}") from None
    positions = np.empty((0, 3)) if matrices.position is None else matrices.position
    at = matrices.position_node, positions
    return Piece(name, node, direction, ring.sectors, blocks, *at, band, **more)


def _mass(name: str, matrices: Matrices) -> sp.csc_array:
    if matrices.M is None:
        raise InputError(f"components.{name}.mass: must be given")
    return matrices.M


def refuse_unknown(where: str, component: Matrices, nodes: Integers) -> None:
    """Refuse nodes that matrices do not have, `where` they are named."""
    if len(missing := np.setdiff1d(nodes, component.node)):
        raise InputError(f"{where}: node {missing[0]} is not among the matrices' nodes")


def _faces(
    where: str,
    ring: SceneRingKeys,
    matrices: Matrices,
    node: Integers,
    direction: Integers,
    faces: tuple[Integers, Integers],
) -> rom.Faces:
    """Rows of the faces, and how the high one follows."""
    low, high = faces
    if ring.sectors < 2:
        raise InputError(f"{where}.low: cyclic faces need ring.sectors of at least 2")
    if len(low) != len(high):
        raise InputError(f"{where}.high: {len(high)} nodes, and {len(low)} in low")
    refuse_unknown(f"{where}.low", matrices, low)
    refuse_unknown(f"{where}.high", matrices, high)
    both = np.concatenate(faces)
    if len(np.unique(both)) < len(both):
        again = next(n for n in both if np.sum(both == n) > 1)
        raise InputError(f"{where}.low, high: node {again} is there twice")
    if matrices.position is not None:  # where nodes' places are known, mates have to meet
        (at, there), (mate, mated) = (among(matrices.position_node, each) for each in faces)
        expected = matrices.position[at] @ turn(ring.sectors).T
        apart = np.linalg.norm(matrices.position[mate] - expected, axis=1)
        radius = np.linalg.norm(expected, axis=1).clip(min=1e-300)
        if np.any(far := there & mated & (apart > TOGETHER * radius)):
            raise InputError(
                f"{where}.high: node {high[far][0]} lies {apart[far][0]:.3g} m from where its mate "
                f"{low[far][0]} of low comes when turned by 360/{ring.sectors} degrees about z"
            )
    lows, highs = (rows_of(node, direction, each, 6) for each in faces)
    moves = lows >= 0
    if np.any(differ := np.any(moves != (highs >= 0), axis=1)):
        a, b = low[differ][0], high[differ][0]
        raise InputError(f"{where}.low: node {a} and its mate {b} differ in their directions")
    around = np.eye(6)
    if ring.coordinates == "cartesian":
        around[:3, :3] = around[3:, 3:] = turn(ring.sectors)
    if np.any(mixed := moves[:, :, None] & ~moves[:, None, :] & (around != 0)):
        i, d, e = np.argwhere(mixed)[0]
        raise InputError(
            f"{where}.low: node {low[i]} moves in {WORDS[d]} and not in {WORDS[e]}: the "
            "turn to the next sector mixes the two; use cylindrical coordinates"
        )
    turned = sp.csc_array(sp.kron(sp.eye_array(len(low)), sp.coo_array(around)))
    own = np.flatnonzero(moves)
    return rom.Faces(lows[moves], highs[moves], turned[own][:, own], ring.sectors)
