"""Damped modes, flutter and wear over cycles of a study: what its files and its page have."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.golden.runs import GoldenRun
from tests.vanelock.stages.conftest import planned_of
from vanelock import load_system, nonlinear, open_results, parse_study
from vanelock.analyses.damped_modes import FollowedMode
from vanelock.analyses.solved_case import with_analyses
from vanelock.analyses.wear import WornCase
from vanelock.common.errors import InputError
from vanelock.pipeline.progress import Begun, PointDone

N, HOUR = 8, 3600.0


@pytest.fixture
def run(golden: Callable[[str], GoldenRun]) -> tuple[Path, Any, list[Any]]:
    """Folder, summary and events of the run with every analysis."""
    made = golden("everything")
    (found,) = made.summaries
    return made.folder, found, made.events


def test_modes_are_those_of_the_library(run: tuple[Path, Any, list[Any]]) -> None:
    folder, _, events = run
    with h5py.File(folder / "results.h5") as file:
        system = nonlinear.System.load(file["response/nominal/system"])
        group = file["response/nominal/damped_modes"]
        forward, backward = (FollowedMode.load(group[f"mode_2_nd_{k}"]) for k in (1, -1))
    mode, driven = forward.mode, forward.driven
    assert mode is not None
    assert driven is not None
    assert not mode.ended
    again = nonlinear.damped_mode(system, 2, None, nonlinear.Options(1), 1)
    np.testing.assert_allclose(mode.damping_ratio, again.damping_ratio, rtol=1e-9)
    # A wave that turns the other way is as stiff and as damped, and the air drives one of the two.
    assert backward.mode is not None
    np.testing.assert_allclose(backward.mode.linear, mode.linear, rtol=1e-6)
    air = {k: -2e3 + k * 8e4 * np.sin(2 * np.pi / N) for k in (1, -1)}  # Im A, by hand
    omega = 2 * np.pi * mode.linear[0]
    for k, each in ((1, forward), (-1, backward)):
        assert each.driven is not None
        assert each.driven.aerodynamic_damping == pytest.approx(-air[k] / (2 * omega**2), rel=1e-6)
    rows = {each.key: each.record()["rows"] for each in events if hasattr(each, "columns")}
    assert [row["rest"] for row in rows["flutter"]] == ["grows", "decays"]
    assert rows["damped_modes"][0]["rest_hz"] == mode.linear[0]
    (line,) = (line for line in run[1].warnings if "FLUTTERS" in line)
    assert "mode 2 of nodal diameter 1" in line
    steps = [each for each in events if isinstance(each, Begun | PointDone)]
    begun = steps.index(next(each for each in steps if "damped mode" in str(each)))
    assert isinstance(steps[begun + 1], PointDone)


def test_worn_joints_vibrate_as_the_history_says(run: tuple[Path, Any, list[Any]]) -> None:
    folder, found, events = run
    with h5py.File(folder / "results.h5") as file:
        system = nonlinear.System.load(file["response/nominal/system"])
        history = WornCase.load(file["response/nominal/wear"]).history
        answers = dict(file["response/nominal/answers"].attrs)
    assert history is not None
    assert history.status == "cycles done"
    assert history.cycles[-1] == 3e6
    assert history.amplitude[0] == pytest.approx(found.peak.amplitude, rel=5e-3)
    hook = np.array(system.contacts.joints) == "hook"
    lost = history.interference[0] - history.interference[-1]
    assert (lost[hook] == 0).all()
    assert (lost[~hook] > 0).any()
    # The end, solved afresh: its joints as worn, under the load of its dwell.
    worn = history.system_at(system, -1)
    np.testing.assert_allclose(worn.force[1].vector, 1.2 * system.force[1].vector)
    afresh = nonlinear.frequency_response(worn, history.frequency[-1:], nonlinear.Options(1))
    node = system.output_names.index(history.output)
    size = afresh.amplitude[0, node, history.direction]
    assert size == pytest.approx(history.amplitude[-1], rel=1e-6)
    # What is worn at first is what the page says of the peak by itself.
    written = (folder / "figures" / "wear_nominal.csv").read_text().splitlines()
    lines = [line.split(",") for line in written if not line.startswith("#")]
    depth = next(i for i, head in enumerate(lines[0]) if head.startswith("worn depth"))
    hour = HOUR * history.frequency[0] * history.rate[0].max()
    assert max(float(line[depth] or 0) for line in lines[1:]) == pytest.approx(1e6 * hour, rel=2e-2)
    assert answers["goodman_reserve_worn"] < answers["goodman_reserve"]
    last = nonlinear.audit_response(worn, history.response.at([-1]), samples=1 << 12)
    assert last.residual[0] < 1e-3
    rows = {each.key: each.record()["rows"] for each in events if hasattr(each, "columns")}
    assert rows["wear"][-1]["amplitude_um"] == pytest.approx(1e6 * history.amplitude[-1])
    page = (folder / "report.html").read_text("utf-8")
    for text in ("Damped modes", "Flutter", "Wear over cycles", "3e+06 cycles of wear", "worn"):
        assert text in page, text
    for name in ("damped_modes", "wear_over_cycles"):
        assert (folder / "figures" / f"{name}_nominal.png").exists()
        assert (folder / "figures" / f"{name}_nominal.csv").exists()


def test_modes_take_the_harmonics_of_the_peak_where_an_accuracy_chooses(
    golden: Callable[[str], GoldenRun], monkeypatch: pytest.MonkeyPatch
) -> None:
    run, taken = golden("accuracy"), []

    def followed(
        system: Any, number: int, given: None, options: nonlinear.Options, k: int, **_: Any
    ) -> None:
        taken.append(options.harmonics)
        raise InputError("enough")

    monkeypatch.setattr(nonlinear, "damped_mode", followed)
    planned = planned_of(f"{run.text}\n[response]\nharmonics = 9\n[damped_modes]\n")
    with_mode = with_analyses(planned, planned)
    (step,) = with_mode.analyses["damped_modes"]
    assert planned.response in step.needs
    with open_results(run.folder / "results.h5") as file:
        response = nonlinear.Response.load(file["response/nominal"])
    system = load_system(run.folder / "results.h5", "nominal")
    known = {
        planned.response.key: response,
        planned.system.key: system,
        planned.linear.system.key: system,
        planned.linear.responses["free"].key: response,
        planned.structure.whole.key: system,
    }
    monkeypatch.setattr(type(planned), "solved", lambda self, response: self)
    assert step.compute(lambda step: known[step.key]).reason == "enough"
    assert response.estimates is not None
    peak = np.argmin(np.abs(response.frequency - run.summaries[0].peak.frequency))
    assert taken == [response.estimates.harmonics[peak]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[wear]\ndwells = [{ cycles = 1 }]", "wear: no joint wears"),
        ("[wear]\n", "wear.dwells"),
        (
            "[joints.hook]\nwear_coefficient = 1e-14\n[wear]\n"
            "dwells = [{ cycles = 1, frequency = [2, 1] }]",
            r"dwells\[0\]\.frequency = \[2, 1\]: must be \[low, high\] with low < high",
        ),
        ("[damped_modes]\nnodal_diameters = [5]", "allowed are -4 to 4"),
        ("[damped_modes]\nmodes = [1, 1]", "must differ"),
        ("[damped_modes]\ninfluence = [[1, 0, 0], [-7, 0, 0]]", "one is given twice"),
        ('[damped_modes]\n[response]\ncoupling = "uncoupled"', 'must be "coupled"'),
    ],
)
def test_what_cannot_be_is_refused(text: str, message: str) -> None:
    study = "[ring]\nsectors = 8\n" + text
    with pytest.raises(Exception, match=message):
        parse_study(study)
