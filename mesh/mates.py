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
) -> tuple[Integers, list[str]]:
    """For each place of one set the node of the other set that lies there.

    Parameters
    ----------
    own, other : (k, 3) float
        Places of both sets, m, the other's turned to where it meets this one.
    tolerance : float
        How far mates may lie apart, m.
    sets : (str, str)
        What errors call the sets.
    tellers : (callable, callable)
        What they call their nodes.

    Returns
    -------
    (k,) int
        Rows of `other`; of no use where there is a report.
    list of str
        Lines on nodes without a mate, the furthest first, and on nodes that share one.
    """
    problems = []
    trees = cKDTree(own), cKDTree(other)
    to_other, nearest = trees[1].query(own)
    to_own, _ = trees[0].query(other)
    for distance, side in ((to_other, 0), (to_own, 1)):
        far = np.flatnonzero(~(distance <= tolerance))
        if not len(far):
            continue
        far = far[np.argsort(-distance[far], kind="stable")]
        listed = [f"{tellers[side](int(i))} {millimetres(distance[i])}" for i in far[:SHOWN]]
        more = ", ..." if len(far) > SHOWN else ""
        problems.append(
            f"{sets[side]}: {len(far)} of {len(distance)} nodes are further than "
            f"{millimetres(tolerance)} from the nearest node of {sets[1 - side]}: "
            f"{', '.join(listed)}{more}"
        )
    if not problems:
        shared = np.flatnonzero(np.bincount(nearest, minlength=len(other)) > 1)
        if len(shared):
            own_two = np.flatnonzero(nearest == shared[0])[:2]
            told = " and ".join(tellers[0](int(i)) for i in own_two)
            problems.append(
                f"{sets[0]}: {told} both meet {tellers[1](int(shared[0]))} of {sets[1]}"
            )
        elif len(own) != len(other):
            lost = np.setdiff1d(np.arange(len(other)), nearest)[0]
            problems.append(
                f"{sets[1]}: {tellers[1](int(lost))} lies where another one meets {sets[0]}"
            )
    return np.asarray(nearest, np.int64), problems


def millimetres(length: float) -> str:
    """A length for a report."""
    return f"{1e3 * length:.4g} mm"
