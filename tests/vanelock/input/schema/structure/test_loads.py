"""Loads at rest of a study: what it may ask for, and which files it names."""

import pytest

from tests.vanelock.input.conftest import complaint, mistakes
from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.input.schema.structure.loads import files_named

OWN = '[vane]\nmesh = "vane.inp"\n'
HEAT = "[material.vane]\nexpansion = 1.3e-5\n[material.casing]\nexpansion = 1.2e-5\n"
BOTH = "[temperature]\nvane = 600\ncasing = 590\n"


MISTAKES = """
loads.axial = "3 Pa": expected a number in N
loads.axial = 2000000.0: axial gas force on an
loads.lift = 3: unknown key
OWN | loads.axial = 3: needs aerofoils by dimensions
OWN | loads.pressure.a = "3 N": expected a pressure of
OWN | loads.pressure.a = 2000000000.0: expected
OWN | loads.pressure.a = true: expected a pressure of
loads.axial = 1 | accuracy = 0.01: loads: loads at rest have no
material.vane.expansion = 1.3e-05: needs material.casing.expansion and \
temperature.vane and temperature.casing
material.casing.expansion = 1.2e-5; temperature.vane = 600 | \
material.vane.expansion = 1.3e-05: needs temperature
material.vane.expansion = 13: thermal expansion must
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        *mistakes(MISTAKES, OWN='vane.mesh = "vane.inp"'),
        ("[loads.pressure]\nsuction = 1e5", 'loads.pressure."suction": needs vane.mesh'),
        (OWN + '[loads.pressure]\n"a/b" = 1', 'loads.pressure."a/b": a set\'s name must not'),
        (
            '[temperature]\nfield = "t.csv"',
            "temperature.field: needs material.vane.expansion and material.casing.expansion",
        ),
        (
            HEAT + '[temperature]\nvane = [[0, 20], [9000, 600]]\ncasing = 20\nfield = "t.csv"',
            "temperature.field: is that of one speed",
        ),
    ],
)
def test_refusals_are_one_line(text, expected):
    line = complaint(text)
    assert "\n" not in line
    assert line.startswith(expected)


def test_units_and_sweeps():
    study = parse_study("[loads]\naxial = '0.02 kN'\ntorque = '100 N*mm'\n")
    assert (study.loads.axial, study.loads.torque) == (20.0, pytest.approx(0.1))
    text = OWN + '[loads.pressure]\n"BLADE-1.SUCTION" = "0.2 MPa"\nb = "b.CSV"\n'
    study = parse_study(text)
    assert study.loads.pressure == {"BLADE-1.SUCTION": pytest.approx(2e5), "b": "b.CSV"}
    assert parse_study(HEAT + BOTH).temperature.reference == 20
    swept = cases(parse_study(HEAT + BOTH + '[sweep]\n"temperature.vane" = [590, 610]\n'))
    assert [case.study.temperature.vane for case in swept] == [590, 610]


def test_files_are_beside_the_study_and_there(tmp_path):
    path = tmp_path / "study.toml"
    table = '[loads.pressure]\n"A.1" = "flow/p.csv"\nb = 3\n'
    heat = HEAT + '[temperature]\nfield = "t.csv"\ncasing = 590\n'
    path.write_text(OWN + table + heat)
    with pytest.raises(InputError) as caught:
        load_study(path)
    lines = str(caught.value).splitlines()
    assert [line.partition(" = ")[0].rpartition(": ")[2] for line in lines] == [
        "vane.mesh",
        "temperature.field",
        'loads.pressure."A.1"',
    ]
    assert all(line.endswith("no such file") for line in lines)
    (tmp_path / "flow").mkdir()
    for name in ("vane.inp", "t.csv", "flow/p.csv"):
        (tmp_path / name).write_text("x\n")
    study = load_study(path)
    assert study.loads.pressure == {"A.1": str(tmp_path / "flow" / "p.csv"), "b": 3.0}
    assert dict(files_named(study.model_dump())) == {
        ("vane", "mesh"): str(tmp_path / "vane.inp"),
        ("temperature", "field"): str(tmp_path / "t.csv"),
        ("loads", "pressure", "A.1"): str(tmp_path / "flow" / "p.csv"),
    }
    path.write_text(OWN + table.replace("flow", "..") + heat)
    with pytest.raises(InputError, match=r'loads.pressure."A.1"'):
        load_study(path)
