"""Read the mesh of an Abaqus or CalculiX input deck: nodes, elements, sets and surfaces.

meshio's own reader of this format drops the nodes' numbers, the sets of `*NODE` and `*SURFACE`, and
all but the last block of a set given in several.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from vanelock.common.arrays import Integers
from vanelock.common.errors import InputError
from vanelock.mesh.files.raw import CellBlock, RawMesh, counted, distinct, integer, real, span

# A solid's name ends in letters for its formulation, which do not change its nodes.
_SOLIDS = {
    "C3D4": ("tetra", 4),
    "C3D10": ("tetra10", 10),
    "C3D8": ("hexahedron", 8),
    "C3D20": ("hexahedron20", 20),
    "C3D27": ("hexahedron27", 27),
    "C3D6": ("wedge", 6),
    "C3D15": ("wedge15", 15),
    "C3D5": ("pyramid", 5),
}
_MARKS = re.compile(r"(S|STRI|SFM3D|M3D|CPS|CPE|R3D|T3D|T2D)\d")
"""Elements that without a section have no stiffness."""
_FLAT = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
# Corners of the faces S1, S2, ... of a tetrahedron and of a hexahedron (Abaqus Analysis User's
# Guide, Three-dimensional solid element library).
_FACES: dict[str, list[tuple[int, ...]]] = {
    "tetra": [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    "hexah": [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
}


Line = tuple[int, list[str]]
"""A line's number and its words between commas."""


def keywords(source: str, text: str) -> Iterator[tuple[int, str, dict[str, str], list[Line]]]:
    """Each keyword: its line's number, its name, its options by name, its lines of data.

    Names are in upper case; a keyword's has no blanks: `USERELEMENT`.
    """
    current: tuple[int, str, dict[str, str], list[Line]] | None = None
    pending: list[str] = []  # a keyword's line that ends in a comma goes on
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.strip()
        if not line or line.startswith("**"):
            continue
        if pending or line.startswith("*"):
            pending.append(line)
            if line.endswith(","):
                continue
            if current is not None:
                yield current
            name, *given = (word.strip() for word in "".join(pending)[1:].split(","))
            pending = []
            pairs = (word.partition("=") for word in given if word)
            options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
            current = number, "".join(name.upper().split()), options, []
        elif current is not None:
            current[3].append((number, [word.strip() for word in line.split(",")]))
        else:
            raise InputError(f"{source}: line {number}: not an Abaqus deck: no keyword before it")
    if pending:
        raise InputError(f"{source}: ends within a keyword's options")
    if current is not None:
        yield current


