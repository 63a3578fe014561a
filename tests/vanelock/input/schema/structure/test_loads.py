"""Loads at rest, temperatures, fits and diagrams: what a study may ask for, and what follows."""

import pytest

from tests.vanelock.input.conftest import complaint, mistakes
from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.input.schema.structure.loads import files_named
from vanelock.stages.campbell.frequencies import bends
from vanelock.stages.parts.loads import described, modulus, reference

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


METAL = """
[material.vane]
E = [[20, "200 GPa"], [320, "185 GPa"], [620, "155 GPa"]]
"""
TEMPERATURES = {
    "vane = 700": "temperature.vane: 700 degC is outside material.",
    "reference = 0": "temperature.reference: 0 degC is outside",
    "vane = -300": "temperature.vane = -300: temperature must be a",
    'vane = "hot"': 'temperature.vane = "hot": temperature must be',
    "vane = [[1, 20]]": "temperature.vane = [[1, 20]]: temperature mu",
    "vane = [[1, 20], [1, 30]]": "1 and 1 rpm: speeds must ascend",
    "vane = [[1, 20], [9, 30]]\nspeed = 10": "from 1 to 9 rpm",
}
MU = "joints.interlock.mu"
FITTED = {
    'parameters = ["joints.mu"]': 'fit.parameters = ["joints.mu"]: "joints.mu" cannot be',
    f'parameters = ["{MU}", "{MU}"]': "fitted keys must differ",
    f"parameters.{MU} = [1, 0]": "expected [low, high] with",
    f'parameters.{MU} = [0.1, "x"]': "expected a number",
    f"parameters.{MU} = [0.1]": "expected at least 2 of them",
    f"bounds.{MU} = [0.1, 1]": "fit.bounds",
    "starts = 0": "fit.starts = 0: number of starts must be >= 1",
    "[joints]\ninterlock = false": "joints.interlock = false",
    f'parameters = ["material.vane.E"]\n{METAL}': '"material.vane.E": is given by temperature',
    'parameters = ["excitation.force"]\n[excitation]\nunbalance = 1e-3': (
        "excitation.unbalance is given"
    ),
}


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
        *((f"{METAL}[temperature]\n{text}", line) for text, line in TEMPERATURES.items()),
        *((f'[measured]\nfile = "a.csv"\n[fit]\n{text}', line) for text, line in FITTED.items()),
        ("[temperature]\nvane = 300", "temperature.vane: needs pairs of degC"),
        ("[temperature]\nspeed = 300", "temperature.speed = 300: needs temperature.vane or"),
        ('[material.casing]\nE = [[20, "2 kg"], [30, 1e9]]', "material.casing.E[0][1] = "),
        ("[material.casing]\nE = [[20, 2e9]]", "expected at least 2 of them"),
        ("[material.casing]\nE = [[20, 2e9], [20, 3e9]]", "20 and 20: the first number of each"),
        (
            f"accuracy = 0.1\n{METAL}[temperature]\nvane = [[1, 20], [9, 30]]",
            "accuracy = 0.1: needs temperature.speed",
        ),
        ("[fit]", "fit: needs [[measured]]"),
    ],
)
def test_refusals_are_one_line(text, expected):
    line = complaint(text)
    assert "\n" not in line
    assert expected in line


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


def test_moduli_lie_on_the_lines_between_those_given():
    study = parse_study(METAL + "[temperature]\nvane = [[0, 20], [10000, 620]]\nspeed = 2500")
    assert modulus(study, "vane") == pytest.approx(192.5e9)  # 170 degC
    assert modulus(study, "vane", 7500) == pytest.approx(170e9)  # 470 degC
    assert modulus(study, "casing") == 170e9
    assert reference(study, "vane") == 200e9
    of_vane = "temperatures of the response at 2,500 rpm: vane 170 degC, E = 192.5 GPa; "
    assert described(study) == of_vane + "casing E = 170 GPa"


def test_speeds_at_which_a_line_bends():
    """Where the temperature's own line bends, and where it passes a temperature listed."""
    study = parse_study(METAL + "[temperature]\nvane = [[0, 20], [5000, 220], [10000, 620]]")
    assert sorted(set(bends(study))) == pytest.approx([0, 5000, 6250, 10000])


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


def test_a_diagram_ends_where_temperatures_do():
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
