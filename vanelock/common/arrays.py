"""Arrays of numbers from what users give: lists, integers and sparse matrices are as good."""

import operator
from collections.abc import Collection
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError

Array = NDArray[Any]
Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]


def as_array(value: Any, name: str, is_complex: bool = False) -> NDArray[Any]:
    """Real or, where allowed, complex numbers of double precision; not copied if they are that."""
    try:
        array = np.asarray(value.toarray() if sp.issparse(value) else value)
    except ValueError:
        raise InputError(f"{name}: given rows of different lengths: needs an array") from None
    if array.dtype.kind not in "buifc":
        raise InputError(f"{name}: given {brief(value)}: needs an array of numbers")
    if array.dtype.kind != "c":
        return array.astype(np.float64, copy=False)
    if is_complex:
        return array.astype(np.complex128, copy=False)
    if array.imag.any():
        raise InputError(f"{name}: given complex numbers: needs real ones")
    return array.real.astype(np.float64)


def as_whole(value: Any, name: str) -> int:
    """A whole number, of NumPy too, or `InputError`."""
    try:
        return operator.index(value)
    except TypeError:
        raise InputError(f"{name}: given {brief(value)}: needs a whole number") from None


def hold_arrays(
    owner: Any, dimensions: dict[str, int], optional: Collection[str] = (), is_complex: bool = False
) -> None:
    """Make arrays of some fields of a frozen dataclass, of so many dimensions each."""
    for field, wanted in dimensions.items():
        given, name = getattr(owner, field), f"{type(owner).__name__}.{field}"
        if given is None and field in optional:
            continue
        array = as_array(given, name, is_complex)
        if array.ndim != wanted:
            raise InputError(f"{name}: given shape {array.shape}: needs {wanted} dimension(s)")
        object.__setattr__(owner, field, array)


def brief(argument: Any) -> str:
    """A short value as it is written, else its type."""
    text = repr(argument)
    short = len(text) <= 40 and "\n" not in text
    return text if short else f"a {type(argument).__name__}"


def unit_vectors(directions: NDArray[np.float64], where: str) -> NDArray[np.float64]:
    """Directions (..., 3) of vectors, however long or short these are; none may be zero."""
    largest = np.abs(directions).max(axis=-1, keepdims=True)
    if not np.all(largest > 0):
        raise InputError(f"{where}: must not be zero")
    scaled = directions / largest  # whose squares neither overflow nor vanish
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))
