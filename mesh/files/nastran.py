"""Read the mesh of a Nastran bulk data file: `GRID`, solid elements, and the sets of its cards.

meshio's own reader of this format drops the sets, the coordinate systems and elements in large
fields. Cards and sets after MSC Nastran's Quick Reference Guide.
"""

import re
from collections.abc import Iterator

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError
from vanelock.mesh.files.raw import CellBlock, RawMesh, counted, distinct, integer, real, span

_SOLIDS = {  # name, nodes of the linear and of the quadratic element
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
}
_FLAT = {
    "CTRIA3": (3, "triangle"),
    "CTRIA6": (6, "triangle6"),
    "CTRIAR": (3, "triangle"),
    "CQUAD4": (4, "quad"),
    "CQUAD8": (8, "quad8"),
    "CQUADR": (4, "quad"),
}
_RODS = ("CBAR", "CBEAM", "CROD")
_PROPERTY = re.compile(r"P(SHELL|COMP|BAR|BEAM|ROD)")
"""Flat elements and rods without one of these have no stiffness: they serve sets."""
_OTHER = re.compile(
    r"C(ELAS|BUSH|DAMP|VISC|GAP|MASS|ONM|ONROD|TUBE|BEND|BEAM3|SHEAR|FAST|WELD|SEAM|IHEX|IFHEX|IFPENT|"
    r"HEXCZ|PENTCZ|RAC|TRIAX|QUADX)|RBE[12]$|RBAR|RROD|RTRPLT|RJOINT|GENEL"
)
"""Elements with stiffness, mass or damping that are not read."""
# Nastran lists a hexahedron's upright sides before those of its top, VTK after them.
_TO_VTK = {"hexahedron20": [*range(12), *range(16, 20), *range(12, 16)]}


def read_nastran(source: str, text: str) -> RawMesh:
    """Read a file's text, with or without the executive and case control before `BEGIN BULK`.

    Sets are called by their number, "12", from `SET` in the case control and `SET1` and `SET3` in
    the bulk data.
    """
    lines = lines_of(text)
    sets = _case_sets(source, lines)
    numbers, places, listed = [], [], 0
    elements: dict[str, tuple[list[int], list[list[int]]]] = {}
    others: list[tuple[str, str]] = []
    properties: set[str] = set()
    for number, name, fields in cards(lines):
        at = f"{source}: line {number}"
        if name == "INCLUDE":
            raise InputError(f"{at}: INCLUDE is not read: write one file")
        if name == "GRID":
            numbers.append(integer(_field(fields, 0), at))
            if _field(fields, 1) not in ("", "0"):
                raise InputError(
                    f"{at}: node {numbers[-1]} is given in coordinate system {fields[1]}: write "
                    "the file in the basic one"
                )
            places.append([real(_field(fields, i) or "0", at) for i in (2, 3, 4)])
        elif name == "GRDSET" and _field(fields, 1) not in ("", "0"):
            raise InputError(f"{at}: GRDSET: write the nodes in the basic coordinate system")
        elif _PROPERTY.match(name):
            properties.add(_field(fields, 0))
        elif _OTHER.match(name):
            others.append((name, ""))
        elif name in _RODS or name in _FLAT:
            others.append((name, _field(fields, 1) or _field(fields, 0)))
        if name in _SOLIDS or name in _FLAT:
            kind, nodes = _element(name, fields[2:], at)
            both = elements.setdefault(kind, ([], []))
            both[0].append(integer(_field(fields, 0), at))
            both[1].append(nodes)
        elif name in ("SET1", "SET3"):
            if name == "SET3" and _field(fields, 1).upper() != "GRID":
                continue
            own = [word for word in fields[1 if name == "SET1" else 2 :] if word]
            members = _listed(own, at)
            listed = counted(listed, members, at)
            sets.setdefault(_field(fields, 0), []).append(members)
    raw = RawMesh(source, np.array(numbers, np.int64), np.array(places, float).reshape(-1, 3))
    raw.unread.update(name for name, by in others if not by or by in properties)
    for kind, (own_numbers, lists) in elements.items():
        table = np.array(lists, np.int64)
        table = table[:, _TO_VTK.get(kind, slice(None))]
        raw.blocks.append(CellBlock(kind, np.array(own_numbers, np.int64), table))
    raw.node_sets = {key: distinct(np.concatenate(parts)) for key, parts in sets.items()}
    return raw


