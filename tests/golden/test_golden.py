"""The six golden runs find what they found when their numbers were written down.

`python tools/golden.py --write` writes them anew, for a commit that says why they differ.
"""

import json
from pathlib import Path

import pytest

from tests.golden.numbers import ROUND_OFF, differences, short, shown
from tests.golden.runs import NAMES

TOLERANCE = 1e-6
"""Processors and meshes differ in the last digits."""


@pytest.mark.parametrize("name", NAMES)
def test_a_run_finds_what_it_found(golden, name):
    expected = json.loads((Path(__file__).parent / f"{name}.json").read_text())
    found = short(shown(golden(name)))
    assert sorted(differences(expected, found, TOLERANCE, ROUND_OFF)) == []
