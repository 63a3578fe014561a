"""Tables on bounds and stability: what they may hold, and what of a response they need."""

import pytest

from vanelock import parse_study
from vanelock.analyses import ANALYSES
from vanelock.analyses.analysis import asked_for
from vanelock.analyses.bounds import BOUNDS, BoundsKeys
from vanelock.analyses.stability import STABILITY, StabilityKeys
from vanelock.common.errors import InputError


def test_the_name_of_a_table_alone_is_enough() -> None:
    study = parse_study("[bounds]\n[stability]\n")
    assert BOUNDS.keys_of(study) == BoundsKeys(share=1.0, starts=4)
    assert STABILITY.keys_of(study) == StabilityKeys(points="peaks")
    assert not list(asked_for(ANALYSES, parse_study("")))


@pytest.mark.parametrize("table", ["bounds", "stability"])
@pytest.mark.parametrize(
    ("key", "message"),
    [
        ('coupling = "uncoupled"', 'response.coupling = "uncoupled": must be "coupled"'),
        ("samples = 256", "response.samples = 256: leave it out"),
    ],
)
def test_other_responses_have_neither(table: str, key: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        parse_study(f"[response]\n{key}\n[{table}]\n")
    assert f"{message} for [{table}]" in str(error.value)


def test_isotropic_friction_has_both() -> None:
    study = parse_study('[response]\nfriction = "isotropic"\n[bounds]\n[stability]\n')
    assert [each.key for each, _ in asked_for(ANALYSES, study)] == ["bounds", "stability"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[bounds]\nshare = 1.5", "bounds.share = 1.5"),
        ("[bounds]\nstarts = -1", "bounds.starts = -1"),
        ('[stability]\npoints = "some"', "stability.points"),
        ("[response]\nfrequencies = [250]\n[bounds]", "a peak, which takes a range"),
        ("[settled]", "settled: needs [stability]"),
        ('accuracy = 0.05\n[stability]\npoints = "all"', 'stability.points = "all"'),
    ],
)
def test_mistakes_are_reported(text: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        parse_study(text)
    assert message in str(error.value)
