"""Ansys archives written by hand."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh import Part

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


def real(x: float) -> str:
    """E21.13E3: an exponent of three digits."""
    mantissa, exponent = f"{x:.13E}".split("E")
    return f"{mantissa}E{int(exponent):+04d}".rjust(21)


def nodes_block(numbers: Integers, points: Floats) -> list[str]:
    """NBLOCK, in mm."""
    lines = [f"NBLOCK,6,SOLID,{len(numbers):9d},{len(numbers):9d}", "(3i9,6e21.13e3)"]
    for number, place in zip(numbers.tolist(), 1e3 * points, strict=True):
        lines.append(f"{number:9d}{0:9d}{0:9d}" + "".join(map(real, place.tolist())))
    return [*lines, "N,R5.3,LOC,       -1,"]


def element(number: int, kind: int, nodes: list[int]) -> list[str]:
    """Lines of an element of EBLOCK: eleven numbers, eight nodes, and the rest of them."""
    head = [1, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, number]
    rows = [[*head, *nodes[:8]], nodes[8:]]
    return ["".join(f"{each:9d}" for each in row) for row in rows if row]


def elements_block(elements: list[list[str]]) -> list[str]:
    """EBLOCK."""
    count = f"{len(elements):9d}"
    lines = [line for each in elements for line in each]
    return [f"EBLOCK,19,SOLID,{count},{count}", "(19i9)", *lines, "       -1"]


def component_block(name: str, kind: str, numbers: Integers) -> list[str]:
    """CMBLOCK of nodes or of elements."""
    own = np.sort(numbers).tolist()
    rows = [own[i : i + 8] for i in range(0, len(own), 8)]
    lines = ["".join(f"{each:10d}" for each in row) for row in rows]
    return [f"CMBLOCK,{name.upper():8s},{kind},{len(own):8d}  ! users component", "(8i10)", *lines]


def degenerated(path: Path, part: Part, first: int = 11) -> Path:
    """Quadratic tetrahedra as Ansys writes those of a SOLID186: by the manuals, not a library."""
    numbers = np.arange(first, first + len(part.points))
    elements = []
    for number, cell in enumerate(numbers[part.cells].tolist(), 1):
        i, j, k, m, ij, jk, ki, im, jm, km = cell
        corners = [i, j, k, k, m, m, m, m]
        elements.append(element(number, 1, [*corners, ij, jk, k, ki, m, m, m, m, im, jm, km, km]))
    lines = ["/PREP7", "ET,1,186", *nodes_block(numbers, part.points), *elements_block(elements)]
    for name, nodes in part.node_sets.items():
        lines += component_block(name, "NODE", numbers[nodes])
    path.write_text("\n".join([*lines, "/GO", "FINISH"]) + "\n")
    return path


def with_surface(path: Path, part: Part, faces: Integers, name: str) -> Path:
    """Linear hexahedra, SOLID185, and a component of surface elements, SURF154, on some faces."""
    numbers = np.arange(1, 1 + len(part.points))
    elements = [element(n, 1, cell) for n, cell in enumerate(numbers[part.cells].tolist(), 1)]
    first = len(elements) + 1
    elements += [element(n, 2, face) for n, face in enumerate(numbers[faces].tolist(), first)]
    lines = ["/PREP7", "ET,1,185", "ET,2,154", *nodes_block(numbers, part.points)]
    lines += elements_block(elements)
    lines += component_block(name, "ELEM", np.arange(first, first + len(faces)))
    path.write_text("\n".join([*lines, "/GO", "FINISH"]) + "\n")
    return path
