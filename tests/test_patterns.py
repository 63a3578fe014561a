r"""Patterns that read what users write take time in proportion to its length.

A pattern that can read the same text in more and more ways the longer it is tries them all before
it gives up: `\d+\.?\d*` and "1111x". It does so if, and only if, two of its places p and q each
return to themselves and p leads to q by one and the same text (Weber and Seidl, On the degree of
ambiguity of finite automata, Theor. Comput. Sci. 88, 1991). Places are those of Glushkov's
automaton: each character of the pattern is one.
"""

import ast
import re
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

code, parser = import_module("re._constants"), import_module("re._parser")  # not in stubs
ROOT = Path(__file__).parents[1]
FOLDERS = ("vanelock", "mesh", "fem")
ALL = frozenset(map(chr, range(128))) | {"µ", "é", "\u2003"}
SHORT = {"common.quantities._QUANTITY"}
"""Patterns for texts of bounded length (of 40 characters)."""
ONCE = 3
"""Repetitions at which a bounded one is cut: a few have all of its places' neighbours."""


class Part(NamedTuple):
    """Places at which a part of a pattern can begin and end, and whether it may be empty."""

    first: list[int]
    last: list[int]
    empty: bool


class Places:
    """Characters of a pattern and which follow which."""

    def __init__(self, pattern):
        self.sets, self.follow = [], []
        self.sequence(parser.parse(pattern.pattern, pattern.flags))

    def joined(self, one, other):
        """One part and then the other."""
        self.follow += [(p, q) for p in one.last for q in other.first]
        return Part(
            one.first + (other.first if one.empty else []),
            other.last + (one.last if other.empty else []),
            one.empty and other.empty,
        )

    def sequence(self, items):
        """Parts one after the other."""
        found = Part([], [], True)
        for operator, value in items:
            found = self.joined(found, self.part(operator, value))
        return found

    def part(self, operator, value):
        """Any part of a parsed pattern."""
        if operator in (code.MAX_REPEAT, code.MIN_REPEAT, code.POSSESSIVE_REPEAT):
            low, high, inner = value
            found = Part([], [], True)
            for i in range(max(1, min(low, ONCE)) if high == code.MAXREPEAT else min(high, ONCE)):
                again = self.sequence(inner)
                found = self.joined(found, Part(again.first, again.last, again.empty or i >= low))
            if high == code.MAXREPEAT:
                self.follow += [(p, q) for p in again.last for q in again.first]
            return found
        if operator is code.SUBPATTERN:
            return self.sequence(value[-1])
        if operator is code.ATOMIC_GROUP:
            return self.sequence(value)
        if operator is code.BRANCH:
            parts = [self.sequence(each) for each in value[1]]
            return Part(
                [p for each in parts for p in each.first],
                [p for each in parts for p in each.last],
                any(each.empty for each in parts),
            )
        if operator in (code.AT, code.ASSERT, code.ASSERT_NOT):
            return Part([], [], True)
        self.sets.append(characters(operator, value))
        place = [len(self.sets) - 1]
        return Part(place, place, False)


def characters(operator, value):
    """Those that a place accepts."""
    if operator is code.ANY:
        return ALL - {"\n"}
    if operator is code.LITERAL:
        return frozenset(chr(value))
    if operator is code.NOT_LITERAL:
        return ALL - {chr(value)}
    if operator is code.RANGE:
        return frozenset(c for c in ALL if value[0] <= ord(c) <= value[1])
    if operator is code.CATEGORY:
        name = {"DIGIT": r"\d", "SPACE": r"\s", "WORD": r"\w"}[str(value).rpartition("_")[2]]
        found = frozenset(c for c in ALL if re.match(name, c))
        return ALL - found if "_NOT_" in str(value) else found
    assert operator is code.IN
    found = frozenset().union(*(characters(*e) for e in value if e[0] is not code.NEGATE))
    return ALL - found if value[0][0] is code.NEGATE else found


def repeated_readings(pattern):
    """The two places of a text that can be read in ever more ways, as characters; None if none."""
    places = Places(pattern)
    n, follow = len(places.sets), places.follow
    after = [sorted({q for p, q in follow if p == i}) for i in range(n)]
    graph = csr_array((np.ones(len(follow)), tuple(np.array(follow).reshape(-1, 2).T)), (n, n))
    _, loop = connected_components(graph, connection="strong")
    twice = [(p, q) for p, q in set(follow) if loop[p] == loop[q] and follow.count((p, q)) > 1]
    if twice:
        return tuple("".join(sorted(places.sets[i])) for i in twice[0])

    @cache
    def beside(p, q, r):
        return not places.sets[p].isdisjoint(places.sets[q] & places.sets[r])

    cyclic = [i for i in range(n) if any(loop[q] == loop[i] for q in after[i])]
    for p in cyclic:
        for q in cyclic:
            seen, left = set[tuple[int, int, int]](), [(p, p, q)]
            while left and p != q:
                at = left.pop()
                steps = {
                    (a, b, c)
                    for a in after[at[0]]
                    for b in after[at[1]]
                    for c in after[at[2]]
                    if loop[a] == loop[p] and loop[c] == loop[q] and beside(a, b, c)
                }
                if (p, q, q) in steps:
                    return tuple("".join(sorted(places.sets[i])) for i in (p, q))
                left += steps - seen
                seen |= steps
    return None


def patterns():
    """Every pattern that the readers compile, or match from a text's beginning."""
    found = {}
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
            module = name.removeprefix("vanelock.")
            tree = ast.parse(file.read_text("utf-8"))
            if "re" not in {
                a.name for e in ast.walk(tree) if isinstance(e, ast.Import) for a in e.names
            }:
                continue
            for node in ast.walk(tree):
                match node:
                    case ast.Call(
                        func=ast.Attribute(value=ast.Name(id="re"), attr="match" | "fullmatch"),
                        args=[ast.Constant(value=str(text)), *_],
                    ):
                        found[f"{module}:{node.lineno}"] = re.compile(text)
            for name, value in vars(import_module(f"vanelock.{module}")).items():
                if isinstance(value, re.Pattern) and f"{module}.{name}" not in SHORT:
                    found[f"{module}.{name}"] = value
    return found


@pytest.mark.parametrize(
    ("text", "ways"),
    [
        (r"\d+\.?\d*", True),
        (r"(a+)+b", True),
        (r"(.*?)\s*[\(\[]\s*(.*?)\s*[\)\]]", True),
        (r"\[\s*([a-z ]+?)\s*\]", True),
        (r"(ab|[ac]b)*d", True),
        (r"\d+(?:\.\d*)?", False),
        (r"\s*\d+\s+\d+\s*", False),
        (r"(ab|ac)*a?", False),
    ],
)
def test_known_patterns(text, ways):
    assert (repeated_readings(re.compile(text)) is not None) == ways


def test_no_text_is_read_in_ever_more_ways():
    found = patterns()
    assert len(found) > 20
    readings = {name: repeated_readings(pattern) for name, pattern in found.items()}
    assert {name: found[name].pattern for name, ways in readings.items() if ways} == {}
