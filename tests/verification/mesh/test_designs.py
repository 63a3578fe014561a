"""Designs drawn at random over the stated range are meshed soundly, or refused by name.

6 to 60 sectors, 1 to 8 aerofoils, every thickness, gap and distance within 30 % of the scene's,
aerofoils scaled to their spacing; see `designs.py`, which runs as a program of its own at full
count, so that a crash or a hang of the mesher is an outcome like others.
"""

import json
import subprocess
import sys
from collections import Counter
from itertools import chain
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import pytest

from tests.conftest import FULL
from tests.verification.mesh import designs
from vanelock.mesh import CasingDimensions, HookDimensions, VaneDimensions

NUMBERS = range(250) if FULL else (15, 22, 117, 169)  # one refused, one or two aerofoils
PATIENCE = 7200  # seconds; all designs take half an hour
Outcome = dict[str, Any]
ROOT = Path(__file__).resolve().parents[3]
NAMES = {*VaneDimensions.model_fields, *CasingDimensions.model_fields, *HookDimensions.model_fields}
NAMES |= {"sectors", "size"}


def run(numbers):
    """Outcomes of the designs up to the first that crashes or hangs, which is the last one."""
    command = [sys.executable, str(Path(__file__).with_name("designs.py")), *map(str, numbers)]
    with TemporaryFile("w+") as said:
        try:
            done = subprocess.run(command, stdout=said, cwd=ROOT, timeout=PATIENCE)
            end = f"ends with {done.returncode}"
        except subprocess.TimeoutExpired:
            end = "hangs"
        said.seek(0)
        # The mesher has its own say on some lines.
        found: list[Outcome] = [json.loads(line) for line in said if line.startswith("{")]
    if len(found) < len(numbers):
        found.append({"number": numbers[len(found)], "failed": end})
    return found


@pytest.fixture(scope="module")
def outcomes():
    if not FULL:
        return [designs.outcome(designs.draw(number)) for number in NUMBERS]
    found: list[Outcome] = []
    while len(found) < len(NUMBERS):
        found += run(NUMBERS[len(found) :])
    return found


@pytest.fixture(scope="module")
def meshed(outcomes):
    return [each for each in outcomes if "sicn" in each]


def reason(line):
    """The first dimension that a line names."""
    words = line.replace(",", " ").replace(":", " ").split()
    names = [word.split(".")[-1] for word in words]
    return next((name for name in names if name in NAMES), "")


def test_each_is_meshed_or_refused_by_name(outcomes, meshed, record):
    refused = [each["refused"] for each in outcomes if each.get("refused")]
    record("drawn", str(len(outcomes)))
    record("meshed", str(len(meshed)))
    record("refused", str(len(refused)))
    said = [message.replace("\n", "; ").split("; ") for message in refused]
    named = [list(filter(None, map(reason, lines))) for lines in said]
    counts = Counter(chain.from_iterable(named)).most_common()
    record("refused for", ", ".join(f"{name} {count}" for name, count in counts))
    record("longest", f"{max(each.get('seconds', 0.0) for each in outcomes):.1f} s")
    record("processor time", f"{sum(each.get('busy', 0.0) for each in outcomes):.0f} s")
    assert [each for each in outcomes if "failed" in each] == []
    assert len(meshed) + len(refused) == len(outcomes)
    assert all(named)
    assert len(meshed) >= 0.75 * len(outcomes)
    assert len(meshed) >= 200 or not FULL


def test_sets_have_the_counts_asked_for_and_share_no_node(meshed):
    assert [each["number"] for each in meshed if each["counts"]] == []
    assert [each["number"] for each in meshed if any(each["overlapping"])] == []


def test_surfaces_are_closed_with_a_handle_between_aerofoils(meshed):
    assert [each["number"] for each in meshed if any(each["handles"])] == []


@pytest.mark.parametrize(
    "what", ["mates", "interlock", "faces", "patches", "interlock patches", "weights"]
)
def test_what_meets_matches(meshed, what, below):
    largest = max(each[what] for each in meshed)
    below("largest difference, of the radius", largest, 1e-12)


@pytest.mark.parametrize("part", ["vane", "casing"])
def test_elements_are_sound(meshed, part, record):
    index = ("vane", "casing").index(part)
    sicn = sorted(each["sicn"][index] for each in meshed)
    jacobian = min(each["jacobian"][index] for each in meshed)
    record("smallest SICN", f"{sicn[0]:.4f}")
    record("below 0.05", f"{sum(value < 0.05 for value in sicn)} of {len(sicn)}")
    record("median", f"{sicn[len(sicn) // 2]:.3f}")
    record("smallest Jacobian of a straight element's", f"{jacobian:.3f}")
    assert jacobian > 0
    assert sicn[0] > 0.03


@pytest.mark.parametrize(("part", "most"), [("vane", 5e-3), ("casing", 5e-4)])
def test_meshes_fill_the_geometry(meshed, part, most, record):
    index = ("vane", "casing").index(part)
    differences = [each["volume"][index] for each in meshed]
    record("volume against the CAD's", f"{min(differences):+.1e} to {max(differences):+.1e}")
    assert max(map(abs, differences)) < most
