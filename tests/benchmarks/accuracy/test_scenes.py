"""Scenes of the accuracy benchmark and the arithmetic of its tables."""

import numpy as np
import pytest

from benchmarks.accuracy import references, runs, scenes, tables


def run(number, amplitude, frequency=100.0, cost=1.0, estimate=float("nan")):
    return runs.Outcome(
        number=number, name="", amplitude=amplitude, frequency=frequency,
        amplitude_estimate=estimate, frequency_estimate=float("nan"), rom=0.75 * cost,
        response=0.25 * cost, size=10, diameters=2, harmonics=3, mean_harmonics=2.5, points=20,
        lost=0, sources={},
    )  # fmt: skip


def test_scenes_are_drawn_again_and_cover_what_is_hard():
    drawn = [scenes.draw(number) for number in range(scenes.COUNT)]
    again = scenes.draw(17)
    assert again.values == drawn[17].values
    assert len(drawn) >= 60
    kinds = " ".join(scene.kind for scene in drawn)
    for kind in ("hooks slip", "no interlock", "isotropic", "opens", "patches", "uncoupled"):
        assert kind in kinds
    assert {scene.values["excitation"]["engine_order"] for scene in drawn} == {1, 2, 3}
    studies = [scene.study() for scene in drawn]
    mu = [study.joints.interlock.mu for study in studies]
    force = [study.excitation.force_per_node for study in studies]
    assert max(mu) / min(mu) > 5
    assert max(force) / min(force) > 15
    assert len({study.ring.sectors for study in studies}) > 4


def test_errors_are_of_amplitude_and_frequency():
    references = {n: {"amplitude": 1e-6, "frequency": 100.0} for n in (0, 1, 2)}
    found = [
        run(0, 0.99e-6),
        run(1, 1e-6, frequency=102.0),
        run(2, float("nan")),
        run(9, 1e-6),  # no reference
    ]
    compared = tables.compared("", found, references)
    np.testing.assert_allclose(compared.worst, [0.01, 0.02, np.inf])
    assert compared.within(0.03) == pytest.approx(2 / 3)
    assert compared.within(0.015) == pytest.approx(1 / 3)
    assert compared.reaches(0.6) == pytest.approx(0.02)
    assert compared.cost == pytest.approx(1.0)


def test_cheapest_safe_setting():
    references = {0: {"amplitude": 1.0, "frequency": 100.0}}
    fixed = {
        runs.Setting(1e-2, harmonics): tables.compared(
            "", [run(0, 1 + error, cost=cost)], references
        )
        for harmonics, error, cost in ((3, 0.1, 1.0), (5, 0.02, 2.0), (9, 0.001, 4.0))
    }
    safe = tables.cheapest(fixed, 0.03, 1.0)
    assert safe is not None
    assert safe[0].harmonics == 5
    assert tables.cheapest(fixed, 1e-4, 1.0) is None
    asked = {0.03: tables.compared("", [run(0, 1.01, estimate=0.02)], references)}
    assert "| 0.50 |" in tables.ratio_table(asked, fixed)[-1]
    assert "| 2.0 |" in tables.estimate_table(asked)[-1]
    assert tables.beyond_table(asked) == ["None."]


def test_more_harmonics_begin_at_zero():
    w = np.arange(18.0).reshape(2, 3, 3)
    more = references.resized(w, 3)
    np.testing.assert_array_equal(more[:, :, :3], w)
    assert not more[:, :, 3:].any()
    np.testing.assert_array_equal(references.resized(more, 1), w)
