"""What a mesh file says: numbered nodes, elements and sets; and the checked mesh made of it."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.mesh.part import Part


@dataclass(frozen=True)
class CellBlock:
    """Elements of one type."""

    cell_type: str  # meshio's name, or the file's own where meshio has none
    numbers: Integers  # (e,), the file's numbers of the elements
    nodes: Integers  # (e, k), the file's numbers of their nodes, corners first


@dataclass
class RawMesh:
    """Contents of a mesh file, all of it by the file's own numbers."""

    source: str  # what errors call the file
    numbers: Integers  # (n,), of the nodes
    points: Floats  # (n, 3), their coordinates in the file's unit
    blocks: list[CellBlock] = field(default_factory=list)  # elements of any dimension
    node_sets: dict[str, Integers] = field(default_factory=dict)
    """By name (k,), nodes in the file's order."""
    element_sets: dict[str, Integers] = field(default_factory=dict)  # by name (k,), elements
    face_sets: dict[str, list[Integers]] = field(default_factory=dict)  # corner nodes of faces
    repeated: bool = False  # whether the format repeats an element for each set that it belongs to
    unread: Counter[str] = field(default_factory=Counter)
    """Elements that have stiffness or mass and are not in the blocks, by the file's names."""

    @cached_property
    def _places(self) -> dict[int, tuple[CellBlock, int]]:
        """Block and row of each element."""
        return {
            number: (block, i)
            for block in self.blocks
            for i, number in enumerate(block.numbers.tolist())
        }

    def elements(self, numbers: Integers) -> list[tuple[CellBlock, Integers]]:
        """Block and nodes of those elements that exist, once all blocks are there."""
        places = [self._places[n] for n in numbers.tolist() if n in self._places]
        return [(block, np.asarray(block.nodes[i])) for block, i in places]


def distinct(numbers: Iterable[int] | Integers) -> Integers:
    """Each number once, in order of first appearance."""
    given = np.asarray(
        numbers if isinstance(numbers, np.ndarray) else list(numbers), dtype=np.int64
    )
    return given[np.sort(np.unique(given, return_index=True)[1])]


@dataclass(frozen=True)
class FileMesh(Product):
    """A part's mesh from a file, not yet matched to its mates.

    Attributes
    ----------
    source : str
        What errors call the file.
    points : (n, 3) float
        Nodes, m; each belongs to an element.
    numbers : (n,) int
        The file's numbers of the nodes.
    cells : (e, k) int
        Nodes of each element, in meshio's order for `cell_type`.
    elements : (e,) int
        The file's numbers of the elements.
    cell_type : str
        meshio's name: tetra, tetra10, hexahedron, hexahedron20 or hexahedron27.
    node_sets : dict of str to (k,) int
        Nodes of every set of the file, of element and of face sets too, in the file's order.
    face_sets : dict of str to (f, c) int
        Corner nodes of the faces of those sets that consist of faces of the solid elements.
    absent : dict of str to (k,) int
        The file's numbers of those nodes of a set that belong to no solid element.
    """

    source: str
    points: Floats = field(metadata={"unit": "m"})
    numbers: Integers
    cells: Integers
    elements: Integers
    cell_type: str
    node_sets: dict[str, Integers]
    face_sets: dict[str, Integers]
    absent: dict[str, Integers]

    def part(self) -> Part:
        """The same as a whole part, with the file's node sets and no contact frames."""
        return Part(self.source, self.points, self.cells, self.cell_type, self.node_sets, {}, 1)


_MOST_LISTED = 10_000_000
"""Members of all sets of a file; a mesh at the limit of its nodes has a third of a million."""
_BARE_EXPONENT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def integer(text: str, where: str) -> int:
    """A whole number out of a file."""
    try:
        number = int(text.replace("_", "?"))
    except ValueError:
        raise InputError(f"{where}: {_shortened(text)} is not a whole number") from None
    if abs(number) >= 10**15:
        raise InputError(f"{where}: {_shortened(text)} is too large")
    return number


def real(text: str, where: str) -> float:
    """A real number, whose exponent may be called D, or lack its letter as in 1.5-3."""
    spelt = _BARE_EXPONENT.sub(r"E\1", text.upper().replace("D", "E").replace("_", "?"))
    try:
        return float(spelt)
    except ValueError:
        raise InputError(f"{where}: {_shortened(text)} is not a number") from None


def _shortened(text: str) -> str:
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
    if total > _MOST_LISTED:
        raise InputError(f"{where}: the sets have more than {_MOST_LISTED:,} members so far")
    return total
