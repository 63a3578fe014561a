"""`vanelock fit` on the coarsest mesh: what it leaves behind and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from vanelock import fit_study, load_study, parse_study
from vanelock.commands.fit.fit import rejoined, remarks
from vanelock.commands.fit.least_squares import fit
from vanelock.commands.fit.parameters import FitParameter, varied_parameters
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.common.tables import Table
from vanelock.input.cases.values import value_at
from vanelock.input.measured.curve import Measured
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Event, Notice
from vanelock.pipeline.step import Stages

STUDY = """
name = "rig"
[mesh]
size = "coarse"
[joints.interlock]
mu = 0.4  # a guess
[response]
harmonics = 1
[[measured]]
file = "rig.csv"
sigma = 0.3
[fit]
parameters = ["joints.interlock.mu"]
starts = 1
"""
HERTZ = np.linspace(260.0, 280.0, 15)
MU = "joints.interlock.mu"


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A folder with a study and its measurement, made with another friction; and the model."""
    folder = tmp_path_factory.mktemp("rig")
    (folder / "study.toml").write_text(STUDY)
    model = rejoined(
        parse_study(STUDY), Stages(Cache(folder / "run" / "cache", print), lambda event: None)
    )
    true = model.amplitudes({MU: 0.2}, Measured("", HERTZ, HERTZ))
    noise = 0.3 * np.random.default_rng(2).standard_normal(len(HERTZ))
    columns = {"speed (rpm)": 60 * HERTZ, "amplitude (um)": 1e6 * true + noise}
    write_columns(folder / "rig.csv", columns)
    return folder, model


def test_friction_is_found_and_written(rig):
    folder, _ = rig
    heard: list[Event] = []
    study = load_study(folder / "study.toml")
    found = fit_study(study, folder / "run", heard.append, STUDY, folder)
    low, high = found.interval(0)
    assert low < 0.2 < high
    assert 0.3 < found.after < 1.5 < 10 * found.after < found.before * 10
    assert found.before > 4
    (table,) = [event for event in heard if isinstance(event, Table)]
    assert table.rows[0][0] == "interlock.mu"
    assert any("start 1 of 1" in e.text for e in heard if isinstance(e, Notice))
    text = (folder / "run" / "fitted.toml").read_text()
    assert "# a guess" in text
    again = load_study(folder / "run" / "fitted.toml", outside=True)
    assert again.joints.interlock.mu == pytest.approx(found.value[0], rel=1e-5)
    assert (folder / "run" / again.measured[0].file).resolve() == (folder / "rig.csv").resolve()
    written = json.loads((folder / "run" / "fit.json").read_text())
    assert written["parameters"][0]["value"] == pytest.approx(found.value[0])
    assert (folder / "run" / "figures" / "fit.png").stat().st_size > 10_000
    header = (folder / "run" / "figures" / "fit.csv").read_text("utf-8").splitlines()[2]
    assert header.startswith("frequency (Hz): rig,measured (µm): rig")


def test_stuck_contacts_determine_nothing_of_friction(rig):
    """Under a thousandth of the load nothing slips, so that no friction fits worse."""
    folder, model = rig
    small = {"excitation.force": 0.03}
    true = model.amplitudes(small, Measured("", HERTZ, HERTZ))
    columns = {"f (Hz)": HERTZ, "a (um)": 1e6 * true, "sigma (um)": 1e4 * true + 1e-6}
    write_columns(folder / "small.csv", columns)
    text = STUDY.replace("rig.csv", "small.csv").replace("sigma = 0.3", "")
    text = text.replace("[response]", "[excitation]\nforce = 0.03\n[response]")
    (folder / "small.toml").write_text(text)
    found = fit_study(load_study(folder / "small.toml"), folder / "run", text=text, beside=folder)
    assert len(found.undetermined) == 1
    assert found.value[0] == pytest.approx(0.4)


def test_a_curve_may_have_a_load_of_its_own(rig):
    """It is the study's times as much; where all sticks, twice the load moves twice as far."""
    _, model = rig
    double = Measured("", HERTZ, HERTZ, load=2.0)
    once, twice = (
        model.amplitudes({"excitation.force": force}, each)
        for force, each in ((60.0, Measured("", HERTZ, HERTZ)), (30.0, double))
    )
    np.testing.assert_allclose(twice, once, rtol=1e-6)
    small, more = (
        model.amplitudes({"excitation.force": 0.03}, each)
        for each in (Measured("", HERTZ, HERTZ), double)
    )
    np.testing.assert_allclose(more, 2 * small, rtol=1e-6)
    assert double.label == ", load × 2"


