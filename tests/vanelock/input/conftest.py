"""Mistakes written as the line that is said of them."""

import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError


def complaint(text, read=parse_study):
    """What is said of a study, without its name."""
    with pytest.raises(InputError) as caught:
        read(text)
    return str(caught.value).removeprefix("study: ")


def mistakes(table, **short):
    """(study, message) of lines `key; key | key = value: message`; short words stand for keys."""
    found = []
    for message in table.strip().splitlines():
        before, _, line = message.rpartition(" | ")
        for word, keys in short.items():
            before = before.replace(word, keys)
        found.append((f"{before}; {line.partition(': ')[0]}".replace("; ", "\n"), line))
    return found
