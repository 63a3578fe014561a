"""Measured curves from CSV files: what is understood, and one line for what is not."""

import numpy as np
import pytest

from vanelock import load_study, parse_study
from vanelock.common.errors import InputError
from vanelock.input.measured.curve import _read_measured, load_measured
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
        "n_rpm,strain_ustrain,sigma\n7500,2.5,0.1\n7800,3,0.1\n",
        'f in kHz,"strain (mm/km)",uncertainty (1)\n0.25,2.5,0.1e-6\n0.26,3,0.1e-6\n',
        "\ufefffreq (Hz),peak-to-peak (um/m),sigma\r\n250,5,0.2\r\n260,6,0.2\r\n",
        b"hz,strain (um/m),sigma\n250,2.5,0.1\n260,3,0.1\n",
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
        ("f (Hz),a (um)\n\n1,2\n0,4", 'line 4, column f: "0": expected a number > 0'),
        ("f (Hz),a (um)\n1,-2\n3,4", 'line 2, column a: "-2": expected a number >= 0'),
        ("f (Hz),a (um)\n1,inf\n3,4", 'line 2, column a: "inf": expected a number >= 0'),
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
