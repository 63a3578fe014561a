"""Arguments of public functions, held against what the functions' annotations say they are.

A slip such as `options=5`, or one contact where a list is meant, would otherwise end far from where
it was made. The packages' doors hold all functions to it that they hand out, see `lazy.attributes`;
what imports a function from its module calls it as it is. Only kinds are looked at here; which
values are allowed, functions say themselves.
"""

import inspect
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cache, wraps
from numbers import Integral, Number, Real
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import as_array, brief
from vanelock.common.errors import InputError, raised

Function = TypeVar("Function", bound=Callable[..., Any])
Test = Callable[[Any], bool]
_NUMBERS: dict[type, Any] = {bool: (bool, np.bool_), int: Integral, float: Real, complex: Number}
_ARRAY = "an array of numbers"
_WORDS: dict[Any, str] = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    complex: "a number",
    str: "text",
    NoneType: "None",
    np.ndarray: "a NumPy array",
    _ARRAY: _ARRAY,
    tuple: "a tuple",
    Callable: "a function",
    os.PathLike: "a path",
    sp.sparray: "a sparse matrix",
    sp.spmatrix: "a sparse matrix",
    sp.csc_array: "a sparse matrix by columns or rows",
}


def of_kind(function: Function) -> Function:
    """The function, whose arguments are checked before it is called."""

    @wraps(function)
    def called(*args: Any, **options: Any) -> Any:
        _check(dict(zip(names, args, strict=False)) | options, function)
        return function(*args, **options)

    parameters = inspect.signature(function).parameters.items()
    names = [name for name, each in parameters if each.kind <= each.POSITIONAL_OR_KEYWORD]
    return cast(Function, called)


class OfKind:
    """A dataclass whose fields are checked as it is made."""

    def __post_init__(self) -> None:
        _check(vars(self), type(self), f"{type(self).__name__}.")


def _check(values: Mapping[str, Any], owner: Callable[..., Any], where: str = "") -> None:
    """Refuse values of another kind than a function's or a dataclass's annotations name."""
    tests = _tests(owner)
    for name, given in values.items():
        if name in tests and not tests[name](given):
            raise InputError(_refusal(where + name, given, get_type_hints(owner)[name]))


@cache
def _tests(owner: Callable[..., Any]) -> dict[str, Test]:
    return {name: _fits(hint) for name, hint in get_type_hints(owner).items()}


def _kinds(hint: Any) -> list[Any]:
    """Those of a union; all that NumPy makes an array of is one of them."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if not set(array := get_args(ArrayLike)) <= set(kinds):
        return list(kinds)
    return [_ARRAY, *(kind for kind in kinds if kind not in array)]


def _fits(hint: Any) -> Test:
    """Whether a value is of one of the kinds of an annotation."""
    tests = [_is(kind) for kind in _kinds(hint)]
    return tests[0] if len(tests) == 1 else lambda value: any(test(value) for test in tests)


def _refusal(name: str, argument: Any, hint: Any) -> str:
    """What is said of a value, or of the first wrong one in a list of them."""
    for kind in _kinds(hint):
        lists = isinstance(origin := get_origin(kind), type) and issubclass(list, origin)
        if lists and isinstance(argument, list | tuple):
            fits = _fits(inner := get_args(kind)[0])
            i = next(i for i, item in enumerate(argument) if not fits(item))
            return _refusal(f"{name}[{i}]", argument[i], inner)
    needed = " or ".join(dict.fromkeys(map(_word, _kinds(hint))))
    return f"{name}: given {brief(argument)}: needs {needed}"


def _word(kind: Any) -> str:
    origin, inner = get_origin(kind) or kind, get_args(kind)
    if origin is Literal:
        return " or ".join(map(repr, inner))
    if origin is tuple and inner and Ellipsis not in inner:
        return f"({', '.join(' or '.join(map(_word, _kinds(each))) for each in inner)})"
    if origin in _WORDS or not inner:
        name = str(getattr(origin, "__name__", origin))
        return _WORDS.get(origin, f"{'an' if name[0] in 'AEIO' else 'a'} {name}")
    return "a dict" if issubclass(origin, Mapping) else f"a list, each {_word(inner[0])}"


def _is(kind: Any) -> Test:
    """Whether a value is of one kind; made once, as it costs more than many calls."""
    origin, inner = get_origin(kind) or kind, get_args(kind)
    if origin is Literal:
        return lambda value: any(isinstance(value, type(x)) and value == x for x in inner)
    if kind == _ARRAY:
        return _is_array
    if origin in _NUMBERS:
        return lambda value: _is_number(value, _NUMBERS[origin])
    if origin is Any or not isinstance(origin, type):
        return lambda value: True
    if origin is tuple and Ellipsis not in inner:
        tests = [_fits(each) for each in inner]
        return lambda value: (
            _is_listed(value, tuple | list)
            and len(value) == len(tests)
            and all(test(item) for test, item in zip(tests, value, strict=True))
        )
    if getattr(origin, "_is_protocol", False) and origin.__module__.startswith("vanelock."):
        names = [name for name in vars(origin) if not name.startswith("_")]
        return lambda value: all(hasattr(value, name) for name in names)
    if origin is sp.csc_array:
        return lambda value: sp.issparse(value) and value.format in ("csc", "csr")
    if not inner or not issubclass(origin, Iterable) or issubclass(origin, Mapping | np.ndarray):
        return lambda value: isinstance(value, origin)
    fits = _fits(inner[0])
    return lambda value: _is_listed(value, origin) and all(map(fits, _items(value)))


def _is_array(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "buifc"
    return not raised(lambda: as_array(value, "", is_complex=True))


def _is_number(value: Any, kind: Any) -> bool:
    """True is no number, though Python counts with it."""
    scalar = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    return isinstance(scalar, kind) and (kind is _NUMBERS[bool] or not isinstance(scalar, bool))


def _is_listed(value: Any, kind: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim > 0
    return isinstance(value, kind) and not isinstance(value, str | bytes | Mapping)


def _items(value: Any) -> Iterable[Any]:
    """Those to look at: one of an array's numbers is enough; none of what can be read but once."""
    if isinstance(value, np.ndarray):
        return value[:1] if value.dtype.kind in "buifc" else value
    return value if isinstance(value, Collection) else ()
