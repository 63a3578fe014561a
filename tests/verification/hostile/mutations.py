"""Mutations of files: bytes, lines, numbers and words, and what each format has of its own.

Every mutation is a function of a random generator alone, so that a seed and a number determine it.
"""

import re
import zlib
from base64 import b64encode
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from tests.verification.hostile.words import BOMB, CARDS, KEYS, NUMBERS, ROWS, VALUES, WORDS

Random = np.random.Generator
Mutation = Callable[[Random, bytes], bytes]
Any = TypeVar("Any")


def one(random: Random, choice: Sequence[Any]) -> Any:
    """One of some."""
    return choice[int(random.integers(len(choice)))]


def many(random: Random, most: int) -> int:
    """A power of two below 2**most."""
    return int(2 ** random.integers(most))


def flips(random: Random, data: bytes) -> bytes:
    """Bytes or bits changed, near the beginning as often as anywhere."""
    found = bytearray(data)
    most = len(found) if random.random() < 0.5 else min(len(found), 2048)
    for _ in range(many(random, 6)):
        change = random.integers(256) if random.random() < 0.5 else 1 << random.integers(8)
        found[int(random.integers(most))] ^= int(change)
    return bytes(found)


def cut(random: Random, data: bytes) -> bytes:
    """The end is missing."""
    return data[: int(random.integers(len(data)))]


def doubled(random: Random, data: bytes) -> bytes:
    """A part stands there many times."""
    a, b = sorted(random.integers(len(data), size=2).tolist())
    return data[:b] + data[a:b][:3000] * many(random, 8) + data[b:]


def inserted(random: Random, data: bytes) -> bytes:
    """A word where none belongs."""
    place = int(random.integers(len(data) + 1))
    return data[:place] + one(random, WORDS + NUMBERS) + data[place:]


def replacing(pattern: bytes, choice: list[bytes]) -> Mutation:
    """Some of what a pattern finds becomes something else."""

    def replaced(random: Random, data: bytes) -> bytes:
        found = list(re.finditer(pattern, data, re.M))
        if not found:
            return inserted(random, data)
        some = random.choice(len(found), min(many(random, 4), len(found)), False)
        for i in sorted(some.tolist(), reverse=True):
            data = data[: found[i].start()] + one(random, choice) + data[found[i].end() :]
        return data

    return replaced


def between(choice: list[bytes]) -> Mutation:
    """One more line, near the beginning as often as anywhere."""

    def lengthened(random: Random, data: bytes) -> bytes:
        found = data.split(b"\n")
        most = min(len(found), 8) if random.random() < 0.5 else len(found)
        found.insert(int(random.integers(most)), one(random, choice))
        return b"\n".join(found)

    return lengthened


def lines(random: Random, data: bytes) -> bytes:
    """Lines missing, again, far away, turned round or many."""
    found = data.split(b"\n")
    a, b = sorted(random.integers(len(found) + 1, size=2).tolist())
    few, line = found[a:b], found[a : a + 1]
    found[a:b] = one(random, [[], few[1:], few * 2, few[::-1], line * 16 * many(random, 8)])
    return b"\n".join(found)


def nested(random: Random, data: bytes) -> bytes:
    """Brackets, dots or tags within one another."""
    depth, place = int(10 ** random.uniform(1, 4.5)), int(random.integers(len(data) + 1))
    pairs = [(b"[", b"]"), (b"{a=", b"}"), (b"(", b")"), (b"<a>", b"</a>"), (b"a.", b"")]
    opening, closing = one(random, pairs)
    if random.random() < 0.5:
        place = data.rfind(b"\n", 0, place) + 1
    inside = b"1" if closing else b"=1"
    key = one(random, [b"", b"", b"x = "])
    return data[:place] + key + opening * depth + inside + closing * depth + b"\n" + data[place:]


def sweeps(random: Random, data: bytes) -> bytes:
    """Sweeps of anything."""
    names = re.findall(rb"^([a-z_.]+) *=", data, re.M) or [b"mu"]
    tables = re.findall(rb"^\[([a-z_.]+)\]", data, re.M) or [b"joints.interlock"]
    counts = [b"[0.1, 0.2]", b"[" + b"0.1," * 900 + b"]", b"[]", b"['a', 'b']", b"0.1", b"[nan, 1]"]
    counts.append(b"[" + b",".join(b"%.4f" % (0.1 + 0.001 * i) for i in range(300)) + b"]")
    data += b"\n[sweep]\n"
    for _ in range(int(random.integers(1, 5))):
        data += b'"%s.%s" = %s\n' % tuple(one(random, each) for each in (tables, names, counts))
    return data


def bombs(random: Random, data: bytes) -> bytes:
    """Of a VTU file: entities that multiply, sizes that lie, blocks that unpack to much."""
    kind, size = int(random.integers(4)), 1 << int(random.integers(20, 29))
    if kind == 0:
        head, mark, rest = data.partition(b"?>")
        return head + mark + BOMB + rest.replace(b"</", b"&m;</", 1)
    pattern = rb'[A-Z]\w+="(\d+)"' if kind == 1 else rb"<DataArray[^>]*>([^<]*)<"
    if not (places := list(re.finditer(pattern, data))):
        return inserted(random, data)
    place, new = one(random, places), one(random, NUMBERS)
    if kind > 1:
        packed = zlib.compress(bytes(size), 9)
        head = np.array([1, size, size, len(packed)], "<u4" if kind == 2 else "<u8").tobytes()
        new = b64encode(head) + b64encode(packed)
    return data[: place.start(1)] + new + data[place.end(1) :]


numbers = replacing(rb"(?<![\w.])[+-]?\d+(?:\.\d*)?(?:[eEdD][+-]?\d+)?", NUMBERS)
words = replacing(rb"[A-Za-z_][A-Za-z_0-9.-]*", WORDS)
values = replacing(rb"(?<==).*$", VALUES)
GENERAL = [flips, flips, cut, doubled, numbers, numbers, words, inserted, lines, nested]
TOML = [*GENERAL, values, values, values, values, between(KEYS), between(KEYS), sweeps]
MESH = [*GENERAL, between(CARDS), between(CARDS), between(CARDS), bombs]
MATRIX = [*GENERAL, between(ROWS), between(ROWS)]


def mutated(random: Random, data: bytes, choice: list[Mutation]) -> bytes:
    """One mutation or a few, one after the other."""
    for _ in range(1 if random.random() < 0.7 else int(random.integers(2, 5))):
        data = (one(random, choice)(random, data) or b"\n")[:20_000_000]
    return data
