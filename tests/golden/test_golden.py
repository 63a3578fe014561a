"""The six golden runs find what they found when their numbers were written down.

`python tools/golden.py --write` writes them anew, for a commit that says why they differ.
"""

import json
from pathlib import Path

import pytest

from tests.golden.numbers import PAGE, ROUND_OFF, differences, short, shown
from tests.golden.runs import NAMES

TOLERANCE = 1e-6
"""Processors and meshes differ in the last digits."""
ROUNDED = 2e-3
"""The last of the digits that a page shows."""


@pytest.mark.parametrize("name", NAMES)
def test_a_run_finds_what_it_found(golden, name):
    expected = json.loads((Path(__file__).parent / f"{name}.json").read_text())
    found = short(shown(golden(name)))
    both = expected, found
    if name == "lap_joint":  # blocks alike: which of their two equal modes is taken is round-off
        for each in both:
            assert each.pop("table limits 1: mode")[0] in (1, 2)
    for of_page, tolerance in ((False, TOLERANCE), (True, ROUNDED)):
        one, other = ({k: each[k] for k in each if k.startswith(PAGE) == of_page} for each in both)
        assert sorted(differences(one, other, tolerance, ROUND_OFF)) == []
