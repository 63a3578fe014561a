"""Bounds and stability of a study: its whole ring, its page, its fatigue at the largest peak."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from vanelock import nonlinear, parse_study, run_study
from vanelock.commands.compare.comparison import compared
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.results.reading.contents import load_run
from vanelock.stages.parts.components import rom_step, shared_step
from vanelock.stages.parts.systems import system_step

STUDY = """
[mesh]
size = "coarse"
[ring]
sectors = 8
[response]
harmonics = 1
[outputs]
shapes = false
loops = false
"""


def test_a_study_has_both_on_its_page(tmp_path: Path) -> None:
    plain, folder = tmp_path / "plain", tmp_path / "run"
    (before,) = run_study(parse_study(STUDY), plain)
    study = parse_study(f"{STUDY}[bounds]\nshare = 0\n[stability]\n")
    (found,) = run_study(study, folder)
    assert found.peak == before.peak  # the response is the same, to the bit
    assert found.lowest is not None
    assert found.highest is not None
    assert found.lowest.amplitude == found.highest.amplitude
    assert found.highest.amplitude == pytest.approx(found.peak.amplitude, rel=5e-3)
    stages = Stages(Cache(folder / "cache", print), lambda event: None)
    vane, casing = (
        rom_step(study, "vane", ()),
        rom_step(study, "casing", range(5), shared_step(study)),
    )
    system = stages.get(system_step(study, vane, casing, (casing,)))
    with h5py.File(folder / "results.h5") as file:
        group = file["response/nominal"]
        response = nonlinear.Response.load(group)
        kept = nonlinear.Stability.load(group["stability"])
        answers = dict(group["answers"].attrs)
    top = int(response.amplitude[:, 0].max(axis=1).argmax())
    again = nonlinear.stability(system, response, [top])
    assert kept.frequency.tolist() == [found.peak.frequency]
    np.testing.assert_allclose(kept.exponent, again.exponent, rtol=1e-5)
    assert found.wave is not None
    assert found.wave.growth == pytest.approx(abs(kept.multiplier[0, 0]), rel=1e-12)
    assert answers["goodman_reserve_at_largest_peak"] == pytest.approx(
        answers["goodman_reserve"], rel=1e-2
    )
    page = (folder / "report.html").read_text("utf-8")
    for text in ("Periodic wave", found.wave.verdict, "Bounds and stability", "as assembled"):
        assert text in page, text
    assert "upper bound of the peak over static friction" in page
    lines = {
        each.what: each for each in compared(load_run(plain, "a"), load_run(folder, "b")).results
    }
    assert lines["upper bound of the peak"].one is None
    assert lines["upper bound of the peak"].other == pytest.approx(1e6 * found.highest.amplitude)
    assert lines["growth per cycle"].other == found.wave.growth
