"""A superelement as Abaqus and CalculiX write it (`*SUBSTRUCTURE MATRIX OUTPUT`): a user element.

    *USER ELEMENT, NODES= 3, LINEAR
    ** ELEMENT NODES
    ** 101, 102, 205
    1, 2, 3                       freedoms at the first node and at those after it
    3, 1, 2                       from the third on
    *MATRIX, TYPE=STIFFNESS       one triangle, row by row: K11, K21, K22, K31, ...

(Abaqus Keywords Reference, *USER ELEMENT and *MATRIX; CalculiX's substructure.f.)
"""

import re
from collections.abc import Iterator

import numpy as np

from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import WantedMatrix, chosen
from vanelock.fem.matrix_files.entries import SYMMETRIC, Entries
from vanelock.mesh.files.abaqus import Line, keywords
from vanelock.mesh.files.numbers import real, whole


def read_superelement(source: str, held: str, wanted: WantedMatrix) -> Entries:
    """Read the matrix that is wanted from a superelement's text."""
    freedoms: dict[int, list[int]] = {}
    matrices: dict[str, list[float]] = {}
    for number, keyword, options, lines in keywords(source, held):
        where = f"{source}: line {number}"
        if keyword == "USERELEMENT":
            if freedoms:
                raise InputError(f"{where}: a second element: one superelement is read")
            freedoms = _freedoms(source, lines)
        elif keyword == "MATRIX":
            kind = "".join(options.get("TYPE", "").split()).upper()
            if kind in matrices:
                raise InputError(f"{where}: a second matrix {kind}")
            matrices[kind] = [real(*word) for word in _words(source, lines)]
    names = {
        ("damping" if key == "VISCOUSDAMPING" else key.lower()): values
        for key, values in matrices.items()
    }
    values = names[chosen(source, list(names), wanted)]
    node, direction = _labels(source, _nodes(held), freedoms)
    n = len(node)
    if len(values) != n * (n + 1) // 2:
        raise InputError(
            f"{source}: {len(values):,} entries: one triangle of {n} freedoms has "
            f"{n * (n + 1) // 2:,}"
        )
    rows, columns = np.tril_indices(n)
    return Entries(source, n, rows, columns, np.array(values), SYMMETRIC, node, direction)


def _words(source: str, lines: list[Line]) -> Iterator[tuple[str, str]]:
    """Words of lines that may end in a comma, and where each stands."""
    for number, words in lines:
        for word in words if words[-1] else words[:-1]:
            yield word, f"{source}: line {number}"


def _nodes(held: str) -> list[int]:
    """The element's nodes, which stand in comments."""
    nodes: list[int] = []
    comment = ""
    for line in held.splitlines():
        if line.lstrip().startswith("**"):
            text = line.strip("* \t").upper()
            if comment == "ELEMENT NODES" and re.fullmatch(r"[\d\s,-]+", text):
                nodes += [int(word) for word in re.findall(r"-?\d{1,12}", text)]
            else:
                comment = text
    return nodes


def _freedoms(source: str, lines: list[Line]) -> dict[int, list[int]]:
    """Those at the first node, in a line without its place, and after the places of others."""
    freedoms: dict[int, list[int]] = {}
    for line in lines:
        numbers = [whole(*word) for word in _words(source, [line])]
        place = numbers.pop(0) if freedoms else 1
        if place in freedoms or place < 1 or any(not 1 <= freedom <= 6 for freedom in numbers):
            raise InputError(
                f"{source}: line {line[0]}: freedoms 1 to 6 are read, once for a place among the "
                "nodes"
            )
        freedoms[place] = numbers
    return freedoms


def _labels(source: str, nodes: list[int], freedoms: dict[int, list[int]]) -> tuple[
    np.ndarray[tuple[int], np.dtype[np.int64]], np.ndarray[tuple[int], np.dtype[np.int64]]
]:  # fmt: skip
    """Node and direction of each row, from the first node on."""
    if not nodes or not freedoms:
        raise InputError(f"{source}: the superelement lists no nodes or no freedoms")
    if max(freedoms) > len(nodes):
        raise InputError(f"{source}: freedoms of place {max(freedoms)} among {len(nodes)} nodes")
    node, direction = [], []
    active: list[int] = []
    for place, number in enumerate(nodes, start=1):
        active = freedoms.get(place, active)
        node += [number] * len(active)
        direction += [freedom - 1 for freedom in active]
    return np.array(node, np.int64), np.array(direction, np.int64)
