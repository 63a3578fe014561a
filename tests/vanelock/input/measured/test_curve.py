"""Measured curves from CSV and Universal Files: what is understood, and a line for what is not."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff

from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.measured.curve import Measured, _read_measured, load_measured
from vanelock.input.measured.universal import _RecordOrdinate, _scale
from vanelock.input.schema.comparison import MeasuredCurve


def read(folder, text, gauges=1, order=2, **keys):
    path = folder / "data.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return _read_measured(MeasuredCurve(file=str(path), **keys), order, gauges, "measured[0]")


def test_frequency_and_amplitude_in_any_order_of_rows_and_what_the_study_says_of_them(tmp_path):
    rows = "Frequency (Hz), Amplitude (um)\n260.5,2.5\n259,1\n# end\n,\n261,\n"
    found = read(tmp_path, f"# rig\n\n{rows}")
    assert (found.name, found.frequency.tolist()) == ("data", [259, 260.5])
    assert found.amplitude == pytest.approx([1e-6, 2.5e-6])
    assert (found.quantity, found.sigma, found.gauge) == ("displacement", None, None)
    keys = {"name": "rig 2", "engine_order": 1, "sigma": 0.1, "direction": "down", "load": 2.0}
    found = read(tmp_path, "speed (rpm),displacement (mm)\n6000,1\n6060,2\n", **keys)
    assert (found.label, found.direction) == ("rig 2, load × 2", "down")
    assert found.frequency == pytest.approx([100, 101])
    assert found.sigma == pytest.approx([1e-4, 1e-4])


@pytest.mark.parametrize(
    "text",
    [
        "speed [rpm]; strain [µm/m]; sigma\n7500;2,5;0,1\n7800;3,0;0,1\n",
        "rpm\tstrain (microstrain)\tstd (um/m)\n7500\t2.5\t0.1\n7800\t3.0\t0.1\n",
        'f in kHz,"strain (mm/km)",uncertainty (1)\n0.25,2.5,0.1e-6\n0.26,3,0.1e-6\n',
        "\ufefffreq (Hz),peak-to-peak (um/m),sigma\r\n250,5,0.2\r\n260,6,0.2\r\n",
        "rotor speed (rev/s),strain (µm/m),s\n125,2.5,0.1\n130,3,0.1\n".encode("cp1252"),
    ],
)
def test_one_curve_in_many_executor(tmp_path, text):
    """The same strain at engine order 2, as different programs write it."""
    found = read(tmp_path, text)
    assert found.frequency == pytest.approx([250, 260])
    assert found.speed == pytest.approx([7500, 7800])
    assert found.amplitude == pytest.approx([2.5e-6, 3e-6])
    assert found.sigma == pytest.approx([1e-7, 1e-7])
    assert (found.quantity, found.gauge, found.engine_order) == ("strain", 0, 2)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "data.csv: empty: a header and numbers are needed"),
        ("frequency (Hz)\n1\n2", "line 1: needs a column amplitude with its unit"),
        ("a (um)\n1\n2", "line 1: needs a column frequency (Hz) or speed (rpm)"),
        ("f (Hz),a\n1,2\n3,4", 'line 1, column a: needs a unit, such as "a (um)"'),
        ("f (Hz),a (kg)\n1,2\n3,4", 'line 1, column a: unit "kg": expected a length such as um'),
        ("f (m),a (um)\n1,2\n3,4", 'line 1, column f: unit "m": expected one of Hz'),
        ("f (Hz),a (um)\n1,2\nx,4", 'line 3, column f: "x": expected a number > 0'),
        ("f (Hz),a (um)\n1,-2\n3,4", 'line 2, column a: "-2": expected a number >= 0'),
        ("f (Hz),a (um),s\n1,2,0\n3,4,1", 'line 2, column s: "0": expected a number > 0'),
        ("f (Hz),a (um)\n1,2,3\n3,4", "line 2: 3 cells under 2 columns"),
        ("f (Hz),freq (Hz),a (um)\n1,2,3", "line 1: columns 1 and 2 both hold the frequency"),
        ("f (Hz),a (um)\n1,2\n", "data.csv: 1 point: at least 2 are needed"),
    ],
)
def test_what_cannot_be_read(tmp_path, text, expected):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert expected in str(caught.value)
    assert str(tmp_path / "data.csv") in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("gauges", [0, 2])
def test_a_strain_needs_its_gauge_and_a_displacement_has_none(tmp_path, gauges):
    text = "f (Hz),{} ({})\n1,2\n3,4"
    with pytest.raises(InputError, match=r"measured\[0\]: .*data.csv holds a strain: give gauge"):
        read(tmp_path, text.format("strain", "um/m"), gauges)
    if gauges:
        assert read(tmp_path, text.format("strain", "um/m"), gauges, gauge=2).gauge == 1
    with pytest.raises(InputError, match=r"measured\[0\]\.gauge = 1: .* holds no strain"):
        read(tmp_path, text.format("a", "um"), gauge=1)


def test_files_lie_beside_the_study(tmp_path):
    (tmp_path / "rig.csv").write_text("f (Hz),a (um)\n1,2\n3,4")
    study = tmp_path / "study.toml"
    for head in ("[measured]", "[[measured]]"):
        study.write_text(f'{head}\nfile = "rig.csv"\n')
        (found,) = load_measured(load_study(study))
        np.testing.assert_allclose(found.amplitude, [2e-6, 4e-6])
    for name, expected in (("none.csv", r"none\.csv: no such file"), (".", "is a folder, a CSV")):
        study.write_text(f'[[measured]]\nfile = "{name}"\n')
        with pytest.raises(InputError, match=expected):
            load_measured(load_study(study))


def test_every_gauge_of_the_study_may_have_been_measured():
    gauge = "{ aerofoil = 1, span = 0.2, chord = 0.5 }"
    text = f"[outputs]\ngauges = [{gauge}, {gauge}]\n[measured]\nfile = 'a.csv'\ngauge = "
    assert parse_study(f"{text}2").measured[0].gauge == 2
    with pytest.raises(InputError, match=r"measured\[0\].gauge = 3: outputs.gauges has 1 to 2"):
        parse_study(f"{text}3")


HERTZ = np.linspace(0, 400, 401)
OMEGA = 2 * np.pi * HERTZ
RECEPTANCE = 1 / (2.0 * ((2 * np.pi * 260) ** 2 - OMEGA**2 + 0.02j * OMEGA * 2 * np.pi * 260))
"""Of a mass of 2 kg at 260 Hz, m/N."""
DISPLACEMENT, STRAIN, VELOCITY, ACCELERATION, FORCE = 8, 3, 11, 12, 13


def record(data: Any, x: Any = HERTZ, **changed: Any) -> dict[str, Any]:
    """A function record, a frequency response by default."""
    given = {
        "func_type": 4, "rsp_node": 12, "rsp_dir": 3, "ref_node": 7, "ref_dir": -1,
        "data": np.asarray(data), "x": np.asarray(x), "id1": "rig", "rsp_ent_name": "vane",
        "ref_ent_name": "vane", "abscissa_spacing": 1, "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": DISPLACEMENT, "orddenom_spec_data_type": 0,
        "abscissa_axis_units_lab": "Hz", "ordinate_axis_units_lab": "m",
        "orddenom_axis_units_lab": "NONE", "z_axis_spec_data_type": 0,
    }  # fmt: skip
    return {"type": 58, "binary": 0, **given, **changed}


SI = {
    "type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1,
    "length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15,
}  # fmt: skip
MILLIMETRES = {**SI, "length": 1e3}
"""The factors lead from SI to the file's units: a metre has a thousand of these."""


