"""Quantities with units."""

import pytest

from vanelock.common.quantities import _rpm, si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.05 mm", "m", 5e-5),
        ("20 um", "m", 2e-5),
        ("1.67e7 N/m", "N/m", 1.67e7),
        ("16.7 N/um", "N/m", 1.67e7),
        ("170 GPa", "Pa", 170e9),
        ("8.2 g/cm^3", "kg/m^3", 8200.0),
        ("0.25 kHz", "Hz", 250.0),
        ("1.5 kg*mm", "kg*m", 1.5e-3),
        (0.25, "m", 0.25),
    ],
)
def test_units(text, unit, value):
    assert si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    ["5 s", "mm", "", "5 parsnips", "9**9**9**9", "__import__('os')", "1 mm" + " " * 99, "nan m m"],
)
def test_text_that_is_no_length_is_refused(text):
    with pytest.raises(ValueError, match="expected a number in m"):
        si(text, "m")


def test_revolutions_are_not_radians():
    assert _rpm("16000 rpm") == _rpm("1.6e4rpm") == _rpm(16000) == 16000
    for text in ("270 Hz", "16000", "1.2.3 rpm", "rpm"):
        with pytest.raises(ValueError, match="expected a number in rpm"):
            _rpm(text)