def _field(fields: list[str], i: int) -> str:
    return fields[i] if i < len(fields) else ""


def _element(name: str, fields: list[str], where: str) -> tuple[str, list[int]]:
    if name in _FLAT:
        count, kind = _FLAT[name]
        nodes = [word for word in fields[:count]]
    else:
        nodes = [word for word in fields if word]
        kind = _SOLIDS[name].get(len(nodes), "")
        count = len(nodes)
        if not kind:
            allowed = " or ".join(map(str, _SOLIDS[name]))
            raise InputError(f"{where}: {name} with {count} nodes: it must have {allowed}")
    return kind, [integer(word, where) for word in nodes]


def _case_sets(source: str, lines: list[str]) -> dict[str, list[Integers]]:
    """Sets of the case control, `SET 12 = 1, 2, 5 THRU 9`; a line that ends in a comma goes on."""
    found: dict[str, list[Integers]] = {}
    joined, started, listed = "", 0, 0
    for number, line in enumerate(lines, start=1):
        if not joined:
            started = number
        joined += line.strip()
        if joined.endswith(",") and re.match(r"SET\b", joined, re.IGNORECASE):
            joined += " "
            continue
        match = re.match(r"SET\s+(\d+)\s*=(.*)$", joined, re.IGNORECASE)
        joined = ""
        if match and match[2].strip().upper() != "ALL":
            words = re.split(r"[,\s]+", match[2].strip().strip(","))
            members = _listed(words, f"{source}: line {started}")
            listed = counted(listed, members, f"{source}: line {started}")
            found[match[1]] = [members]
    return found


def _listed(words: list[str], where: str) -> Integers:
    """Numbers of a list with THRU, BY and EXCEPT."""
    found: list[Integers] = [np.empty(0, np.int64)]
    i, end, total = 0, 0, 0
    excepting = False  # what follows EXCEPT is left out, up to the range's end
    while i < len(words):
        if words[i].upper() == "EXCEPT":
            excepting, i = True, i + 1
            continue
        low = integer(words[i], where)
        excepting = excepting and low <= end
        numbers = np.array([low])
        if i + 1 < len(words) and words[i + 1].upper() == "THRU":
            if i + 2 >= len(words):
                raise InputError(f"{where}: THRU without an end")
            step = 1
            high = integer(words[i + 2], where)
            i += 2
            if i + 2 < len(words) and words[i + 1].upper() == "BY":
                step = integer(words[i + 2], where)
                i += 2
            numbers, end, excepting = span(low, high, step, where), high, False
            total = counted(total, numbers, where)
        if excepting:
            found[-1] = found[-1][~np.isin(found[-1], numbers)]
        else:
            found.append(numbers)
        i += 1
    return np.concatenate(found)


def lines_of(text: str) -> list[str]:
    """A deck's lines, without comments and tabs."""
    return [line.partition("$")[0].rstrip().expandtabs(8) for line in text.splitlines()]


def cards(lines: list[str]) -> Iterator[tuple[int, str, list[str]]]:
    """Each card of the bulk data: its line's number, its name, its data fields.

    The bulk data begin after `BEGIN BULK`, or with the first line where there is none. A line has
    8 fields, 4 if they are large, empty ones too.
    """
    heads = (line.upper().split()[:2] for line in lines)
    begin = next((i for i, head in enumerate(heads, start=1) if head == ["BEGIN", "BULK"]), 0)
    current: tuple[int, str, list[str]] | None = None
    for number, line in enumerate(lines[begin:], start=begin + 1):
        if not line.strip():
            continue
        head, fields = _fields(line)
        if head == "" or head[0] in "+*":
            if current is not None:
                current[2].extend(fields)
            continue
        if current is not None:
            yield current
        if head.upper().startswith("ENDDATA"):
            return
        words = head.upper().split()  # control statements are not in fields
        current = number, words[0].rstrip("*"), fields
    if current is not None:
        yield current


def _fields(line: str) -> tuple[str, list[str]]:
    """First field of a line, and its data fields."""
    if "," in line:
        head, *rest = (word.strip() for word in line.split(","))
        count = 4 if head.endswith("*") or head.startswith("*") else 8
    else:
        head = line[:8].strip()
        large = head.endswith("*") or head.startswith("*")
        width, count = (16, 4) if large else (8, 8)
        rest = [line[8 + i * width : 8 + (i + 1) * width].strip() for i in range(count)]
    return head, (rest + [""] * count)[:count]