def write(path: Path, *sets: dict[str, Any]) -> Path:
    """By the library, which writes function types 1 to 9: others are put in afterwards."""
    file = pyuff.UFF(str(path))
    for each in sets:
        kind = each.get("func_type", 4)
        written = {**each, "func_type": kind if kind < 10 else 4}
        file.write_sets([written], "add")
        if kind >= 10:
            path.write_bytes(path.read_bytes().replace(b"    4         0", b"%5d         0" % kind))
    return path


def read_record(path: Path | str, **keys: Any) -> Measured:
    return _read_measured(MeasuredCurve(file=str(path), **keys), 2, 1, "measured[0]")


def complaint(path: Path | str, **keys: Any) -> str:
    with pytest.raises(InputError) as caught:
        read_record(path, **keys)
    text = str(caught.value)
    assert "\n" not in text
    folder, name = os.path.split(str(path).partition(":")[0])
    assert os.path.join(folder, name) in text or "measured[0]" in text
    return text.replace(f"{folder}/", "")


PER_FORCE = {"orddenom_spec_data_type": FORCE, "orddenom_axis_units_lab": "N"}


LABEL, KIND, OVER = "ordinate_axis_units_lab", "ordinate_spec_data_type", "orddenom_axis_units_lab"


@pytest.mark.parametrize(
    ("factor", "changed", "units"),
    [
        (1, {}, None),
        (1e3, {LABEL: "mm"}, None),
        (1e3, {LABEL: "NONE"}, MILLIMETRES),
        (1j * OMEGA, {KIND: VELOCITY, LABEL: "m/s"}, SI),
        (-(OMEGA**2) / 9.80665, {KIND: ACCELERATION, LABEL: "g"}, None),
        (-(OMEGA**2), {KIND: 0, LABEL: "(m/s^2)"}, None),
        (1, {"binary": 1}, None),
        (1, {"func_type": 12}, SI),
    ],
)
def test_a_modulus_is_read_in_metres_whatever_was_measured(tmp_path, factor, changed, units):
    sets = [record(30.0 * factor * RECEPTANCE, **changed)]
    path = write(tmp_path / "rig.uff", *([units] if units else []), *sets)
    found = read_record(path, range=[240, 280], sigma=0.1)
    inside = (HERTZ >= 240) & (HERTZ <= 280)
    np.testing.assert_allclose(found.frequency, HERTZ[inside])
    np.testing.assert_allclose(found.amplitude, 30.0 * np.abs(RECEPTANCE[inside]), rtol=1e-9)
    assert found.sigma is not None
    scale = np.abs(np.broadcast_to(factor, HERTZ.shape))[inside]
    np.testing.assert_allclose(found.sigma, 0.1 / scale, rtol=1e-9)
    assert (found.name, found.quantity, found.engine_order) == ("rig", "displacement", 2)


