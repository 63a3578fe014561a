"""The memory of a run to an accuracy, beside what it says beforehand."""

import pytest

from benchmarks.runs.memory import taken

pytestmark = pytest.mark.system
MOST = 8.0
"""GB that a run of the default study to 1 % may take."""


def test_a_run_to_one_per_cent_stays_within_eight_gigabytes_and_near_its_forecast(record_property):
    found, said = taken("accuracy = 0.01\n")
    peak = max(found[kind] for kind in ("mesh", "response", "pictures"))
    record_property("result", f"{peak:.2f} GB, {said.memory / 1e9:.2f} forecast")
    assert peak <= MOST
    assert 0.75 <= said.memory / (1e9 * peak) <= 1.34
