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
from vanelock.fem.matrix_files.choosing import WantedMatrix, chosen
from vanelock.fem.matrix_files.entries import SYMMETRIC, Entries

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][+-]?\d+)?")
_TYPES = {"stiffness": "STIFFNESS", "mass": "MASS", "damping": "VISCOUS DAMPING"}


def read_superelement(source: str, held: str, wanted: WantedMatrix) -> Entries:
    """Read the matrix that is wanted from a superelement's text.

    Raises
    ------
    InputError
        With the file's name.
    """
    nodes: list[int] = []
    freedoms: dict[int, list[int]] = {}
    matrices: dict[str, list[float]] = {}
    part, comment = "", ""
    for number, line in _lines(held):
        where = f"{source}: line {number}"
        if line.startswith("**"):
            told = line.strip("* ").upper()
            if comment == "ELEMENT NODES" and re.fullmatch(r"[\d\s,-]+", told):
                nodes += [int(word) for word in re.findall(r"-?\d{1,12}", told)]
            else:
                comment = told
        elif line.startswith("*"):
            keyword = re.sub(r"\s+", "", line.upper())
            kind = re.fullmatch(r"\*MATRIX,TYPE=([A-Z]+)", keyword)
            part = kind[1] if kind else "freedoms" if keyword.startswith("*USERELEMENT") else ""
            if part == "freedoms" and freedoms:
                raise InputError(f"{where}: a second element: one superelement is read")
            if kind and matrices.setdefault(part, []):
                raise InputError(f"{where}: a second matrix {part}")
        elif part == "freedoms":
            _freedoms(where, line, freedoms)
        elif part:
            matrices[part] += _numbers(where, line)
    names = {
        ("damping" if key == "VISCOUSDAMPING" else key.lower()): values
        for key, values in matrices.items()
    }
    values = names[chosen(source, list(names), wanted)]
    node, direction = _labels(source, nodes, freedoms)
    n = len(node)
    if len(values) != n * (n + 1) // 2:
        raise InputError(
            f"{source}: {len(values):,} entries: one triangle of {n} freedoms has "
            f"{n * (n + 1) // 2:,}"
        )
    rows, columns = np.tril_indices(n)
    return Entries(source, n, rows, columns, np.array(values), SYMMETRIC, node, direction)


def _lines(held: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(held.splitlines(), start=1):
        if stripped := line.strip():
            yield number, stripped


def _freedoms(where: str, line: str, freedoms: dict[int, list[int]]) -> None:
    """A line of them: at the first node without its place, later after it."""
    words = [word.strip() for word in line.strip(" ,").split(",")]
    if not all(re.fullmatch(r"\d{1,9}", word) for word in words):
        raise InputError(f"{where}: not a list of freedoms")
    numbers = [int(word) for word in words]
    place = numbers.pop(0) if freedoms else 1
    if place in freedoms or place < 1 or any(not 1 <= freedom <= 6 for freedom in numbers):
        raise InputError(f"{where}: freedoms 1 to 6 are read, once for a place among the nodes")
    freedoms[place] = numbers


def _numbers(where: str, line: str) -> list[float]:
    words = [word.strip() for word in line.strip(" ,").split(",")]
    if not all(map(_NUMBER.fullmatch, words)):
        raise InputError(f"{where}: not a list of numbers")
    return [float(re.sub("[dD]", "e", word)) for word in words]


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
