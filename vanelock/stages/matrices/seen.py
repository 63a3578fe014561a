"""What loads and outputs see of a component without adding to its coordinates.

With x = T y the reduction, a load f acts on the coordinates as Tᵀ f, and row i moves as the row i
of T; the static answer to f is among the columns of T (`vanelock.rom.routes.rows`).
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Integers
from vanelock.rom import ReducedRows

Followed: TypeAlias = tuple[tuple[tuple[int, ...], ...], tuple[int, ...]]
"""Sets of nodes that are loaded, and nodes that are shown, which nothing joins to others."""


@dataclass(frozen=True)
class Seen:
    """Sets of loaded nodes and output nodes that are no coordinates.

    Attributes
    ----------
    pushed : tuple of ((k,) int, (k, 3) int)
        Nodes of each set, and their rows x, y, z.
    shown : tuple of (int, (3,) int)
        Output nodes, and their rows.
    rows : (m,) int
        Rows that are kept as coordinates.
    digests : tuple of str
        Files of nodal forces.
    forces : (n, f) sparse, optional
        What they hold, one a column, N.
    """

    pushed: tuple[tuple[Integers, Integers], ...]
    shown: tuple[tuple[int, Integers], ...]
    rows: Integers
    digests: tuple[str, ...] = ()
    forces: sp.csc_array | None = None

    def columns(self, size: int) -> tuple[sp.csc_array | None, Integers | None]:
        """(size, 3p + f) forces, and rows of outputs.

        Forces are units along x, y, z on each node of a set, and behind them those of files.
        """
        loads, outputs = self.forces, None
        if self.pushed:
            at = [rows[:, axis] for _, rows in self.pushed for axis in range(3)]
            column = np.repeat(np.arange(len(at)), [len(each) for each in at])
            entries = np.ones(len(column)), (np.concatenate(at), column)
            units = sp.csc_array(entries, shape=(size, len(at)))
            loads = units if loads is None else sp.hstack([units, loads], format="csc")
        if self.shown:
            outputs = np.concatenate([rows for _, rows in self.shown])
        return loads, outputs

    def by(self, reduced: ReducedRows) -> dict[str, Any]:
        """Fields of a `Piece`."""
        found: dict[str, Any] = {}
        if reduced.loads is not None:
            p, r = len(self.pushed), reduced.loads.shape[1]
            found["pushed"] = {i: nodes for i, (nodes, _) in enumerate(self.pushed)}
            found["loads"] = reduced.loads[: 3 * p].reshape(p, 3, r)
            found["forces"] = dict(zip(self.digests, reduced.loads[3 * p :], strict=True))
        if reduced.outputs is not None:
            found["shown"] = np.array([node for node, _ in self.shown], np.int64)
            found["outputs"] = reduced.outputs.reshape(len(self.shown), 3, -1)
        return found


def seen_from(
    followed: Followed,
    kept: Integers,
    node: Integers,
    direction: Integers,
    K: sp.csc_array,
    M: sp.csc_array,
) -> Seen:
    """What of loads and outputs need not be kept: nodes that move, with mass, in all directions."""
    inert = (K.diagonal().real > 0) & (M.diagonal().real > 0) & (direction < 3)
    own = np.flatnonzero(inert & np.isin(node, _all(followed)))
    place: dict[int, dict[int, int]] = {}
    for row in own:
        place.setdefault(int(node[row]), {})[int(direction[row])] = int(row)
    whole = {n: np.array([at[d] for d in range(3)]) for n, at in place.items() if len(at) == 3}
    pushed = [each for each in followed[0] if all(n in whole for n in each)]
    held = {n for each in followed[0] if each not in pushed for n in each}
    pushed = [each for each in pushed if held.isdisjoint(each)]
    shown = [n for n in followed[1] if n in whole and n not in held]
    gone = _all((tuple(pushed), tuple(shown)))
    rows = kept[~np.isin(node[kept], gone)]
    if not len(rows):
        return Seen((), (), kept)
    return Seen(
        tuple((np.array(each), np.array([whole[n] for n in each])) for each in pushed),
        tuple((n, whole[n]) for n in shown),
        rows,
    )


def _all(followed: Followed) -> Integers:
    return np.array([*{n for each in followed[0] for n in each}, *followed[1]], np.int64)
