"""Plain data and dataclasses of them as JSON, and back; NaN stays so."""

import json
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter

T = TypeVar("T")


def as_json(value: Any) -> str:
    """A value as JSON text."""
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {each.name: getattr(value, each.name) for each in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return dict(value)


def from_json(kind: type[T], value: Any) -> T:
    """A value of a kind from what JSON holds of it."""
    return TypeAdapter(kind).validate_python(value)
