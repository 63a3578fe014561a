"""The coordinates of several parts as one set, in which those that ties join are there once.

With S_p the 0-1 matrix from the joined coordinates to those of part p,

    K = Σ_p S_pᵀ K_p S_p.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Merged:
    """Joined coordinates.

    Attributes
    ----------
    places : tuple of (n_p,) int
        By part: the joined coordinate of each of its own.
    size : int
        Number of joined coordinates n.
    """

    places: tuple[Integers, ...]
    size: int

    def of(self, part: int, coordinates: Integers) -> Integers:
        """Joined coordinates of some of a part's; -1, what does not move, stays -1."""
        return np.where(coordinates < 0, -1, self.places[part][coordinates])

    def sum(self, matrices: Sequence[Any]) -> Any:
        """(n, n) Σ S_pᵀ A_p S_p of one matrix A_p a part, dense or sparse."""
        return sum(S.T @ A @ S for S, A in zip(self._selections, matrices, strict=True))

    @cached_property
    def _selections(self) -> list[sp.csr_array]:
        """(n_p, n) S_p of each part."""
        found = []
        for place in self.places:
            each = np.ones(len(place)), (np.arange(len(place)), place)
            found.append(sp.csr_array(each, shape=(len(place), self.size)))
        return found

    def rows(self, frames: Floats, at: Integers) -> sp.csr_array:
        """(3c, n) matrix with each 3x3 frame in the joined coordinates `at` (c, 3) of its node."""
        rows = np.broadcast_to(np.arange(3 * len(frames)).reshape(-1, 3, 1), frames.shape)
        columns = np.broadcast_to(at[:, None, :], frames.shape)
        moves = columns >= 0
        shape = (3 * len(frames), self.size)
        return sp.csr_array((frames[moves], (rows[moves], columns[moves])), shape=shape)


def merged(sizes: Sequence[int], ties: Sequence[Integers] = ()) -> Merged:
    """Join the coordinates of parts."""
    total = sum(sizes)
    i, j = np.concatenate([np.empty((0, 2), np.int64), *ties]).T
    graph = sp.csr_array((np.ones(len(i)), (i, j)), shape=(total, total))
    place = connected_components(graph, directed=False)[1]
    first = np.unique(place, return_index=True)[1]
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return Merged(tuple(np.split(rank[place], np.cumsum(sizes)[:-1])), len(first))
