"""What a mesh file says, before anything is made of it: numbered nodes, elements and sets."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


MOST_LISTED = 10_000_000
"""Members of all sets of a file; a mesh at the limit of its nodes has a third of a million."""


@dataclass(frozen=True)
class CellBlock:
    """Elements of one type.

    Attributes
    ----------
    cell_type : str
        meshio's name, or the file's own where meshio has none.
    numbers : (e,) int
        The file's numbers of the elements.
    nodes : (e, k) int
        The file's numbers of their nodes, corners first.
    """

    cell_type: str
    numbers: Integers
    nodes: Integers


@dataclass
class RawMesh:
    """Contents of a mesh file, all of it by the file's own numbers.

    Attributes
    ----------
    source : str
        What errors call the file.
    numbers : (n,) int
        Of the nodes.
    points : (n, 3) float
        Their coordinates in the file's unit.
    blocks : list of CellBlock
        Elements of any dimension.
    node_sets : dict of str to (k,) int
        Nodes, in the file's order.
    element_sets : dict of str to (k,) int
        Elements.
    face_sets : dict of str to list of (f, c) int
        Corner nodes of faces.
    repeated : bool
        Whether the format repeats an element for each set that it belongs to.
    """

    source: str
    numbers: Integers
    points: Array
    blocks: list[CellBlock] = field(default_factory=list)
    node_sets: dict[str, Integers] = field(default_factory=dict)
    element_sets: dict[str, Integers] = field(default_factory=dict)
    face_sets: dict[str, list[Integers]] = field(default_factory=dict)
    repeated: bool = False


def whole(text: str, where: str) -> int:
    """A whole number out of a file.

    Raises
    ------
    InputError
        Where it is none, or too large to number anything.
    """
    try:
        number = int(text)
    except ValueError:
        raise InputError(f"{where}: {shortened(text)} is not a whole number") from None
    if not -(2**62) < number < 2**62:
        raise InputError(f"{where}: {shortened(text)} is too large")
    return number


def shortened(text: str) -> str:
    """Text of a file, quoted, for an error's single line."""
    plain = "".join(c if c.isprintable() else "?" for c in text)
    return f'"{plain}"' if len(plain) <= 40 else f'"{plain[:37]}..."'


def span(low: int, high: int, step: int, where: str) -> Integers:
    """Numbers of a range with both ends."""
    if step < 1 or high < low:
        raise InputError(f"{where}: {low} to {high} by {step} is no range")
    if (high - low) // step > 5_000_000:
        raise InputError(f"{where}: the range {low} to {high} is too long")
    return np.arange(low, high + 1, step, dtype=np.int64)


def counted(total: int, more: Integers, where: str) -> int:
    """How many members all sets of a file have so far: short lines list very many."""
    total += len(more)
    if total > MOST_LISTED:
        raise InputError(f"{where}: the sets have more than {MOST_LISTED:,} members so far")
    return total


def distinct(numbers: Iterable[int] | Integers) -> Integers:
    """Each number once, in order of first appearance."""
    given = np.asarray(
        numbers if isinstance(numbers, np.ndarray) else list(numbers), dtype=np.int64
    )
    return given[np.sort(np.unique(given, return_index=True)[1])]
