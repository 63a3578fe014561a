"""What `[fit]` and `[campbell]` may ask for."""

import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError

FORCED = 'parameters = ["excitation.force"]\n'
MU, RIG = "joints.interlock.mu", '[measured]\nfile = "a.csv"\n'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('parameters = ["joints.mu"]', 'fit.parameters = \\["joints.mu"\\]: "joints.mu" cannot be'),
        (f'parameters = ["{MU}", "{MU}"]', "fitted keys must differ"),
        (f'parameters = {{ "{MU}" = [1, 0] }}', "expected \\[low, high\\] with"),
        (f'parameters = {{ "{MU}" = [0.1, "x"] }}', "expected a number"),
        (f'parameters = {{ "{MU}" = [0.1] }}', "expected at least 2 of them"),
        (f'bounds = {{ "{MU}" = [0.1, 1] }}', "fit.bounds: unknown key"),
        ("starts = 0", "fit.starts = 0: number of starts must be >= 1"),
        ("[joints]\ninterlock = false", "joints.interlock = false"),
        (
            'parameters = ["material.vane.E"]\n[material.vane]\nE = [[20, 2e11], [600, 1e11]]',
            '"material.vane.E": is given by temperature',
        ),
        (f"{FORCED}[excitation]\nunbalance = 1e-3", "excitation.unbalance is given"),
    ],
)
def test_what_cannot_be_fitted(text: str, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        parse_study(f"{RIG}[fit]\n{text}")
    with pytest.raises(InputError, match=r"fit: needs \[\[measured\]\]"):
        parse_study("[fit]")


def test_a_diagram_ends_where_temperatures_do() -> None:
    text = (
        '[material.vane]\nE = [[20, "200 GPa"], [620, "155 GPa"]]\n'
        "[temperature]\nvane = [[1000, 20], [9000, 600]]\n"
        "[campbell]\nengine_orders = [1]\nspeeds = "
    )
    study = parse_study(f"{text}[1000, 9000]")
    assert study.campbell is not None
    assert list(study.campbell.speeds or ()) == [1000, 9000]
    for speeds in ([999, 9000], [1000, 9001]):
        with pytest.raises(InputError, match="temperatures are given from 1000 to 9000 rpm"):
            parse_study(f"{text}{speeds}")
