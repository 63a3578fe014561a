"""Numbers that are allowed but look like those of another unit are reported, with a guess."""

from pathlib import Path

import pytest

from vanelock import Study, check_file, load_study, template_text
from vanelock.input.settings import unusual


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "[material.vane]\nrho = 8.2e-9",
            "material.vane.rho = 8.2e-09 kg/m^3: density is hardly ever outside 50 to 25000 "
            'kg/m^3; "8.2e-09 t/mm^3"?',
        ),
        (
            "[material.casing]\nE = 1.7e8",
            "material.casing.E = 1.7e+08 Pa: Young's modulus is hardly ever outside 1e+09 to "
            '1.5e+12 Pa; "170000000 kPa"?',
        ),
        (
            "[joints.interlock]\nkn = 1e-3",
            "joints.interlock.kn = 0.001 N/m: normal stiffness is hardly ever outside 1 to 1e+13 "
            'N/m; "0.001 kN/um"?',
        ),
        (
            '[sweep]\n"material.vane.rho" = [8.2e3, 8.2]',
            'sweep."material.vane.rho"[1] = 8.2 kg/m^3: density is hardly ever outside 50 to '
            '25000 kg/m^3; "8.2 g/cm^3"?',
        ),
        (
            "[material.vane]\nE_at = [[20, 2e5], [600, 170e9]]",
            "material.vane.E_at[0] = 200000 Pa: Young's modulus by temperature is hardly ever "
            'outside 1e+09 to 1.5e+12 Pa; "200000 MPa"?',
        ),
    ],
)
def test_a_number_of_another_unit_is_reported(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "my.toml"
    path.write_text(text)
    assert unusual(load_study(path)) == (expected,)
    assert ("warning", expected) in check_file(path).rows


def test_usual_numbers_are_not_reported(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(template_text(all_keys=True))
    assert unusual(load_study(tmp_path / "my.toml")) == unusual(Study()) == ()
