"""Mutations of files: bytes, lines, numbers and words, and what each format has of its own.

Every mutation is a function of a random generator alone, so that a seed and a number determine it.
"""

import re
import zlib
from base64 import b64encode
from collections.abc import Callable

import numpy as np

from tests.verification.hostile.words import BOMB, CARDS, NUMBERS, ROWS, VALUES, WORDS

Random = np.random.Generator
Mutation = Callable[[Random, bytes], bytes]

_NUMBER = re.compile(rb"(?<![\w.])[+-]?\d+(?:\.\d*)?(?:[eEdD][+-]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9.-]*")


def flips(random: Random, data: bytes) -> bytes:
    """Some bytes changed."""
    found = bytearray(data)
    for _ in range(int(2 ** random.integers(0, 6))):
        found[int(random.integers(len(found)))] = int(random.integers(256))
    return bytes(found)


def bits(random: Random, data: bytes) -> bytes:
    """One bit of a byte changed, near the beginning as often as anywhere."""
    found = bytearray(data)
    most = len(found) if random.random() < 0.5 else min(len(found), 2048)
    found[int(random.integers(most))] ^= 1 << int(random.integers(8))
    return bytes(found)


def cut(random: Random, data: bytes) -> bytes:
    """The end is missing."""
    return data[: int(random.integers(len(data)))]


def doubled(random: Random, data: bytes) -> bytes:
    """A part stands there many times."""
    a, b = sorted(random.integers(len(data), size=2).tolist())
    return data[:b] + data[a:b][:3000] * int(2 ** random.integers(0, 8)) + data[b:]


def numbers(random: Random, data: bytes) -> bytes:
    """Numbers become others, or no numbers."""
    return _replaced(random, data, _NUMBER, NUMBERS)


def words(random: Random, data: bytes) -> bytes:
    """Words become others."""
    return _replaced(random, data, _WORD, WORDS)


def inserted(random: Random, data: bytes) -> bytes:
    """A word where none belongs."""
    at = int(random.integers(len(data) + 1))
    return data[:at] + _one(random, WORDS + NUMBERS) + data[at:]


def lines(random: Random, data: bytes) -> bytes:
    """Lines missing, again, far away, or many."""
    found = data.split(b"\n")
    a, b = random.integers(len(found), size=2).tolist()
    kind = int(random.integers(5))
    if kind == 0:
        del found[a]
    elif kind == 1:
        found.insert(b, found[a])
    elif kind == 2:
        found[a], found[b] = found[b], found[a]
    elif kind == 3:
        found[a:a] = [found[b]] * int(2 ** random.integers(4, 12))
    else:
        del found[min(a, b) : max(a, b)]
    return b"\n".join(found)


def nested(random: Random, data: bytes) -> bytes:
    """Brackets, dots or tags within one another."""
    depth = int(10 ** random.uniform(1, 4.5))
    one = [(b"[", b"]"), (b"{a=", b"}"), (b"a.", b"=1\n"), (b"(", b")"), (b"<a>", b"</a>")]
    opening, closing = one[int(random.integers(len(one)))]
    at = int(random.integers(len(data) + 1))
    if random.random() < 0.5:
        at = data.rfind(b"\n", 0, at) + 1
    key = b"x = " if random.random() < 0.3 else b""
    closing = closing * (1 if closing.startswith(b"=") else depth)
    return data[:at] + key + opening * depth + b"1" + closing + b"\n" + data[at:]


def _one(random: Random, choice: list[bytes]) -> bytes:
    return choice[int(random.integers(len(choice)))]


def _replaced(
    random: Random, data: bytes, pattern: re.Pattern[bytes], choice: list[bytes]
) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return inserted(random, data)
    some = random.choice(len(found), min(int(2 ** random.integers(0, 4)), len(found)), False)
    for i in sorted(some.tolist(), reverse=True):
        data = data[: found[i].start()] + _one(random, choice) + data[found[i].end() :]
    return data


GENERAL: list[Mutation] = [
    flips, bits, cut, doubled, numbers, numbers, words, inserted, lines, nested,
]  # fmt: skip


