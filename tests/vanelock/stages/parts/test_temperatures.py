"""Temperatures of parts: what a study may say, and the moduli that follow."""

import pytest

from vanelock import cases, parse_study
from vanelock.common.errors import InputError
from vanelock.stages.campbell.frequencies import bends
from vanelock.stages.parts.loads import described, modulus, reference

METAL = """
[material.vane]
E = [[20, "200 GPa"], [320, "185 GPa"], [620, "155 GPa"]]
"""


def complaint(text):
    with pytest.raises(InputError) as caught:
        parse_study(text, "hot.toml")
    return str(caught.value)


def test_moduli_lie_on_the_lines_between_those_given():
    study = parse_study(METAL + "[temperature]\nvane = [[0, 20], [10000, 620]]\nspeed = 2500")
    assert modulus(study, "vane") == pytest.approx(192.5e9)  # 170 degC
    assert modulus(study, "vane", 7500) == pytest.approx(170e9)  # 470 degC
    assert modulus(study, "casing") == 170e9
    assert reference(study, "vane") == 200e9
    of_vane = "temperatures of the response at 2,500 rpm: vane 170 degC, E = 192.5 GPa; "
    assert described(study) == of_vane + "casing E = 170 GPa"


def test_one_temperature_needs_no_speed():
    study = parse_study(METAL + "[temperature]\nvane = 470")
    assert modulus(study, "vane") == pytest.approx(170e9)
    assert not study.temperature.varies


def test_speeds_at_which_a_line_bends():
    """Where the temperature's own line bends, and where it passes a temperature listed."""
    study = parse_study(METAL + "[temperature]\nvane = [[0, 20], [5000, 220], [10000, 620]]")
    assert sorted(set(bends(study))) == pytest.approx([0, 5000, 6250, 10000])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[temperature]\nvane = 300", "temperature.vane: needs pairs of degC"),
        ("[temperature]\nspeed = 300", "temperature.speed = 300: needs temperature.vane or"),
        (METAL + "[temperature]\nvane = 700", "temperature.vane: 700 degC is outside material."),
        (METAL + "[temperature]\nreference = 0", "temperature.reference: 0 degC is outside"),
        (METAL + "[temperature]\nvane = -300", "temperature.vane = -300: temperature must be a"),
        (METAL + '[temperature]\nvane = "hot"', 'temperature.vane = "hot": temperature must be'),
        (METAL + "[temperature]\nvane = [[1, 20]]", "temperature.vane = [[1, 20]]: temperature mu"),
        (METAL + "[temperature]\nvane = [[1, 20], [1, 30]]", "1 and 1 rpm: speeds must ascend"),
        (METAL + "[temperature]\nvane = [[1, 20], [9, 30]]\nspeed = 10", "from 1 to 9 rpm"),
        (
            "accuracy = 0.1\n" + METAL + "[temperature]\nvane = [[1, 20], [9, 30]]",
            "accuracy = 0.1: needs temperature.speed",
        ),
        ('[material.casing]\nE = [[20, "2 kg"], [30, 1e9]]', "material.casing.E[0][1] = "),
        ("[material.casing]\nE = [[20, 2e9]]", "expected at least 2 of them"),
        ("[material.casing]\nE = [[20, 2e9], [20, 3e9]]", "20 and 20: the first number of each"),
    ],
)
def test_what_cannot_be(text, expected):
    line = complaint(text)
    assert line.startswith("hot.toml: ")
    assert expected in line
    assert "\n" not in line


def test_a_temperature_may_be_swept():
    study = parse_study(METAL + '[sweep]\n"temperature.vane" = [20, 470]')
    assert [modulus(case.study, "vane") for case in cases(study)] == pytest.approx([200e9, 170e9])
    study = parse_study(METAL + '[sweep]\n"temperature.vane" = [20, 700]')
    with pytest.raises(InputError, match=r'sweep."temperature.vane"\[1\] = 700: .* is outside'):
        cases(study)


def test_moduli_need_a_speed_where_temperatures_depend_on_it():
    study = parse_study(METAL + "[temperature]\nvane = [[0, 20], [10000, 620]]")
    with pytest.raises(InputError, match=r"temperature\.speed: must be given"):
        modulus(study, "vane")
    with pytest.raises(InputError, match=r"temperature\.vane: given from 0 to 10000 rpm, needed"):
        modulus(study, "vane", 11000)
