"""Read the mesh of an Abaqus or CalculiX input deck: nodes, elements, sets and surfaces.

meshio's own reader of this format drops the nodes' numbers, the sets of `*NODE` and `*SURFACE`, and
all but the last block of a set given in several.
"""

import numpy as np

from vanelock.common.errors import InputError
from vanelock.mesh.files.decks.abaqus_keywords import Line, keywords
from vanelock.mesh.files.decks.abaqus_mesh import Deck, nodes_of_type, resolved
from vanelock.mesh.files.decks.numbers import counted, real, span, whole
from vanelock.mesh.files.raw import RawMesh

_REFUSED = ("INCLUDE", "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


def read_abaqus(source: str, text: str) -> RawMesh:
    """Read a deck's text.

    Names of sets are told apart without regard to upper and lower case, as the format has it, and
    come out in upper case.
    """
    deck = Deck(source)
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
    return resolved(deck)


def _nodes(deck: Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
    if options.get("SYSTEM", "R").upper() != "R":
        raise InputError(f"{where}: only Cartesian coordinates are read")
    found = []
    for number, words in lines:
        at = f"{deck.source}: line {number}"
        if len(words) < 4:
            raise InputError(f"{at}: a node needs its number and three coordinates")
        found.append(whole(words[0], at))
        x, y, z = (real(word, at) for word in words[1:4])
        deck.places.append((x, y, z))
    deck.numbers += found
    if "NSET" in options:
        deck.node_sets.setdefault(options["NSET"].upper(), []).append(np.array(found, np.int64))


def _elements(deck: Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
    name = options.get("TYPE", "").upper()
    if not name:
        raise InputError(f"{where}: its TYPE is missing")
    numbers, nodes = deck.elements.setdefault(name, ([], []))
    started = len(numbers)
    count = nodes_of_type(name)
    item: list[int] = []
    for number, words in lines:
        at = f"{deck.source}: line {number}"
        item += [whole(word, at) for word in words if word]
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


def _set(deck: Deck, where: str, keyword: str, options: dict[str, str], lines: list[Line]) -> None:
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
            ends = [whole(word, at) for word in given]
            if len(ends) not in (2, 3):
                raise InputError(f"{at}: expected first, last and step of a range")
            members = span(ends[0], ends[1], ends[2] if len(ends) == 3 else 1, at)
            deck.listed = counted(deck.listed, members, at)
            entries.append(members)
            continue
        for word in given:
            last = word.rpartition(".")[2]  # "instance.12" is node 12
            entries.append(np.array([whole(last, at)]) if last.isdigit() else word.upper())


def _surface(deck: Deck, where: str, options: dict[str, str], lines: list[Line]) -> None:
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