@dataclass
class _Deck:
    """What a deck's keywords list, sets inside sets still by name."""

    source: str  # what errors call the file
    numbers: list[int] = field(default_factory=list)
    places: list[tuple[float, float, float]] = field(default_factory=list)
    elements: dict[str, tuple[list[int], list[list[int]]]] = field(default_factory=dict)
    node_sets: dict[str, list[str | Integers]] = field(default_factory=dict)
    element_sets: dict[str, list[str | Integers]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    sections: list[str] = field(default_factory=list)
    instances: int = 0  # how many parts the assembly has
    listed: int = 0  # members of all ranges of the sets


def _solid(name: str) -> tuple[str, int] | None:
    """Type and number of nodes; None where the name does not say, which its line ends then."""
    found = re.fullmatch(r"D?(C3D\d+)[A-Z]*", name)
    return _SOLIDS.get(found[1]) if found else None


def _resolved(deck: _Deck) -> RawMesh:
    """Numbers for the names of sets inside sets, blocks for the elements."""
    raw = RawMesh(
        deck.source, np.array(deck.numbers, np.int64), np.array(deck.places, float).reshape(-1, 3)
    )
    for name, (numbers, nodes) in deck.elements.items():
        by_count: dict[int, tuple[list[int], list[list[int]]]] = {}
        for number, own in zip(numbers, nodes, strict=True):
            both = by_count.setdefault(len(own), ([], []))
            both[0].append(number)
            both[1].append(own)
        for count, (some, tables) in by_count.items():
            solid = _solid(name)
            kind = solid[0] if solid else _mark(name, count)
            raw.blocks.append(CellBlock(kind, np.array(some, np.int64), np.array(tables, np.int64)))
    for name in deck.element_sets:
        raw.element_sets[name] = distinct(_members(deck, name, deck.element_sets, ()))
    stiff = [raw.element_sets[name] for name in deck.sections if name in raw.element_sets]
    for name, (numbers, _) in deck.elements.items():
        if not _solid(name) and stiff and (count := np.isin(numbers, np.concatenate(stiff)).sum()):
            raw.unread[name] += int(count) if _MARKS.match(name) else 0
    for name in deck.node_sets:
        raw.node_sets[name] = distinct(_members(deck, name, deck.node_sets, (), raw))
    for name, faces in deck.surfaces.items():
        found = [own for what, face in faces for own in _faces(raw, what, face)]
        if found:
            raw.face_sets[name] = found
    return raw


def _mark(name: str, count: int) -> str:
    """Shells, membranes and rods can mark faces and lines; anything else keeps the file's name."""
    return {**_FLAT, 2: "line"}.get(count, name) if _MARKS.match(name) else name


def _members(
    deck: _Deck,
    name: str,
    sets: dict[str, list[str | Integers]],
    above: tuple[str, ...],
    raw: RawMesh | None = None,
) -> Integers:
    if name in above:
        raise InputError(f"{deck.source}: the set {name} contains itself")
    found = [np.empty(0, np.int64)]
    for entry in sets[name]:
        if not isinstance(entry, str):
            found.append(entry)
        elif entry.startswith("elements ") and raw is not None:
            which = entry.removeprefix("elements ")
            if which not in deck.element_sets:
                raise InputError(f"{deck.source}: the set {name} names an absent set {which}")
            elements = _members(deck, which, deck.element_sets, ())
            found += [nodes for _, nodes in raw.elements(elements)]
        elif entry.rpartition(".")[2] in sets:
            inner = entry.rpartition(".")[2]
            found.append(_members(deck, inner, sets, (*above, name), raw))
        else:
            raise InputError(f"{deck.source}: the set {name} names an absent set {entry}")
    return np.concatenate(found)


def _faces(raw: RawMesh, what: str, face: str) -> list[Integers]:
    """Corner nodes of one line of a surface; none where its face is not one of a solid."""
    what = what.rpartition(".")[2]
    if what.isdigit():
        elements = np.array([int(what)])
    elif what in raw.element_sets:
        elements = raw.element_sets[what]
    else:
        raise InputError(f"{raw.source}: a surface names an absent element set {what}")
    found = []
    for block, nodes in raw.elements(elements):
        if block.cell_type.startswith(("triangle", "quad")) and face in ("", "SPOS", "SNEG"):
            found.append(nodes[: 3 if block.cell_type.startswith("triangle") else 4])
        corners = _FACES.get(block.cell_type[:5], [])
        number = int(face[1:]) if re.fullmatch(r"S\d", face) else 0
        if 1 <= number <= len(corners):
            found.append(nodes[list(corners[number - 1])])
    return found


_REFUSED = ("INCLUDE", "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


def read_abaqus(source: str, text: str) -> RawMesh:
    """Read a deck's text.

    Names of sets are told apart without regard to upper and lower case, as the format has it, and
    come out in upper case.
    """
    deck = _Deck(source)
    for number, keyword, options, lines in keywords(source, text):
        where = f"{source}: line {number}: *{keyword}"
        if keyword in _REFUSED or "INPUT" in options:
            raise InputError(f"{where} is not read: write one deck that lists nodes and elements")
        if keyword == "NODE":
            _nodes(deck, where, options, lines)
        elif keyword == "ELEMENT":
            _elements(deck, where, options, lines)
        elif keyword in ("NSET", "ELSET"):
            _set(deck, where, keyword, options, lines)
        elif keyword.endswith("SECTION"):
            if keyword != "SURFACESECTION" or "DENSITY" in options:
                deck.sections.append(options.get("ELSET", "").upper())
        elif keyword == "SURFACE":
            _surface(deck, where, options, lines)
        elif keyword == "INSTANCE":
            deck.instances += 1
            if deck.instances > 1 or lines:
                raise InputError(f"{where}: only one instance, neither moved nor turned, is read")
    return _resolved(deck)


def _nodes(deck: _Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
    if options.get("SYSTEM", "R").upper() != "R":
        raise InputError(f"{where}: only Cartesian coordinates are read")
    found = []
    for number, words in lines:
        at = f"{deck.source}: line {number}"
        if len(words) < 4:
            raise InputError(f"{at}: a node needs its number and three coordinates")
        found.append(integer(words[0], at))
        x, y, z = (real(word, at) for word in words[1:4])
        deck.places.append((x, y, z))
    deck.numbers += found
    if "NSET" in options:
        deck.node_sets.setdefault(options["NSET"].upper(), []).append(np.array(found, np.int64))


def _elements(deck: _Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
    name = options.get("TYPE", "").upper()
    if not name:
        raise InputError(f"{where}: its TYPE is missing")
    numbers, nodes = deck.elements.setdefault(name, ([], []))
    started = len(numbers)
    solid = _solid(name)
    count = solid[1] if solid else None
    item: list[int] = []
    for number, words in lines:
        at = f"{deck.source}: line {number}"
        item += [integer(word, at) for word in words if word]
        continues = not words[-1] if count is None else len(item) < count + 1
        if continues:
            continue
        if count is not None and len(item) > count + 1:
            raise InputError(f"{at}: {name} has {count} nodes, {len(item) - 1} are given")
        numbers.append(item[0])
        nodes.append(item[1:])
        item = []
    if item:
        raise InputError(f"{where}: the last element has {len(item) - 1} nodes, {name} {count}")
    if "ELSET" in options:
        own = np.array(numbers[started:], np.int64)
        deck.element_sets.setdefault(options["ELSET"].upper(), []).append(own)


def _set(deck: _Deck, where: str, keyword: str, options: dict[str, str], lines: list[Line]) -> None:
    name = options.get(keyword, "").upper()
    if not name:
        raise InputError(f"{where}: its name is missing")
    sets = deck.node_sets if keyword == "NSET" else deck.element_sets
    entries = sets.setdefault(name, [])
    if keyword == "NSET" and "ELSET" in options:
        entries.append(f"elements {options['ELSET'].upper()}")
    for number, words in lines:
        at = f"{deck.source}: line {number}"
        given = [word for word in words if word]
        if "GENERATE" in options:
            ends = [integer(word, at) for word in given]
            if len(ends) not in (2, 3):
                raise InputError(f"{at}: expected first, last and step of a range")
            members = span(ends[0], ends[1], ends[2] if len(ends) == 3 else 1, at)
            deck.listed = counted(deck.listed, members, at)
            entries.append(members)
            continue
        for word in given:
            last = word.rpartition(".")[2]  # "instance.12" is node 12
            entries.append(np.array([integer(last, at)]) if last.isdigit() else word.upper())


def _surface(deck: _Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
    name = options.get("NAME", "").upper()
    if not name:
        raise InputError(f"{where}: its name is missing")
    if options.get("TYPE", "ELEMENT").upper() != "ELEMENT":
        nodes = [word.upper() for _, words in lines for word in words[:1]]
        deck.node_sets.setdefault(name, []).extend(
            np.array([int(word)]) if word.isdigit() else word for word in nodes
        )
        return
    for _, words in lines:
        face = words[1].upper() if len(words) > 1 else ""
        deck.surfaces.setdefault(name, []).append((words[0].upper(), face))
