"""A child of limited memory and time says what it found, or why it fell."""

import os
import sys

import pytest

from vanelock.common.errors import InputError
from vanelock.common.files.files import by_library, limited


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
    ("work", "expected"),
    [
        (endless, "reading it does not end"),
        (crashing, "it makes the library that reads it fail"),
        (failing, "it makes the library that reads it fail"),
        (huge, "it asks for too much memory"),
    ],
)
def test_a_child_that_falls_says_why(work, expected, capfd):
    assert limited(work, 1, 200_000_000, "a.bin: ") == f"a.bin: {expected}"
    assert capfd.readouterr() == ("", "")


def test_what_it_found_is_handed_over() -> None:
    assert limited(lambda: "four nodes", seconds=5, memory=200_000_000) == "four nodes"


def printing() -> str:
    print("no such section", file=sys.stderr)
    sys.exit(1)


def saying() -> str:
    raise ValueError("line 3: not a number\nand more")


def refusing() -> str:
    raise InputError("a.bin: element 4 has no nodes")


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        (saying, "a.bin: not a mesh that can be read: line 3: not a number"),
        (printing, "a.bin: not a mesh that can be read: no such section"),
        (crashing, "a.bin: not a mesh that can be read: it makes the library that reads it fail"),
        (huge, "a.bin: not a mesh that can be read: it asks for too much memory"),
        (refusing, "a.bin: element 4 has no nodes"),
    ],
)
def test_a_library_that_fails_is_reported_in_one_line(read, expected, capfd):
    with pytest.raises(InputError) as caught:
        by_library(read, "a.bin", 1000, "a mesh")
    assert str(caught.value) == expected
    assert capfd.readouterr() == ("", "")


def test_what_a_library_reads_is_handed_over_and_its_talk_is_not(capfd):
    def read() -> dict[str, int]:
        print("reading ...")
        return {"nodes": 4}

    assert by_library(read, "a.bin", 1000, "a mesh") == {"nodes": 4}
    assert capfd.readouterr() == ("", "")
