"""What a page says of a study's inputs."""

import pytest

from vanelock import parse_study
from vanelock.results.page_sections.inputs import inputs

HOT = 'temperature.vane = 605\nmaterial.vane.E = [[20, "200 GPa"], [620, "155 GPa"]]\n'
GROWN = (
    "temperature.casing = 600\nmaterial.casing.expansion = 1e-5\nmaterial.vane.expansion = 1.3e-5\n"
)


@pytest.mark.parametrize(
    ("text", "words"),
    [(HOT, "modulus alone: thermal expansion"), (HOT + GROWN, "growth of the vane against")],
)
def test_thermal_expansion_is_left_out_where_none_is_given(text: str, words: str) -> None:
    study = parse_study(text)
    said = str(inputs(study, [study]).blocks[-1])
    assert "Temperature acts" in said
    assert words in said
