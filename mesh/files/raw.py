"""What a mesh file says, before anything is made of it: numbered nodes, elements and sets."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


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
    unread : Counter
        Elements that have stiffness or mass and are not in the blocks, by the file's names.
    """

    source: str
    numbers: Integers
    points: Array
    blocks: list[CellBlock] = field(default_factory=list)
    node_sets: dict[str, Integers] = field(default_factory=dict)
    element_sets: dict[str, Integers] = field(default_factory=dict)
    face_sets: dict[str, list[Integers]] = field(default_factory=dict)
    repeated: bool = False
    unread: Counter[str] = field(default_factory=Counter)


def distinct(numbers: Iterable[int] | Integers) -> Integers:
    """Each number once, in order of first appearance."""
    given = np.asarray(
        numbers if isinstance(numbers, np.ndarray) else list(numbers), dtype=np.int64
    )
    return given[np.sort(np.unique(given, return_index=True)[1])]
