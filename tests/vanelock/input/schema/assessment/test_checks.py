"""Tables on bounds and stability: what they may hold, and what of a response they need."""

import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError
from vanelock.input.schema.assessment.bounds_and_stability import BoundsKeys, StabilityKeys


def test_the_name_of_a_table_alone_is_enough() -> None:
    study = parse_study("[bounds]\n[stability]\n")
    assert study.bounds == BoundsKeys(joints=None, share=1.0, starts=4, seed=1)
    assert study.stability == StabilityKeys(points="peaks")
    assert parse_study("").bounds is None
    assert parse_study("").stability is None


@pytest.mark.parametrize("table", ["bounds", "stability"])
@pytest.mark.parametrize(
    ("key", "message"),
    [
        ('coupling = "uncoupled"', 'response.coupling = "uncoupled": must be "coupled"'),
        ("samples = 256", "response.samples = 256: leave it out"),
        ('harmonic_diameters = "sector"', 'response.harmonic_diameters = "sector": must be "wave"'),
    ],
)
def test_other_responses_have_neither(table: str, key: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        parse_study(f"[response]\n{key}\n[{table}]\n")
    assert f"{message} for [{table}]" in str(error.value)


def test_isotropic_friction_has_both() -> None:
    study = parse_study('[response]\nfriction = "isotropic"\n[bounds]\n[stability]\n')
    assert study.bounds is not None
    assert study.stability is not None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[bounds]\njoints = ["hok"]', 'bounds.joints: given "hok": allowed are hook, interlock'),
        ("[bounds]\nshare = 1.5", "bounds.share = 1.5"),
        ("[bounds]\nstarts = -1", "bounds.starts = -1"),
        ('[stability]\npoints = "some"', "stability.points"),
        ("[response]\nfrequencies = [250]\n[bounds]", "a peak, which takes a range"),
        (
            '[joints.interlock]\nenabled = false\n[bounds]\njoints = ["interlock"]',
            'given "interlock": allowed are hook',
        ),
        ('accuracy = 0.05\n[stability]\npoints = "all"', 'stability.points = "all"'),
    ],
)
def test_mistakes_are_reported(text: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        parse_study(text)
    assert message in str(error.value)
