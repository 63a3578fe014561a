"""`vanelock fit` on a small study: what it leaves behind and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.small_study import SMALL
from vanelock import fit_study, load_study, load_system, open_results, parse_study
from vanelock.commands.fit.fit import _usable, remarks
from vanelock.commands.fit.least_squares import fit
from vanelock.commands.fit.parameters import FitParameter, varied_parameters
from vanelock.commands.fit.refit_model import rejoined
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import write_columns
from vanelock.common.tables import Table
from vanelock.input.cases.values import value_at
from vanelock.input.measured.curve import Measured
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Event, Notice
from vanelock.pipeline.step import Stages

MU = "joints.interlock.mu"
FORCE = "excitation.force"
STUDY = f"""
name = "rig"
{SMALL}
{MU} = 0.4  # a guess
response.harmonics = 1
measured = [{{ file = "rig.csv", sigma = 0.3 }}]
fit = {{ parameters = ["{MU}"], starts = 1 }}
"""
HERTZ = np.linspace(249.0, 263.0, 8)
CURVE = Measured("rig", HERTZ, HERTZ)
KEYS = [
    MU,
    *(f"joints.{joint}.{name}" for joint in ("hook", "interlock") for name in ("kn", "kt")),
    "joints.interlock.interference",
    FORCE,
    "damping.ratio",
    "material.vane.E",
    "material.casing.E",
]


def test_friction_is_found_and_written(small_model, tmp_path):
    true = small_model.amplitudes({MU: 0.2}, CURVE)
    noise = 0.3 * np.random.default_rng(2).standard_normal(len(HERTZ))
    columns = {"speed (rpm)": 60 * HERTZ, "amplitude (um)": 1e6 * true + noise}
    write_columns(tmp_path / "rig.csv", columns)
    (tmp_path / "study.toml").write_text(STUDY)
    heard: list[Event] = []
    study, folder = load_study(tmp_path / "study.toml"), tmp_path / "run"
    found = fit_study(study, folder, heard.append, STUDY, tmp_path)
    low, high = found.interval(0)
    assert low < 0.2 < high
    assert 0.3 < found.after < 1.5 < 10 * found.after < found.before * 10
    assert found.before > 4
    (table,) = [event for event in heard if isinstance(event, Table)]
    assert table.rows[0][0] == "interlock.mu"
    assert any("start 1 of 1" in e.text for e in heard if isinstance(e, Notice))
    text = (folder / "fitted.toml").read_text()
    assert "# a guess" in text
    again = load_study(folder / "fitted.toml", outside=True)
    assert again.joints.interlock.mu == pytest.approx(found.value[0], rel=1e-5)
    assert (folder / again.measured[0].file).resolve() == (tmp_path / "rig.csv").resolve()
    written = json.loads((folder / "fit.json").read_text())
    assert written["parameters"][0]["value"] == pytest.approx(found.value[0])
    assert (folder / "figures" / "fit.png").stat().st_size > 10_000
    header = (folder / "figures" / "fit.csv").read_text("utf-8").splitlines()[2]
    assert header.startswith("frequency (Hz): rig,measured (µm): rig")


def test_loads_at_rest_and_heat_are_those_of_the_run(golden, kept_by):
    """The curve is the run's own, and twice the load leaves what acts at rest."""
    run = golden("everything")
    with open_results(run.folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
    expected = load_system(run.folder / "results.h5", "nominal").force[0]
    model = rejoined(parse_study(run.text), kept_by("everything"))
    hertz = response.frequency[::5]
    found = model.monitor.amplitude(model.solved({}, hertz).response)
    np.testing.assert_allclose(found, model.monitor.amplitude(response)[::5], rtol=1e-9)
    once, twice = (model.solved({}, hertz[:2], load=load).system.force for load in (1.0, 2.0))
    for force in (once, twice):
        np.testing.assert_array_equal(force[0].vector, expected.vector)
    np.testing.assert_array_equal(twice[1].vector, 2 * once[1].vector)


def test_rejoined_parts_are_those_of_the_study_with_the_values(tmp_path):
    """Modulus, stiffness, damping and load at once, against a study reduced and joined anew."""
    values = {
        "material.vane.E": 150e9,
        "material.casing.E": 185e9,
        "joints.interlock.kt": 3e6,
        "joints.hook.kn": 8e7,
        "joints.interlock.interference": 4e-6,
        "damping.ratio": 0.004,
        FORCE: 20.0,
        MU: 0.25,
    }
    text = "\n".join(line for line in SMALL.splitlines() if line.partition(" ")[0] not in values)
    text += "".join(f"\n{key} = {value}" for key, value in values.items())
    text += '\nmesh.correction = "none"\nresponse.harmonics = 1\n'
    stages = Stages(Cache(tmp_path, print), lambda event: None)
    again = rejoined(parse_study(text), stages)
    # The mesh correction of the study's own joints is held, that of others is another one.
    plain = f'{SMALL}mesh.correction = "none"\nresponse.harmonics = 1\n'
    a = rejoined(parse_study(plain), stages).amplitudes(values, CURVE)
    # The band of the reduction moves with the modulus; both are accurate to 1e-4.
    np.testing.assert_allclose(a, again.amplitudes({}, CURVE), rtol=0.02)


def test_frequencies_are_as_the_root_of_the_stiffness(small_model):
    """Moduli, contacts and force c times as large, mesh correction included: √c times those."""
    c, study = 0.9, small_model.study
    values = {key: c * value_at(study, key) for key in KEYS if key[-2:] in (".E", "kn", "kt")}
    values[FORCE] = c * study.excitation.force_per_node
    own = small_model.amplitudes({}, CURVE)
    scaled = small_model.amplitudes(values, CURVE, np.sqrt(c) * HERTZ)
    np.testing.assert_allclose(scaled, own, rtol=1e-6)
    held = {key: value for key, value in values.items() if not key.endswith("casing.E")}
    assert np.abs(small_model.amplitudes(held, CURVE, np.sqrt(c) * HERTZ) / own - 1).max() > 0.01


def test_bounds_and_starts():
    key = "joints.interlock.interference"
    text = f'[measured]\nfile = "a"\n[fit]\nparameters = ["{key}"]'
    (found,) = varied_parameters(parse_study(text), "fit")
    assert (found.start, found.low, found.high) == pytest.approx((2e-6, 2e-7, 2e-5))
    assert found.logarithmic
    given = text.partition("[fit]")[0] + f"[fit]\nparameters.{key} = ['-1 um', '5 um']"
    (found,) = varied_parameters(parse_study(given), "fit")
    assert (found.low, found.high) == pytest.approx((-1e-6, 5e-6))
    assert not found.logarithmic
    for wrong, expected in (
        (given.replace("-1 um", "3 um"), "starts at 2e-06, outside of its bounds 3e-06 to 5e-06"),
        (given.replace("5 um", "5 mm").replace("-1", "1"), r"interference must be <= 0\.001"),
        (f"{key} = 0\n{text}", "starts at 0: give its bounds in fit.parameters"),
    ):
        with pytest.raises(InputError, match=expected):
            varied_parameters(parse_study(wrong), "fit")


def test_slopes_are_those_of_differences(small_model):
    """Of the displacement and of the strain of a gauge, of one response."""
    hertz, study = np.array([250.0, 255.0]), small_model.study
    curves = [
        Measured("rig", hertz, hertz, load=0.7),
        Measured("rig", hertz, hertz, "strain", gauge=0, load=0.7),
    ]
    values = {
        key: study.excitation.force_per_node if key == FORCE else value_at(study, key)
        for key in KEYS
    }

    def sizes(changed):
        return np.array([small_model.amplitudes(values | changed, curve) for curve in curves])

    size = sizes({})
    found = np.array([small_model.slopes(values, KEYS, curve) for curve in curves])
    step = 1e-4
    for i, key in enumerate(KEYS):
        up, down = (sizes({key: values[key] * (1 + sign * step)}) for sign in (1, -1))
        expected = (up - down) / (2 * step)
        np.testing.assert_allclose(found[:, :, i] / size, expected / size, rtol=1e-4, atol=1e-5)


def test_jumps_and_neglected_harmonics_are_said(small_model):
    """Points of the rig scatter by a hundredth of what they do: harmonics are missed then."""
    hertz = HERTZ[3:6]
    size = small_model.amplitudes({MU: 0.2}, CURVE, hertz)
    sigma = np.full(len(size), 1e-4 * size.max())
    made = fit(
        lambda values: small_model.amplitudes({MU: values[0]}, CURVE, hertz),
        size,
        sigma,
        [FitParameter(MU, 0.21, 0.1, 1.0)],
    )
    exact = Measured("rig", hertz, size, sigma=sigma)
    said = list(remarks(small_model, [exact], made))
    (harmonics,) = (text for text in said if text.startswith("HARMONICS ARE TOO FEW"))
    assert "those above 1 change" in harmonics
    rough = replace(exact, sigma=np.full(len(size), size.max()))
    assert not [text for text in remarks(small_model, [rough], made) if text.startswith("HARM")]


def test_curves_of_the_study_s_engine_order_have_all_a_sigma_or_none():
    at = np.array([250.0, 255.0])
    curves = [Measured(name, at, at) for name in "ab"]
    known = replace(curves[0], name="known", sigma=at)
    other = Measured("other", at, at, engine_order=7)
    heard: list[Event] = []
    assert _usable(parse_study(""), [*curves, other], heard.append) == curves
    assert [event.text for event in heard if isinstance(event, Notice)] == [
        "other: engine order 7 is not the study's"
    ]
    with pytest.raises(InputError, match="^fit: b has no sigma while others have"):
        _usable(parse_study(""), [known, curves[1]], heard.append)
    with pytest.raises(InputError, match="no measured curve is of engine order 1$"):
        _usable(parse_study(""), [other], heard.append)
