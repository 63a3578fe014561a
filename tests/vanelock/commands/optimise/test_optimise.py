"""`vanelock optimise` of a small study: against a map of peaks, and what it leaves behind."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.small_study import SMALL
from vanelock import load_study, optimise_study, parse_study
from vanelock.commands.fit.refit_model import rejoined
from vanelock.commands.optimise.front import notes
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import Options, peak_response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Event, Trial
from vanelock.pipeline.step import Stages

MU, FORCE = "joints.interlock.mu", "excitation.force"
NEAR = (240.0, 290.0)
STUDY = f"""
name = "rig"
{SMALL}
{FORCE} = 3.0
{MU} = 0.4  # a guess
joints.interlock.wear_coefficient = 1e-13
[response]
harmonics = 1
range = {list(NEAR)}
[optimise]
parameters = ["{MU}"]
starts = 2
"""


def test_the_optimum_is_that_of_a_map(small_model, tmp_path, monkeypatch):
    """A grid of friction, each its highest peak: none is lower, and the lowest is next to it."""
    monkeypatch.setattr("vanelock.commands.optimise.optimise.FRONT_POINTS", 3)
    text = STUDY + 'of = "peak and wear"\n'
    folder = tmp_path / "run"
    heard: list[Event] = []
    found = optimise_study(parse_study(text), folder, heard.append, text, tmp_path)
    assert found.settled
    assert not any(found.held)
    assert found.after < 0.9 * found.before
    tried = [each for each in heard if isinstance(each, Trial)]
    tried = [each for each in tried if each.name == "largest peak"][:-2]  # the front's starts
    assert len(tried) == found.trials + 2  # starts, with one harmonic
    assert found.trials < 20
    assert tried[-1].least == pytest.approx(1e6 * found.after)
    table, front = [each for each in heard if isinstance(each, Table)]
    assert table.rows[0][0] == "interlock.mu"
    assert len(front.rows) == len(found.front)
    model = small_model
    system = model.system({FORCE: 3.0})
    output = system.output_names[model.monitor.node], model.monitor.component
    interlock = np.array(system.contacts.joint) == "interlock"
    grid = found.value[0] * 1.1 ** np.arange(-2, 3)
    least = peak_response(system, "mu", grid, NEAR, Options(1), output, joint=interlock)
    assert least.converged.all()
    assert int(np.argmin(least.amplitude)) == 2
    assert found.after == pytest.approx(least.amplitude[2], rel=1e-6)
    assert found.after < (1 + 1e-3) * least.amplitude.min()
    values = np.array([each.value[0] for each in found.front])
    every = np.sort(np.unique([*values, *np.geomspace(0.04, 4, 8)]))
    along = peak_response(system, "mu", every, NEAR, Options(1), output, joint=interlock)
    work = along.response.dissipation[:, interlock].sum(axis=1)
    wear = 1e-13 * work / along.parameter * along.frequency
    assert len(values) > 1
    for point in found.front:
        at = int(np.argmin(np.abs(every - point.value[0])))
        assert point.peak == pytest.approx(along.amplitude[at], rel=1e-5)
        assert point.wear == pytest.approx(wear[at], rel=1e-3)
        less = (along.amplitude < 0.999 * point.peak) & (wear < 0.99 * point.wear)
        assert not less[along.converged].any()
    again = load_study(folder / "optimised.toml", outside=True)
    assert again.joints.interlock.mu == pytest.approx(found.value[0], rel=1e-5)
    assert "# a guess" in (folder / "optimised.toml").read_text()
    written = json.loads((folder / "optimise.json").read_text())
    assert written["largest_peak"] == found.after
    assert [each["largest_peak"] for each in written["front"]] == [p.peak for p in found.front]
    bound = np.array([found.parameters[0].low])
    said = notes(replace(found, value=bound, settled=False))
    assert any("LIES ON A BOUND" in text for text in said)
    assert any("NOT SETTLED" in text for text in said)


def test_what_cannot_be_varied_is_one_line(tmp_path):
    for text, expected in (
        ('parameters = ["damping.ratio"]', '"damping.ratio" cannot be optimised; what can: joints'),
        ('of = "peak and wear"', 'peak and wear": no joint wears: give one of joints.hook'),
        ("[sweep]\njoints.interlock.mu = [0.1, 0.2]", "joints.interlock.mu is swept, too"),
    ):
        with pytest.raises(InputError, match=expected):
            optimise_study(parse_study(f"[optimise]\n{text}"), tmp_path / "none")


def test_a_range_without_a_peak_is_refused(tmp_path):
    text = STUDY.replace(str([*NEAR]), "[200.0, 210.0]")
    with pytest.raises(InputError, match="no peak lies in the range"):
        optimise_study(parse_study(text), tmp_path)


def test_each_case_of_a_sweep_has_an_optimum(tmp_path):
    text = STUDY.replace("starts = 2", "starts = 0") + "[sweep]\nexcitation.force = [6.0, 3.0]\n"
    heard: list[Event] = []
    found = optimise_study(parse_study(text), tmp_path, heard.append, text)
    first, *_, both = [each for each in heard if isinstance(each, Table)]
    assert "force=6" in first.title
    assert [row[0] for row in both.rows] == ["force=6N", "force=3N"]
    written = json.loads((tmp_path / "optimise.json").read_text())
    sizes = [each["largest_peak"] for each in written["cases"]]
    assert found.after == written["largest_peak"] == min(sizes) == sizes[1]
    assert sizes[0] == pytest.approx(2 * sizes[1], rel=0.2)  # friction follows the load
    again = load_study(tmp_path / "optimised.toml", outside=True)
    assert again.excitation.force == 3.0
    assert not again.sweep
    assert again.joints.interlock.mu == pytest.approx(found.value[0], rel=1e-5)


def test_the_mesh_correction_is_that_of_the_optimum_s_joints(small_model, tmp_path):
    """What a mesh adds to the stiffness depends on that of contacts."""
    kt = "joints.interlock.kt"
    text = STUDY.replace("starts = 2", "starts = 0").replace(f'["{MU}"]', f'["{kt}"]')
    text = text.replace("290.0]", "310.0]")
    found = optimise_study(parse_study(text), tmp_path, text=text)
    assert found.settled
    stages = Stages(Cache(tmp_path / "cache", print), lambda event: None)
    own = rejoined(load_study(tmp_path / "optimised.toml", outside=True), stages)
    sizes = []
    for model, reach, count in ((own, 0.2, 41), (small_model, 1.0, 101)):
        hertz = found.frequencies[0] + np.linspace(-reach, reach, count)
        values = {FORCE: 3.0, MU: 0.4, kt: float(found.value[0])}
        sizes.append(model.monitor.amplitude(model.solved(values, hertz).response).max())
    assert found.after == pytest.approx(sizes[0], rel=1e-4)
    assert abs(sizes[1] / sizes[0] - 1) > 3e-4


def test_the_least_upper_bound_is_that_of_a_map(small_model, tmp_path):
    """Bounds at less and at more friction are higher: there are two peaks, which cross."""
    text = STUDY.replace("starts = 2", 'starts = 0\nof = "upper bound"')
    near = 246.0, 282.0
    text = text.replace(str([*NEAR]), str([*near])).replace(f"{MU} = 0.4", f"{MU} = 0.2")
    study = parse_study(text + "[bounds]\nstarts = 0\nshare = 0.2\n")
    found = optimise_study(study, tmp_path)
    assert found.settled
    assert found.of == "upper bound"
    assert any("static friction" in text for text in notes(found))
    assert found.after < 0.98 * found.before
    assert study.bounds is not None
    for factor in (0.8, 1.0, 1.25):
        values = {FORCE: 3.0, MU: factor * float(found.value[0])}
        bound = small_model.bounds(values, near, study.bounds).amplitude[2]
        if factor == 1.0:
            assert bound == pytest.approx(found.after, rel=1e-6)
        else:
            assert bound > 1.03 * found.after