@pytest.mark.parametrize(
    ("factor", "changed", "units"),
    [
        (1, {}, None),
        (1, {LABEL: "m/N", "orddenom_spec_data_type": 0}, None),
        (1e6, {OVER: "MN"}, None),
        (1e3, {LABEL: "", OVER: ""}, MILLIMETRES),
        (1e3 / 0.22480894, {LABEL: "mm", OVER: ""}, {**MILLIMETRES, "force": 0.22480894}),
    ],
)
def test_a_response_per_force_is_multiplied_by_the_force(tmp_path, factor, changed, units):
    sets = [record(factor * RECEPTANCE, **{**PER_FORCE, **changed})]
    path = write(tmp_path / "rig.unv", *([units] if units else []), *sets)
    found = read_record(path, force="30 N")
    np.testing.assert_allclose(found.amplitude, 30 * np.abs(RECEPTANCE[1:]), rtol=1e-9)
    assert "record 1: a response per force: give force, what it is multiplied by" in complaint(path)


def test_speed_becomes_frequency_by_the_engine_order_and_strain_its_gauge(tmp_path):
    speeds = {"abscissa_spec_data_type": 19, "abscissa_axis_units_lab": "rpm"}
    strain = {"func_type": 27, "abscissa_spacing": 0, KIND: STRAIN, LABEL: "um/m"}
    given = record([10.0, 20.0, 15.0], [7500.0, 7800.0, 8100.0], **speeds, **strain)
    found = read_record(write(tmp_path / "strain.uff", given))
    assert found.frequency == pytest.approx([250, 260, 270])
    assert found.amplitude == pytest.approx([10e-6, 20e-6, 15e-6])
    assert (found.quantity, found.gauge) == ("strain", 0)


def test_one_of_several_records_is_chosen_or_all_are_listed(tmp_path):
    path = write(
        tmp_path / "rig.uff",
        record(RECEPTANCE),
        record(2 * RECEPTANCE, rsp_node=13, rsp_dir=-2, ref_dir=0),
        record(np.ones(401), func_type=6, ordinate_spec_data_type=0, ordinate_axis_units_lab=""),
    )
    np.testing.assert_allclose(read_record(f"{path}:2").amplitude, 2 * np.abs(RECEPTANCE[1:]))
    listed = (
        "1 (frequency response 12+z/7-x in m, 401 points), "
        "2 (frequency response 13-y in m, 401 points), 3 (coherence 12+z/7-x, 401 points)"
    )
    assert complaint(path) == f"rig.uff: several records: give rig.uff:1: {listed}"
    for number in (0, 4):
        assert complaint(f"{path}:{number}") == f"rig.uff: no record {number}: {listed}"
    assert complaint(f"{path}:3") == "rig.uff: record 3: a coherence, which has no amplitudes"


