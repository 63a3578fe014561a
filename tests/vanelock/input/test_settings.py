"""Numbers that are allowed but look like those of another unit are reported, with a guess."""

from pathlib import Path

import pytest

from vanelock import Study, check_file, load_study, template_text
from vanelock.input.settings import unusual

UNUSUAL = """
material.vane.rho = 8.2e-09 kg/m^3: density, 50 to 25000 kg/m^3; "8.2e-09 t/mm^3"?
material.casing.E = 1.7e+08 Pa: Young's modulus, 1e+09 to 1.5e+12 Pa; "170000000 kPa"?
joints.interlock.kn = 0.001 N/m: normal stiffness, 1 to 1e+13 N/m; "0.001 kN/um"?
sweep."material.vane.rho"[1] = 8.2 kg/m^3: density, 50 to 25000 kg/m^3; "8.2 g/cm^3"?
material.vane.E[0] = 200000 Pa: Young's modulus, 1e+09 to 1.5e+12 Pa; \
"200000 MPa"?
"""
LISTS = {
    "material.vane.E": "[[20, 2e5], [600, 170e9]]",
    'sweep."material.vane.rho"': "[8.2e3, 8.2]",
}


@pytest.mark.parametrize("line", UNUSUAL.strip().splitlines())
def test_a_number_of_another_unit_is_reported(tmp_path: Path, line: str) -> None:
    head, _, value = line.partition(": ")[0].partition(" = ")
    key, in_list, _ = head.partition("[")
    path = tmp_path / "my.toml"
    path.write_text(f"{key} = {LISTS[key] if in_list else value.split()[0]}")
    expected = line.replace(", ", " is hardly ever outside ")
    assert unusual(load_study(path)) == (expected,)
    assert ("warning", expected) in check_file(path).rows


def test_usual_numbers_are_not_reported(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(template_text(all_keys=True))
    assert unusual(load_study(tmp_path / "my.toml")) == unusual(Study()) == ()