def values(random: Random, data: bytes) -> bytes:
    """Values of keys become others, of other types or outside of what is allowed."""
    found = data.split(b"\n")
    keyed = [i for i, line in enumerate(found) if b"=" in line and not line.startswith(b"#")]
    for i in random.choice(keyed, min(int(random.integers(1, 4)), len(keyed)), False).tolist():
        found[i] = found[i].partition(b"=")[0] + b"= " + _one(random, VALUES)
    return b"\n".join(found)


def keys(random: Random, data: bytes) -> bytes:
    """Keys and tables that do not belong there, are there already, or are called otherwise."""
    found = data.split(b"\n")
    own = [line for line in found if b"=" in line] + [line for line in found if line[:1] == b"["]
    strange = [b"[a.b.c]", b"[[vane]]", b"[sweep]", b'"" = 1', b'"\\n" = 1', b"[measured]", b"[]"]
    strange += [b'"../x" = 1', b"__proto__ = 1", b"x = 1\n" * 2000, b'"a\\u001b" = 2', b"[ring.x]"]
    at = int(random.integers(len(found) + 1))
    chosen = own[int(random.integers(len(own)))] if random.random() < 0.5 else _one(random, strange)
    return b"\n".join([*found[:at], chosen, *found[at:]])


def sweeps(random: Random, data: bytes) -> bytes:
    """Sweeps of anything."""
    names = re.findall(rb"^([a-z_.]+) *=", data, re.M) or [b"mu"]
    tables = re.findall(rb"^\[([a-z_.]+)\]", data, re.M) or [b"joints.interlock"]
    counts = [b"[0.1, 0.2]", b"[" + b"0.1," * 900 + b"]", b"[]", b"['a', 'b']", b"0.1", b"[nan, 1]"]
    counts.append(b"[" + b",".join(b"%.4f" % (0.1 + 0.001 * i) for i in range(300)) + b"]")
    rows = []
    for _ in range(int(random.integers(1, 5))):
        rows.append(
            b'"%s.%s" = %s' % (_one(random, tables), _one(random, names), _one(random, counts))
        )
    return data + b"\n[sweep]\n" + b"\n".join(rows) + b"\n"


TOML: list[Mutation] = [*GENERAL, values, values, values, values, keys, keys, sweeps]


def cards(random: Random, data: bytes) -> bytes:
    """A card or keyword of some mesh format between two lines."""
    found = data.split(b"\n")
    at = int(random.integers(len(found) + 1))
    return b"\n".join([*found[:at], _one(random, CARDS), *found[at:]])


def bombs(random: Random, data: bytes) -> bytes:
    """Of a VTU file: entities that multiply, blocks that unpack to much, or sizes that lie."""
    kind = int(random.integers(4))
    if kind == 0:
        head, mark, rest = data.partition(b"?>")
        return (
            head + mark + BOMB + rest.replace(b"</", b"&m;</", 1) if mark else cards(random, data)
        )
    if kind == 1:
        some = list(re.finditer(rb'[A-Z]\w+="(\d+)"', data))
        if not some:
            return cards(random, data)
        one = some[int(random.integers(len(some)))]
        return data[: one.start(1)] + _one(random, NUMBERS) + data[one.end(1) :]
    places = list(re.finditer(rb"<DataArray[^>]*>([^<]*)<", data))
    if not places:
        return cards(random, data)
    one = places[int(random.integers(len(places)))]
    size = 1 << int(random.integers(20, 29))
    packed = zlib.compress(bytes(size), 9)
    head = np.array([1, size, size, len(packed)], "<u4" if kind == 2 else "<u8").tobytes()
    return data[: one.start(1)] + b64encode(head) + b64encode(packed) + data[one.end(1) :]


MESH: list[Mutation] = [*GENERAL, cards, cards, cards, bombs]


def rows(random: Random, data: bytes) -> bytes:
    """A line of some matrix format between two others."""
    found = data.split(b"\n")
    at = int(random.integers(min(len(found), 8) if random.random() < 0.5 else len(found)))
    return b"\n".join([*found[:at], _one(random, ROWS), *found[at:]])


MATRIX: list[Mutation] = [*GENERAL, rows, rows]


def mutated(random: Random, data: bytes, choice: list[Mutation]) -> bytes:
    """One mutation or a few, one after the other."""
    for _ in range(1 if random.random() < 0.7 else int(random.integers(2, 5))):
        data = choice[int(random.integers(len(choice)))](random, data) or b"\n"
        data = data[:20_000_000]
    return data
