"""What cannot be used is refused in one line."""

from collections.abc import Callable
from typing import Any

import pytest

from vanelock.common.errors import InputError


def refused(words: str, call: Callable[..., object], *values: Any, **named: Any) -> str:
    """The line with which a call is refused; it matches these words."""
    with pytest.raises(InputError, match=words) as caught:
        call(*values, **named)
    line = str(caught.value)
    assert "\n" not in line
    return line
