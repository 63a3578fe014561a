"""What the page of a campaign says to be careful about."""

from types import SimpleNamespace
from typing import Any

from vanelock.published.page import doubts
from vanelock.stages.response.summary import Peak


def case(peak, converged=9):
    return SimpleNamespace(peak=peak, converged=converged, points=9, worst=3e-4)


def test_peaks_that_are_none_are_reported():
    inside, end = Peak(3, 250.0, 1e-5, False), Peak(8, 300.0, 1e-5, True)
    summaries = {
        "reference": case(inside),
        "mu=0.1": case(end),
        "mu=0.5": case(None, 0),
        "harmonics=3": case(inside, 7),
    }
    evidence: Any = SimpleNamespace(summaries=summaries)
    found = doubts(evidence)
    names = [line.partition(":")[0] for line in found]
    assert names == ["mu=0.1", "mu=0.5", "mu=0.5", "harmonics=3"]
    assert "end of the frequency range" in found[0]
    assert "no point converged" in found[1]
    assert "2 of 9 points" in found[3]
