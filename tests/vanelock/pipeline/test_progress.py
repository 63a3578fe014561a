"""What a run says: tables, lines and JSON."""

import json

import numpy as np
import pytest

from vanelock.files import parse_study
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.display import PlainLines
from vanelock.pipeline.progress import Done, Finished, PointDone, Tasks, _json_lines
from vanelock.results.listing import _response_table, stage_times
from vanelock.stages.cost_estimate import Clock
from vanelock.stages.plan import plan
from vanelock.stages.response.summary import Peak, Summary


def summary(**changed):
    values = dict(
        case="mu=0.3", values={}, harmonics=3, mu=0.3, peak=Peak(4, 252.5, 4.5e-5, False),
        of_free=0.34, of_stuck=0.19, position=0.09, slipping=1.0, opening=0.9, closed_slipping=0.0,
        friction_share=1.0, work={"interlock": 2e-6}, loose=False, converged=10, points=10,
        worst=0.0, seconds=1.5,
    )  # fmt: skip
    return Summary(**{**values, **changed})


@pytest.mark.parametrize("peaks", [10, 30, 41])
def test_of_many_cases_the_table_has_each_once(peaks):
    tops = [Peak(4, 252.5, 1e-6 * i, False) if i < peaks else None for i in range(60)]
    found = _response_table([summary(case=f"mu={i}", peak=top) for i, top in enumerate(tops)], "x")
    names = [row[0] for row in found.rows]
    assert len(names) == len(set(names)) == min(peaks, 40)
    assert names[:10] == [f"mu={i}" for i in range(10)]
    assert names[-1] == f"mu={peaks - 1}"


def test_response_table_says_what_did_not_converge():
    lost = summary(case="lost", peak=None, converged=8, worst=3e-4, of_free=float("nan"))
    edge = summary(case="edge", peak=Peak(0, 240.0, 1e-5, True))
    table = _response_table([summary(), lost, edge], "vane output 1, radial")
    whole, lost, _ = table.record()["rows"]
    assert (whole["peak_um"], whole["slipping_percent"]) == (45, 100)
    assert (lost["peak_um"], lost["of_free"], lost["converged"]) == (None, None, "8/10")
    notes = "\n".join(table.notes)
    assert "warning: lost: 2 of 10 points DID NOT CONVERGE (largest residual 3.0e-04)" in notes
    assert "edge: the largest point is at the end of the frequency range" in notes
    assert "mu=0.3" not in notes


def test_stage_times_add_up():
    done = [
        Done("mesh vane", 2.0, True),
        Done("response mu=0.1", 3.0, False),
        Done("response mu=0.2", 4.0, False),
        Done("figures/response.png", 0.5, False),
        Done("shapes/mode.png", 1.0, True),
    ]
    rows = {row["stage"]: row for row in stage_times(done).record()["rows"]}
    assert set(rows) == {"meshes", "responses", "pictures", "total"}
    assert rows["responses"]["count"] == 2
    assert rows["responses"]["seconds_now"] == 7
    assert (rows["pictures"]["computed"], rows["pictures"]["seconds"]) == (1, 1.5)
    assert (rows["total"]["seconds_now"], rows["total"]["seconds"]) == (7.5, 10.5)


def test_json_is_one_valid_object_a_line(capsys):
    _json_lines(Done("mesh", 1.5, False))
    cases = [{"x": np.nan, "y": float("inf"), "z": (1, 2.5)}]
    _json_lines(Finished("runs/a", 2.0, {"cases": cases}))
    done, finished = map(json.loads, capsys.readouterr().out.splitlines())
    assert done == {"event": "done", "stage": "mesh", "seconds": 1.5, "cached": False}
    assert finished["page"] == ""
    assert finished["summary"] == {"cases": [{"x": None, "y": None, "z": [1, 2.5]}]}


def test_no_time_left_is_shown_where_nobody_knows_it(monkeypatch, capsys):
    text = "accuracy = 0.05\n[response]\nrange = [1, 2]"
    planned = plan(cases(parse_study(text)), lambda *_: None)
    clock = Clock(planned)
    clock.begin(planned[0])
    point = clock.point(16, 16, 256.0, 3e-6)
    assert point.total is None
    assert np.isnan(point.left)
    searching = clock.point(16, 17, 257.125, float("nan"))
    assert searching.peak == 3e-6
    lines = PlainLines()
    lines.interval = 0.0
    lines(point)
    lines(searching)
    lines(PointDone("b", 3, 9, 1e-6, 75.0))
    lines(Tasks(16, 16, 0, 0.0, float("nan")))
    assert capsys.readouterr().err.splitlines() == [
        "  nominal: point 16, peak 3.0 um",
        "  nominal: point 16, peak 3.0 um, looking for 257.12 Hz by longer ways",
        "  b: point 3/9, peak 1.0 um, 1:15 left",
        "  16 of 16 cases",
    ]
