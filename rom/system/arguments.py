"""Arguments of public functions, held against what the functions' annotations say they are.

A slip such as `options=5`, or one contact where a list is meant, would otherwise end far from where
it was made. Only kinds are looked at here; which values are allowed, functions say themselves.
"""

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache, wraps
from numbers import Integral, Number, Real
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from vanelock.common.arrays import as_array, brief
from vanelock.common.errors import InputError, raised

Function = TypeVar("Function", bound=Callable[..., Any])
_NUMBERS: dict[type, Any] = {bool: (bool, np.bool_), int: Integral, float: Real, complex: Number}
_WORDS: dict[Any, str] = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    complex: "a number",
    str: "text",
    NoneType: "None",
    np.ndarray: "an array of numbers",
    tuple: "a tuple",
    Callable: "a function",
}


def of_kind(function: Function) -> Function:
    """The function, whose arguments are checked before it is called, see `check_kinds`."""

    @wraps(function)
    def called(*args: Any, **options: Any) -> Any:
        check_kinds(signature.bind(*args, **options).arguments, function)
        return function(*args, **options)

    signature = inspect.signature(function)
    return cast(Function, called)


def check_kinds(values: Mapping[str, Any], owner: Callable[..., Any]) -> None:
    """Refuse values of another kind than a function's or a dataclass's annotations name.

    Raises
    ------
    InputError
        Naming the value.
    """
    hints = _hints(owner)
    for name, given in values.items():
        if not _fits(given, hints[name]):
            raise InputError(_refusal(name, given, hints[name]))


_hints = lru_cache(maxsize=None)(get_type_hints)


def _kinds(hint: Any) -> list[Any]:
    """Those of a union; all that NumPy makes an array of is one of them."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if not any("numpy._typing" in str(kind) for kind in kinds):
        return list(kinds)
    others = [kind for kind in kinds if "numpy._typing" not in str(kind)]
    return [np.ndarray, *(kind for kind in others if kind not in (complex, bytes, str))]


def _fits(given: Any, hint: Any) -> bool:
    return any(_is(given, kind) for kind in _kinds(hint))


def _refusal(name: str, given: Any, hint: Any) -> str:
    """What is said of a value, or of the first wrong one in a list of them."""
    for kind in _kinds(hint):
        if isinstance(given, list | tuple) and issubclass(list, get_origin(kind) or NoneType):
            inner = get_args(kind)[0]
            i = next(i for i, item in enumerate(given) if not _fits(item, inner))
            return _refusal(f"{name}[{i}]", given[i], inner)
    needed = " or ".join(dict.fromkeys(map(_word, _kinds(hint))))
    return f"{name}: given {brief(given)}: needs {needed}"


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


def _is(given: Any, kind: Any) -> bool:
    """Whether a value is of one kind."""
    origin, inner = get_origin(kind) or kind, get_args(kind)
    if origin is Any:
        return True
    if origin is Literal:
        return given in inner
    if origin is np.ndarray:
        return not raised(lambda: as_array(given, "", is_complex=True))
    if origin in _NUMBERS:
        scalar = given[()] if isinstance(given, np.ndarray) and given.ndim == 0 else given
        return isinstance(scalar, _NUMBERS[origin])
    if origin is tuple and Ellipsis not in inner:
        listed = isinstance(given, tuple | list | np.ndarray) and len(given) == len(inner)
        return listed and all(map(_fits, given, inner))
    if not isinstance(origin, type):
        return True
    if getattr(origin, "_is_protocol", False) and origin.__module__.startswith("vanelock."):
        return all(hasattr(given, name) for name in vars(origin) if not name.startswith("_"))
    if not issubclass(origin, Iterable) or issubclass(origin, Mapping | str) or not inner:
        return isinstance(given, origin)
    if isinstance(given, str | Mapping) or not isinstance(given, origin | np.ndarray):
        return False
    return all(_fits(item, inner[0]) for item in given)
