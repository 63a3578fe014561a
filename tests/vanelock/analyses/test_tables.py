"""Tables of analyses: what they may hold and need, what they show of a case and leave out."""

from typing import Any

import numpy as np
import pytest

from tests.vanelock.pipeline.test_display import summary
from tests.vanelock.run_results import case_of as given_case
from vanelock import parse_study
from vanelock.analyses import ANALYSES
from vanelock.analyses.analysis import asked_for
from vanelock.analyses.bounds import BOUNDS, BoundsKeys
from vanelock.analyses.stability import STABILITY, StabilityKeys, _verdict_at
from vanelock.common.errors import InputError
from vanelock.common.tables import MOST_CASES
from vanelock.nonlinear import STABLE, UNDECIDED, UNSTABLE, Stability
from vanelock.stages.response.summary import Peak

NAN = float("nan")


def case_of(found: Any = None, **products: list[Any]) -> Any:
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
def test_why_a_wave_is_undecided(growth, reason):
    found = summary(
        peak=Peak(0, 100.0, 1e-5, False), wave=_verdict_at(stability([UNDECIDED], [growth]), 100.0)
    )
    case = case_of(found)
    (line,), (card,) = STABILITY.warnings(case, ()), STABILITY.answers(case)
    assert f"UNDECIDED: {reason}, growth" in line
    assert card.note == reason


def test_where_no_motion_is_given_no_number_is():
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


def test_the_point_reported_is_unstable_where_one_is():
    """Neither one whose second wave was not found nor one of which the truncations differ."""
    verdict = [STABLE, UNDECIDED, UNSTABLE, UNSTABLE, UNDECIDED]
    growth = [(-9.0, -9.0), (-1.0, NAN), (5.0, 6.0), (7.0, 8.0), (50.0, -1.0)]
    (row,) = stability_rows(stability(verdict, growth))
    assert (row["wave"], row["frequency_hz"]) == ("unstable", 103.0)
    (row,) = stability_rows(stability(verdict[:2], growth[:2]))
    assert row["wave"] == "undecided"
    quiet = stability([STABLE, STABLE], [(-9.0, -9.0), (-3.0, -2.0)])
    assert stability_rows(quiet)[0]["frequency_hz"] == 101.0


@pytest.mark.parametrize("count", [MOST_CASES, MOST_CASES + 6])
def test_a_table_that_leaves_cases_out_says_so(count):
    one = stability([STABLE], [(-9.0, -9.0)])
    (table,) = STABILITY.tables(dict.fromkeys(map(str, range(count)), case_of(stability=[one])))
    assert len(table.rows) == MOST_CASES
    said = f"the first {MOST_CASES} of {count} cases; results.h5 has all"
    assert [line for line in table.lines if "results.h5" in line] == [said] * (count > MOST_CASES)


def test_the_name_of_a_table_alone_is_enough():
    study = parse_study("[bounds]\n[stability]\n")
    assert BOUNDS.keys_of(study) == BoundsKeys(share=1.0, starts=4)
    assert STABILITY.keys_of(study) == StabilityKeys(points="peaks")
    assert not list(asked_for(ANALYSES, parse_study("")))


def test_isotropic_friction_has_both():
    study = parse_study('[response]\nfriction = "isotropic"\n[bounds]\n[stability]\n')
    assert [each.key for each, _ in asked_for(ANALYSES, study)] == ["bounds", "stability"]


HOOK = "[mistuning.keys.joints.hook]\n"
COUPLED = '[response]\ncoupling = "uncoupled"\n'
MISTAKES = [
    (f"{COUPLED}[bounds]", 'response.coupling = "uncoupled": must be "coupled" for [bounds]'),
    (f"{COUPLED}[stability]", 'must be "coupled" for [stability]'),
    (f"{COUPLED}[damped_modes]", 'must be "coupled" for [damped_modes]'),
    (f"{COUPLED}{HOOK}mu = 0.1", 'must be "coupled" for [mistuning]'),
    ("response.samples = 256\n[bounds]", "response.samples = 256: leave it out for [bounds]"),
    ("response.samples = 256\n[stability]", "leave it out for [stability]"),
    ("bounds.share = 1.5", "bounds.share = 1.5"),
    ("bounds.starts = -1", "bounds.starts = -1"),
    ('stability.points = "some"', "stability.points"),
    ("response.frequencies = [250]\n[bounds]", "a peak, which takes a range"),
    ("[settled]", "settled: needs [stability]"),
    ('accuracy = 0.05\nstability.points = "all"', 'stability.points = "all"'),
    ("wear.dwells = [{ cycles = 1 }]", "wear: no joint wears"),
    ("[wear]", "wear.dwells"),
    (
        "joints.hook.wear_coefficient = 1e-14\nwear.dwells = [{ cycles = 1, frequency = [2, 1] }]",
        "dwells[0].frequency = [2, 1]: must be [low, high] with low < high",
    ),
    ("ring.sectors = 8\ndamped_modes.nodal_diameters = [5]", "allowed are -4 to 4"),
    ("damped_modes.modes = [1, 1]", "must differ"),
    ("damped_modes.influence = [[1, 0, 0], [-15, 0, 0]]", "one is given twice"),
    ("[mistuning]", "mistuning.keys: must be given"),
    (
        "mistuning.keys.joints.lap.mu = 0.1",
        'mistuning.keys."joints.lap.mu": allowed are interference, mu, kn, kt, slider of '
        "joints.hook, joints.interlock, and vane.frequency",
    ),
    (
        "mistuning.keys.vane.frequency = [0.1, 0.2]",
        'mistuning.keys."vane.frequency": given 2 numbers: needs 1, or one a segment: 16',
    ),
    (f"{HOOK}slider = {[0.1] * 16}", '.slider": given 16 numbers: needs 1'),
    (
        f"[mistuning]\nrings = 3\n{HOOK}mu = {[0.1] * 16}",
        "mistuning.rings = 3: all deviations are given by segment: one ring",
    ),
    (f"{HOOK}mu = 1.5", "a relative standard deviation must be >= 0 and <= 1"),
    (f'{HOOK}mu = "wide"', "expected a number, such as 0.01 for 1 %"),
    (f"{HOOK}kn = {[-1.0] + [0.1] * 15}", "must be > -1 and <= 10"),
    (f"[mistuning]\nrange = [300, 200]\n{HOOK}mu = 0.1", "must be [low, high] with low < high"),
    (f"{HOOK}mu = 0.1\n[ring]\nsectors = 1", "ring.sectors = 1"),
]


@pytest.mark.parametrize(("text", "message"), MISTAKES)
def test_mistakes_are_reported(text, message):
    with pytest.raises(InputError) as error:
        parse_study(text)
    assert any(message in line for line in str(error.value).splitlines())
