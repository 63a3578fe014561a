"""A child of limited memory and time says what it found, or why it fell."""

import os
from collections.abc import Callable

import pytest

from vanelock.common.files.limited import Fallen, limited


def endless() -> str:
    while True:
        pass


def crashing() -> str:
    os.abort()


def failing() -> str:
    raise KeyError("absent")


def huge() -> str:
    return str(len(bytearray(1 << 40)))


@pytest.mark.parametrize(
    ("work", "told"),
    [
        (endless, "reading it does not end"),
        (crashing, "it makes the library that reads it fail"),
        (failing, "it makes the library that reads it fail"),
        (huge, "it asks for too much memory"),
    ],
)
def test_a_child_that_falls_says_why(
    work: Callable[[], str], told: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(Fallen, match=told):
        limited(work, seconds=1, memory=200_000_000)
    assert capfd.readouterr() == ("", "")


def test_what_it_found_is_handed_over() -> None:
    assert limited(lambda: "four nodes", seconds=5, memory=200_000_000) == "four nodes"
