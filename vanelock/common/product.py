"""Products of the stages: frozen dataclasses of arrays that save to and load from HDF5.

A field becomes a dataset (arrays and numbers), a group (sparse matrices, dictionaries, products)
or an attribute (text). `None` is written as nothing. A file is written beside its target and
renamed, so that a kill leaves the old file or the new one, never a part of either.
"""

import dataclasses
import os
import types
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self, TypeAlias, Union, get_args, get_origin, get_type_hints

import h5py
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError, cut_short, printable
from vanelock.common.files.digests import verify
from vanelock.common.files.files import placed
from vanelock.common.files.hdf5 import opened, written
from vanelock.common.process import held

PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
SMALL, PIECES = 4096, 8
"""Bytes of an array that is never packed, and of each of so many pieces that are tried."""

Target: TypeAlias = str | os.PathLike[str] | h5py.Group


class Summarised:
    """A dataclass whose `repr` is one line: its fields with their shapes and counts."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        setattr(cls, "__repr__", _one_line)  # noqa: B010 - else `dataclass` writes its own


def _one_line(product: Any) -> str:
    """What a product holds, arrays by their shapes; fields that hold nothing are left out."""
    values = ((each.name, getattr(product, each.name)) for each in dataclasses.fields(product))
    texts = [
        f"{name}={_summary(value)}"
        for name, value in values
        if value is not None and (not isinstance(value, Mapping) or value)
    ]
    return cut_short(f"{type(product).__name__}({', '.join(texts)})")


def _summary(value: Any) -> str:
    """A value in a few characters."""
    if sp.issparse(value):
        return f"<{_times(value.shape)} sparse, {value.nnz} entries>"
    if isinstance(value, np.ndarray):
        return f"<{_times(value.shape)} {value.dtype}>" if value.size else "none"
    if isinstance(value, Mapping):
        keys = ", ".join(str(key) for key in list(value)[:6])
        return f"{{{keys}{', ...' if len(value) > 6 else ''}}}"
    if isinstance(value, Summarised):
        return f"<{type(value).__name__}>"
    if isinstance(value, tuple | list) and len(value) > 3:
        return f"<{len(value)} of them>"
    text = printable(repr(value))
    return text if len(text) <= 80 else f"<{type(value).__name__}>"


def _times(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape)) or "1"


class Product(Summarised):
    """A stage's result; subclasses are frozen dataclasses.

    A field's unit, written as an attribute of its dataset, is `metadata={"unit": "m"}`.

    Attributes
    ----------
    stored : Path or None
        The file that holds it as its group `product`, and never changes; None where none does.
    """

    stored: ClassVar[Path | None] = None

    def stored_in(self, path: Path) -> Self:
        """The same, of which is known what file holds it."""
        object.__setattr__(self, "stored", path)
        return self

    def save(self, target: Target) -> None:
        """Write to a path (replaced as a whole) or into an open h5py group."""
        if isinstance(target, h5py.Group):
            self._write(target)
            return
        with placed(target) as temporary, held(), written(temporary) as file:
            self._write(file)

    @classmethod
    def load(cls, source: Target) -> Self:
        """Read what `save` wrote."""
        if isinstance(source, h5py.Group):
            verify(source)
            return cls._read_checked(source, source.name or "/")
        with opened(source) as file:
            return cls._read_checked(file, str(source))

    @classmethod
    def _read_checked(cls, group: h5py.Group, where: str) -> Self:
        try:
            return cls._read(group)
        except InputError as error:
            if group.file.filename in str(error) or where in str(error):
                raise
            raise InputError(f"{where}: {error}") from None
        except AttributeError:  # h5py's two kinds of object share few methods
            raise InputError(
                f"{where}: not a vanelock {cls.__name__} (numbers where a group is needed, or a "
                "group where numbers are)"
            ) from None
        except (KeyError, IndexError, OSError, RuntimeError, TypeError, ValueError) as error:
            reason = str(error.args[0] if error.args else error).splitlines()[0]
            raise InputError(f"{where}: not a vanelock {cls.__name__} ({reason})") from None

    def _write(self, group: h5py.Group) -> None:
        group.attrs["product"] = type(self).__name__
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            _write_value(group, field.name, getattr(self, field.name), field.metadata)

    @classmethod
    def _read(cls, group: h5py.Group) -> Self:
        found = group.attrs.get("product")
        if found != cls.__name__:
            raise InputError(f"{group.file.filename}: expected a {cls.__name__}, found {found}")
        hints = get_type_hints(cls)
        names = [field.name for field in dataclasses.fields(cls)]  # type: ignore[arg-type]
        return cls(**{name: _read_value(group, name, hints[name]) for name in names})


def _write_value(group: h5py.Group, name: str, value: Any, words: Mapping[str, str]) -> None:
    if value is None:
        return
    if isinstance(value, str):
        group.attrs[name] = value
    elif isinstance(value, Product):
        value._write(group.create_group(name))
    elif isinstance(value, Mapping):
        inner = group.create_group(name)
        for key, item in value.items():
            _write_value(inner, str(key), item, words)
    elif sp.issparse(value):
        matrix = value.tocsc()
        inner = group.create_group(name)
        inner.attrs["shape"] = matrix.shape
        for part in ("data", "indices", "indptr"):
            inner.create_dataset(part, data=getattr(matrix, part))
    elif isinstance(value, tuple) and all(isinstance(item, str) for item in value):
        group.create_dataset(name, data=list(value), dtype=h5py.string_dtype())
    else:
        array = np.asarray(value)
        if array.dtype.kind not in "biufc":
            raise TypeError(f"{group.name}/{name}: cannot store {type(value).__name__}")
        dataset = group.create_dataset(name, data=array, **packed(array))
        dataset.attrs.update(words)


def packed(array: NDArray[Any]) -> dict[str, Any]:
    """How a file keeps an array: packed where some of its bytes say that this saves a fifth."""
    if array.nbytes < SMALL:
        return {}
    flat, piece = array.reshape(-1), SMALL // array.itemsize
    starts = np.linspace(0, flat.size - piece, PIECES).astype(int)
    some = np.concatenate([flat[start : start + piece] for start in starts])
    shuffled = some.view(np.uint8).reshape(-1, array.itemsize).T.tobytes()
    return PACKED if len(zlib.compress(shuffled, 1)) < 0.8 * len(shuffled) else {}


def _read_value(group: h5py.Group, name: str, hint: Any) -> Any:
    if get_origin(hint) in (Union, types.UnionType):  # X | None
        if name not in group and name not in group.attrs:
            return None
        (hint,) = [option for option in get_args(hint) if option is not type(None)]
    if hint is str:
        return str(group.attrs[name])
    if isinstance(hint, type) and issubclass(hint, Product):
        return hint._read(group[name])
    origin = get_origin(hint) or hint
    if isinstance(origin, type) and issubclass(origin, Mapping):
        key_type, item_type = get_args(hint)
        inner = group[name]
        keys = sorted(set(inner) | (set(inner.attrs) - {"product"}))
        return {key_type(key): _read_value(inner, key, item_type) for key in keys}
    if isinstance(group[name], h5py.Group):
        inner = group[name]
        arrays = tuple(inner[part][()] for part in ("data", "indices", "indptr"))
        return sp.csc_array(arrays, shape=tuple(inner.attrs["shape"]))
    if origin is tuple:
        return tuple(group[name].asstr()[()].tolist())
    value = group[name][()]
    return value if isinstance(value, np.ndarray) else hint(value)
