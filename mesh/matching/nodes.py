"""Which node meets which, one to one and within a tolerance, and the report where none does."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Teller = Callable[[int], str]
"""What errors call the i-th node of a set."""

SHOWN = 5  # nodes in a report


def mates(
    own: Array,
    other: Array,
    tolerance: float,
    sets: tuple[str, str],
    tellers: tuple[Teller, Teller],
    size: float = np.inf,
) -> tuple[Integers, list[str]]:
    """For each place of one set the node of the other set that lies there."""
    problems = []
    trees = cKDTree(own), cKDTree(other)
    to_other, nearest = trees[1].query(own)
    to_own, _ = trees[0].query(other)
    lost = [_far(to_other, tolerance, tellers[0]), _far(to_own, tolerance, tellers[1])]
    if any(count for count, _ in lost):
        first = 1 if lost[1][0] else 0  # the set whose nodes would be moved, first
        (count, listed), (back, furthest) = lost[first], lost[1 - first]
        total = len(own), len(other)
        line = (
            f"{sets[first]}: {count} of {total[first]} nodes {'is' if count == 1 else 'are'} "
            f"further than {millimetres(tolerance)} from the nearest node of {sets[1 - first]}: "
            f"{', '.join([*listed, '...'] if count > SHOWN else listed)}"
        )
        if back:
            line += f"; the other way round {back} of {total[1 - first]}, such as {furthest[0]}"
        if max(to_other.max(), to_own.max()) > size:
            line += ": is the unit right?"
        problems.append(line)
    if not problems:
        shared = np.flatnonzero(np.bincount(nearest, minlength=len(other)) > 1)
        if len(shared):
            own_two = np.flatnonzero(nearest == shared[0])[:2]
            both = " and ".join(tellers[0](int(i)) for i in own_two)
            problems.append(
                f"{sets[0]}: {both} both meet {tellers[1](int(shared[0]))} of {sets[1]}"
            )
        elif len(own) != len(other):
            alone = np.setdiff1d(np.arange(len(other)), nearest)[0]
            problems.append(
                f"{sets[1]}: {tellers[1](int(alone))} lies where another one meets {sets[0]}"
            )
    return np.asarray(nearest, np.int64), problems


def _far(distance: Array, tolerance: float, teller: Teller) -> tuple[int, list[str]]:
    """How many nodes have no mate, and a report on each one that may be shown, furthest first."""
    far = np.flatnonzero(~(distance <= tolerance))
    far = far[np.argsort(-distance[far], kind="stable")]
    return len(far), [f"{teller(int(i))} {millimetres(distance[i])}" for i in far[:SHOWN]]


def millimetres(length: float) -> str:
    """A length for a report."""
    return f"{1e3 * length:.4g} mm"
