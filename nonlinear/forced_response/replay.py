"""Solved points written down as they come, so that a run that was killed takes them up again.

A response is computed by a sequence of questions, each answered from its arguments alone: the next
question follows from the answers so far. So an algorithm that is run again asks the same questions,
and is given the answers that were written down instead of new ones, until they end. Then it goes on
as if it had never stopped.

What is handed on is always what reading the record back gives, whether it was just computed or
written down before: results agree to the last bit, the order of arrays in memory included.
"""

import json
import zlib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import fields
from typing import Any, Protocol, TypeVar

import numpy as np

from vanelock.nonlinear.contact.law import Deviation
from vanelock.nonlinear.newton.linearised import KeptBasis
from vanelock.nonlinear.newton.newton import Solution
from vanelock.nonlinear.newton.preconditioner import Basis

T = TypeVar("T")

SHARED = 16
"""Objects that answers share, of which so many are remembered at a time."""
LARGE = 4096
"""Bytes of an array from which on its empty rows are left out."""


class Journal(Protocol):
    """Records in the order in which they were written."""

    def next(self) -> bytes | None:
        """The next record of an earlier attempt; None behind the last one."""

    def drop(self) -> None:
        """Forget the record that came last, and all that follow: they belong to other questions."""

    def add(self, record: bytes) -> None:
        """Write one more, behind the last one."""


class Replay:
    """Answers questions from a journal as long as it lasts, then by computing."""

    def __init__(
        self,
        journal: Journal | None = None,
        shared: tuple[type, ...] = (),
        known: tuple[type, ...] = (),
    ) -> None:
        self._journal = journal
        self._book = _Book(shared, known)

    @property
    def writes(self) -> bool:
        """Whether answers are written down."""
        return self._journal is not None

    def __call__(self, question: str, arguments: tuple[Any, ...], compute: Callable[[], T]) -> T:
        """The answer to a question."""
        if self._journal is None:
            return compute()
        asked = _label(question, arguments)
        record = self._journal.next()
        if record is not None and not record.startswith(asked):
            self._journal.drop()
            record = None
        if record is None:
            record = asked + self._book.write(compute())
            self._journal.add(record)
        answer: T = self._book.read(memoryview(record)[len(asked) :])
        return answer


def _label(question: str, arguments: tuple[Any, ...]) -> bytes:
    """A line that distinguishes a question from others."""
    digest = 0
    for each in arguments:
        if isinstance(each, float):
            each = float(each).hex()  # NumPy's floats call themselves otherwise
        held = each.tobytes() if isinstance(each, np.ndarray) else str(each).encode()
        digest = zlib.crc32(held, digest)
    return f"{question} {digest:08x}\n".encode()


class _Book:
    """How answers are written: numbers and structure as JSON, arrays behind that as they are."""

    def __init__(self, shared: tuple[type, ...], known: tuple[type, ...]) -> None:
        self._shared = shared
        self._known = {each.__name__: each for each in (*shared, *known)}
        self._held: OrderedDict[int, Any] = OrderedDict()
        self._count = 0

    def write(self, answer: Any) -> bytes:
        """A record of an answer."""
        arrays: list[bytes] = []
        head = json.dumps(self._encoded(answer, arrays, {}), separators=(",", ":")).encode()
        return b"".join([len(head).to_bytes(4, "little"), head, *arrays])

    def read(self, record: memoryview) -> Any:
        """The answer of a record."""
        end = 4 + int.from_bytes(record[:4], "little")
        answer = self._decoded(json.loads(bytes(record[4:end])), _Arrays(record, end))
        while len(self._held) > SHARED:  # not before: the record may name any of them again
            self._held.popitem(last=False)
        return answer

    def _encoded(self, value: Any, arrays: list[bytes], fresh: dict[int, int]) -> Any:
        """What JSON holds of a value; `fresh` numbers the shared objects of this record."""
        if isinstance(value, np.ndarray | np.generic):
            return _laid_down(value, arrays)
        if value is None or isinstance(value, bool | str | int | float):
            return value
        if isinstance(value, tuple | list):
            name = "tuple" if isinstance(value, tuple) else "list"
            return [name, *(self._encoded(each, arrays, fresh) for each in value)]
        if isinstance(value, dict):
            pairs = [each for pair in value.items() for each in pair]
            return ["dict", *(self._encoded(each, arrays, fresh) for each in pairs)]
        kind = type(value)
        if self._known.get(kind.__name__) is not kind:
            raise TypeError(f"cannot write down a {kind.__name__}")
        if isinstance(value, self._shared):
            number = fresh.get(id(value))
            held = (n for n, each in self._held.items() if each is value)
            if (number := next(held, number)) is not None:
                return ["again", number]
            fresh[id(value)] = self._count + len(fresh)
        parts = [self._encoded(getattr(value, each.name), arrays, fresh) for each in fields(kind)]
        return ["object", kind.__name__, *parts]

    def _decoded(self, written: Any, arrays: "_Arrays") -> Any:
        """The value of what JSON held."""
        if not isinstance(written, list):
            return written
        kind, *items = written
        if kind == "array":
            return arrays.next(*items)
        if kind == "again":
            self._held.move_to_end(items[0])
            return self._held[items[0]]
        if kind == "object":
            return self._made(self._known[items[0]], items[1:], arrays)
        values = [self._decoded(each, arrays) for each in items]
        if kind == "dict":
            return dict(zip(values[::2], values[1::2], strict=True))
        return tuple(values) if kind == "tuple" else values

    def _made(self, kind: type, parts: list[Any], arrays: "_Arrays") -> Any:
        """An object from its parts; one that is shared is held for later ones."""
        number = self._count
        self._count += kind in self._shared
        pairs = zip(fields(kind), parts, strict=True)
        made = kind(**{field.name: self._decoded(part, arrays) for field, part in pairs})
        if kind in self._shared:
            self._held[number] = made
        return made


def _laid_down(value: Any, arrays: list[bytes]) -> list[Any]:
    """An array behind the others, and how to find it: type, shape, order and rows."""
    array = np.asarray(value)
    order, rows = "C", None
    if isinstance(value, np.generic):
        order = "number"
    elif array.flags.f_contiguous and not array.flags.c_contiguous:
        order = "F"
    elif array.nbytes > LARGE and array.ndim > 1:
        there = np.flatnonzero(array.reshape(len(array), -1).any(axis=1))
        if 2 * len(there) < len(array):  # contacts that stick have no slope
            rows, array = there.tolist(), array[there]
    arrays.append(array.tobytes("F" if order == "F" else "C"))
    return ["array", array.dtype.str, list(np.shape(value)), order, rows]


class _Arrays:
    """The arrays of a record, one after another."""

    def __init__(self, record: memoryview, begin: int) -> None:
        self._record, self._place = record, begin

    def next(self, dtype: str, shape: list[int], order: str, rows: list[int] | None) -> Any:
        """The next one, a copy."""
        kind = np.dtype(dtype)
        there = shape if rows is None else [len(rows), *shape[1:]]
        count = int(np.prod(there, dtype=np.int64))
        flat = np.frombuffer(self._record, kind, count, self._place)
        self._place += count * kind.itemsize
        if order == "number":
            return flat[0]
        if rows is None:
            layout: Any = order
            return flat.reshape(shape, order=layout).copy(order=layout)
        full = np.zeros(shape, kind)
        full[rows] = flat.reshape(there)
        return full


def replaying(journal: Journal | None, *more: type) -> Replay:
    """What asks for solutions, or dataclasses that consist of them, `more`, with a journal."""
    return Replay(journal, shared=(KeptBasis, Basis), known=(Solution, Deviation, *more))