def test_rejoined_parts_are_those_of_the_study_with_the_values(rig, tmp_path):
    """Modulus, stiffness, damping and load at once, against a study reduced and joined anew."""
    _, model = rig
    values = {
        "material.vane.E": 150e9,
        "material.casing.E": 185e9,
        "joints.interlock.kt": 2e6,
        "joints.hook.kn": 3e7,
        "joints.interlock.interference": 4e-6,
        "damping.ratio": 0.004,
        "excitation.force": 20.0,
        MU: 0.25,
    }
    text = STUDY.partition("[[measured]]")[0].replace(
        "mu = 0.4", "mu = 0.25\nkt = 2e6\ninterference = 4e-6"
    )
    text += "[material.vane]\nE = 150e9\n[material.casing]\nE = 185e9\n[joints.hook]\nkn = 3e7\n"
    text += "[damping]\nratio = 0.004\n[excitation]\nforce = 20\n"
    again = rejoined(parse_study(text), Stages(Cache(tmp_path, print), lambda event: None))
    at = Measured("", HERTZ, HERTZ)
    a, b = model.amplitudes(values, at), again.amplitudes({}, at)
    # The band of the reduction moves with the modulus; both are accurate to 1e-4.
    np.testing.assert_allclose(a, b, rtol=0.02)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('parameters = ["joints.mu"]', 'fit.parameters = \\["joints.mu"\\]: "joints.mu" cannot be'),
        (f'parameters = ["{MU}", "{MU}"]', "fitted keys must differ"),
        (f'parameters = ["{MU}"]\nbounds = {{ "{MU}" = [1, 0] }}', "expected \\[low, high\\] with"),
        (f'bounds = {{ "{MU}" = [0.1, "x"] }}', "expected a number"),
        ('bounds = { "joints.hook.mu" = [0.1, 1] }', '"joints.hook.mu" is not among fit.parameter'),
        ("starts = 0", "fit.starts = 0: number of starts must be >= 1"),
    ],
)
def test_what_cannot_be_fitted(text, expected):
    with pytest.raises(InputError, match=expected):
        parse_study(f'[measured]\nfile = "a.csv"\n[fit]\n{text}')


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[fit]", "fit: needs \\[\\[measured\\]\\]"),
        (
            '[joints.interlock]\nenabled = false\n[measured]\nfile = "a"\n[fit]',
            "joints.interlock.enabled = false",
        ),
        (
            '[excitation]\nunbalance = 1e-3\n[measured]\nfile = "a"\n[fit]\n'
            'parameters = ["excitation.force"]',
            "excitation.unbalance is given",
        ),
    ],
)
def test_what_the_study_has_not(text, expected):
    with pytest.raises(InputError, match=expected):
        parse_study(text)


def test_bounds_and_starts():
    text = '[measured]\nfile = "a"\n[fit]\nparameters = ["joints.interlock.interference"]'
    (found,) = varied_parameters(parse_study(text), "fit")
    assert (found.start, found.low, found.high) == pytest.approx((2e-6, 2e-7, 2e-5))
    assert found.logarithmic
    given = text + "\nbounds = { joints.interlock.interference = ['-1 um', '5 um'] }"
    (found,) = varied_parameters(parse_study(given), "fit")
    assert (found.low, found.high) == pytest.approx((-1e-6, 5e-6))
    assert not found.logarithmic
    outside = text + "\nbounds = { joints.interlock.interference = ['3 um', '5 um'] }"
    with pytest.raises(InputError, match="starts at 2e-06, outside of its bounds 3e-06 to 5e-06"):
        varied_parameters(parse_study(outside), "fit")
    beyond = text + "\nbounds = { joints.interlock.interference = ['1 um', '5 mm'] }"
    with pytest.raises(InputError, match=r"interference must be <= 0\.001"):
        varied_parameters(parse_study(beyond), "fit")
    gap = "[joints.interlock]\ninterference = 0\n" + text
    with pytest.raises(InputError, match="starts at 0: give its bounds in fit.bounds"):
        varied_parameters(parse_study(gap), "fit")


def test_a_study_without_a_fit(tmp_path):
    with pytest.raises(InputError, match=r"fit: the study has no \[fit\] table"):
        fit_study(parse_study(""), tmp_path)


KEYS = [
    MU,
    *(f"joints.{joint}.{name}" for joint in ("hook", "interlock") for name in ("kn", "kt")),
    "joints.interlock.interference",
    "excitation.force",
    "damping.ratio",
    "material.vane.E",
    "material.casing.E",
]


@pytest.mark.parametrize("gauge", [None, 0])
def test_slopes_are_those_of_differences(tmp_path_factory, gauge):
    folder = tmp_path_factory.mktemp("slopes")
    gauges = "[outputs]\ngauges = [{ aerofoil = 2, span = 0.1, chord = 0.5 }]\n"
    study = parse_study(STUDY.partition("[[measured]]")[0] + gauges)
    model = rejoined(study, Stages(Cache(folder / "cache", print), lambda event: None))
    hertz = np.array([262.0, 266.0, 271.0])
    quantity = "displacement" if gauge is None else "strain"
    curve = Measured("rig", hertz, hertz, quantity, gauge=gauge, load=0.7)
    values = {
        key: study.excitation.force_per_node if key == "excitation.force" else value_at(study, key)
        for key in KEYS
    }
    found = model.slopes(values, KEYS, curve)
    size = model.amplitudes(values, curve)
    step = 1e-4
    for i, key in enumerate(KEYS):
        up, down = (
            model.amplitudes(values | {key: values[key] * (1 + sign * step)}, curve)
            for sign in (1, -1)
        )
        expected = (up - down) / (2 * step)
        np.testing.assert_allclose(found[:, i] / size, expected / size, rtol=1e-4, atol=1e-5)


def test_jumps_and_neglected_harmonics_are_said(rig):
    """Points of the rig scatter by a hundredth of what they do: harmonics are missed then."""
    _, model = rig
    size = model.amplitudes({MU: 0.2}, Measured("", HERTZ, HERTZ))
    made = fit(
        lambda values: model.amplitudes({MU: values[0]}, Measured("", HERTZ, HERTZ)),
        size,
        np.full(len(size), 1e-4 * size.max()),
        [FitParameter(MU, 0.21, 0.1, 1.0)],
    )
    exact = Measured("rig", HERTZ, size, sigma=np.full(len(size), 1e-4 * size.max()))
    said = list(remarks(model, [exact], made))
    (harmonics,) = (text for text in said if text.startswith("HARMONICS ARE TOO FEW"))
    assert "those above 1 change" in harmonics
    rough = replace(exact, sigma=np.full(len(size), size.max()))
    assert not [text for text in remarks(model, [rough], made) if text.startswith("HARM")]