def test_by_the_formats_description(tmp_path):
    """A file typed after the format's description: real, single precision, uneven spacing."""
    lines = [
        "    -1", "   164",
        "         3US: Foot                         2",
        "  3.28083989501312334e+00  2.24808943099710480e-01  1.80000000000000000e+00",
        "  4.59670000000000000e+02", "    -1", "    -1", "    58",
        *["NONE"] * 5,
        "    4         0    0         0       NONE        12   3       NONE         0   0",
        "         2         3         0  0.00000e+00  0.00000e+00  0.00000e+00",
        "        18    0    0    0            Frequency                   Hz",
        "         8    0    0    0         Displacement                 NONE",
        "         0    0    0    0                 NONE                 NONE",
        "         0    0    0    0                 NONE                 NONE",
        "  2.50000e+02  1.00000e-03  2.60000e+02  3.00000e-03  2.70000e+02  2.00000e-03",
        "    -1",
    ]  # fmt: skip
    path = tmp_path / "feet.unv"
    path.write_text("\n".join(lines) + "\n")
    found = read_record(path)
    assert found.frequency.tolist() == [250, 260, 270]
    assert found.amplitude == pytest.approx([0.3048e-3, 0.9144e-3, 0.6096e-3], rel=1e-9)


@pytest.mark.parametrize(
    ("changed", "units", "expected"),
    [
        ({LABEL: "mm"}, SI, "record 1: in mm by its label, in 1 m by the file's"),
        ({LABEL: "NONE"}, None, 'record 1: says no unit: give unit, such as "um"'),
        ({KIND: 0, LABEL: "V"}, None, "like m, m/s, m/s^2"),
        ({KIND: 15}, None, "of type 15: strain, displacement, velocity, acc"),
        ({"orddenom_spec_data_type": 12}, None, "over a quantity of type 12: only force can be"),
        ({**PER_FORCE, OVER: "V"}, None, 'over "V": expected a force'),
        ({"abscissa_spec_data_type": 17}, None, "not over frequency or speed (abscissa of type 17"),
        ({"func_type": 1}, None, "a time response, which has no amplitudes"),
    ],
)
def test_what_is_no_amplitude_or_has_no_unit(tmp_path, changed, units, expected):
    given = record(np.abs(RECEPTANCE) if changed.get("func_type") else RECEPTANCE, **changed)
    assert expected in complaint(write(tmp_path / "rig.uff", *([units] if units else []), given))


def test_the_study_decides_a_unit(tmp_path):
    path = write(tmp_path / "rig.uff", SI, record(RECEPTANCE, ordinate_axis_units_lab="mm"))
    found = read_record(path, unit="um")
    np.testing.assert_allclose(found.amplitude, 1e-6 * np.abs(RECEPTANCE[1:]))
    found = read_record(path, unit="mm/N", force=2.0)
    np.testing.assert_allclose(found.amplitude, 2e-3 * np.abs(RECEPTANCE[1:]))
    assert 'unit "kg": expected one like m' in complaint(path, unit="kg")
    assert "no response per force: leave out force" in complaint(path, unit="mm", force=2.0)


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "none.uff"
    assert complaint(path) == "none.uff: no such file"
    path.write_text("anything\n")
    assert "not a Universal File that can be read: no function record, data set 58" in complaint(
        path
    )
    path = write(tmp_path / "units.uff", SI)
    assert "it holds 164" in complaint(path)
    good = write(tmp_path / "good.uff", record(RECEPTANCE)).read_bytes()
    short = tmp_path / "short.uff"
    short.write_bytes(good[: len(good) // 2] + b"\n    -1\n")
    assert "short.uff: " in complaint(short)
    csv = tmp_path / "rig.csv"
    csv.write_text("f (Hz),a (um)\n1,2\n3,4")
    for key, value in (("unit", "m"), ("force", 1.0)):
        message = complaint(csv, **{key: value})
        assert message.startswith(f"measured[0].{key} = ")
        assert message.endswith("is for Universal Files (.uff, .unv, .uf)")


def test_a_range_must_leave_points_and_no_displacement_is_found_at_0_hz(tmp_path):
    csv = tmp_path / "rig.csv"
    csv.write_text("f (Hz),a (um)\n1,2\n3,4\n5,6\n")
    assert read_record(csv, range=[2, 6]).frequency.tolist() == [3, 5]
    assert complaint(csv, range=[4, 6]) == "rig.csv: 1 point from 4 to 6 Hz: at least 2 are needed"
    hertz = np.array([0.0, 0.25, 1.0, 8.0])
    found = _scale(_RecordOrdinate("velocity", 1e-3, False), hertz, None, "rig.uff")
    assert np.isnan(found[0])
    assert found[1:] == pytest.approx(1e-3 / (2 * np.pi * hertz[1:]))
