"""Tables of bounds and stability: the worst point of a case, and what a long table leaves out."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.vanelock.pipeline.test_progress import summary
from tests.vanelock.run_results import case_of as given_case
from vanelock.analyses.bounds import BOUNDS
from vanelock.analyses.stability import STABILITY, _verdict_at
from vanelock.common.tables import MOST_CASES
from vanelock.nonlinear import STABLE, UNDECIDED, UNSTABLE, Stability
from vanelock.stages.response.summary import Peak

NAN = float("nan")


def case_of(found: Any = None, **products: list[Any]) -> Any:
    """A case with some products of analyses."""
    made = {f"{key}.{i}": each for key, of in products.items() for i, each in enumerate(of)}
    return given_case("a", None, made, summary=found or summary())


def stability(verdict: list[int], growth: list[tuple[float, float]]) -> Stability:
    """Points at 100, 101, ... Hz; growth in 1/s by both truncations."""
    count = len(verdict)
    last = np.array([b if np.isfinite(b) else a for a, b in growth])
    return Stability(
        frequency=100.0 + np.arange(count),
        exponent=last[:, None] + 0j,
        diameter=np.ones((count, 1), int),
        growing=np.array([int(each == UNSTABLE) for each in verdict]),
        verdict=np.array(verdict),
        growth=np.array(growth),
        seen=np.full((count, 1, 3), NAN),
        harmonics=np.array([3, 5]),
    )


@pytest.mark.parametrize(
    ("growth", "reason"),
    [
        ((5.0, -5.0), "two numbers of harmonics differ on whether a departure from it grows"),
        ((-5.0, NAN), "the wave was not found again with 5 harmonics"),
        ((-5.0, -6.0), "not all departures from it could be followed"),
        ((-5.0, 0.0), "a departure from it neither grows nor dies out"),
    ],
)
def test_why_a_wave_is_undecided(growth: tuple[float, float], reason: str) -> None:
    found = summary(
        peak=Peak(0, 100.0, 1e-5, False),
        wave=_verdict_at(stability([UNDECIDED], [growth]), 100.0),
    )
    case = case_of(found)
    (line,), (card,) = STABILITY.warnings(case, ()), STABILITY.answers(case)
    assert f"UNDECIDED: {reason}, growth" in line
    assert card.note == reason


def test_where_no_motion_is_given_no_number_is() -> None:
    """All die out to the window's edge or less, or it is not known which do."""
    for verdict in (STABLE, UNDECIDED):
        one = stability([verdict], [(-62.8, -62.8)])
        one.exponent[:] = NAN
        found = summary(peak=Peak(0, 100.0, 1e-5, False), wave=_verdict_at(one, 100.0))
        case = case_of(found)
        (card,) = STABILITY.answers(case)
        assert "nan" not in " ".join([card.note, *STABILITY.warnings(case, ())])
    assert "not all departures" in card.note


def stability_rows(found: Stability) -> Any:
    (table,) = STABILITY.tables({"a": case_of(stability=[found])})
    return table.record()["rows"]


def test_the_point_reported_is_unstable_where_one_is() -> None:
    """Neither one whose second wave was not found nor one of which the truncations differ."""
    verdict = [STABLE, UNDECIDED, UNSTABLE, UNSTABLE, UNDECIDED]
    growth = [(-9.0, -9.0), (-1.0, NAN), (5.0, 6.0), (7.0, 8.0), (50.0, -1.0)]
    (row,) = stability_rows(stability(verdict, growth))
    assert (row["wave"], row["frequency_hz"]) == ("unstable", 103.0)
    (row,) = stability_rows(stability(verdict[:2], growth[:2]))
    assert row["wave"] == "undecided"
    quiet = stability([STABLE, STABLE], [(-9.0, -9.0), (-3.0, -2.0)])
    assert stability_rows(quiet)[0]["frequency_hz"] == 101.0


def bounded() -> Any:
    three = np.ones(3)
    found = SimpleNamespace(
        joints=(),
        rest_load=np.zeros((3, 0)),
        mean_load=np.zeros((3, 0)),
        amplitude=three,
        frequency=three,
        found_by=("load",) * 3,
        stationary=three > 0,
        drawn=np.zeros(0),
    )
    return SimpleNamespace(found=found, residual=three)


@pytest.mark.parametrize("count", [MOST_CASES, MOST_CASES + 6])
def test_a_table_that_leaves_cases_out_says_so(count: int) -> None:
    one = stability([STABLE], [(-9.0, -9.0)])
    each = case_of(bounds=[bounded()], stability=[one])
    cases = {f"mu={i}": each for i in range(count)}
    (waves,), (ends,) = STABILITY.tables(cases), BOUNDS.tables(cases)
    assert (len(waves.rows), len(ends.rows)) == (MOST_CASES, 3 * MOST_CASES)
    for table in (waves, ends):
        lines = [line for line in table.lines if "results.h5" in line]
        assert lines == (
            [f"the first {MOST_CASES} of {count} cases; results.h5 has all"] * (count > MOST_CASES)
        )
