"""Bounds and stability of a study: of its whole ring, on its page, in its fatigue."""

from collections.abc import Callable

import h5py
import numpy as np
import pytest

from tests.golden.runs import GoldenRun
from tests.vanelock.stages.conftest import planned_of
from vanelock import nonlinear
from vanelock.analyses.bounds import BoundedPeak
from vanelock.pipeline.step import Stages


def test_a_study_has_both_on_its_page(
    golden: Callable[[str], GoldenRun], kept_by: Callable[[str], Stages]
) -> None:
    run = golden("everything")
    (found,) = run.summaries
    with h5py.File(run.folder / "results.h5") as file:
        group = file["response/nominal"]
        response = nonlinear.Response.load(group)
        bounded = BoundedPeak.load(group["bounds"])
        kept = nonlinear.Stability.load(group["stability"])
        answers = dict(group["answers"].attrs)
    assert bounded.found is not None
    assert found.lowest.amplitude == found.highest.amplitude == bounded.found.amplitude[0]
    assert found.highest.amplitude == pytest.approx(found.peak.amplitude, rel=5e-3)
    whole = kept_by("everything").get(planned_of(run.text).structure.whole)
    assert sorted(whole.diameters) == list(range(5))
    top = int(response.amplitude[:, 0].max(axis=1).argmax())
    again = nonlinear.stability(whole, response, [top])
    assert kept.frequency.tolist() == [found.peak.frequency]
    np.testing.assert_allclose(kept.exponent, again.exponent, rtol=1e-5)
    assert found.wave.growth == pytest.approx(abs(kept.multiplier[0, 0]), rel=1e-12)
    assert answers["goodman_reserve_at_largest_peak"] == pytest.approx(
        answers["goodman_reserve"], rel=1e-2
    )
    page = (run.folder / "report.html").read_text("utf-8")
    for text in ("Periodic wave", found.wave.verdict, "Mistuning", "as assembled"):
        assert text in page, text
    assert "upper bound of the peak over static friction" in page
