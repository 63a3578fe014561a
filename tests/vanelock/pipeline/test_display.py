"""What a run says, as tables, lines and JSON, and what it leaves on the screen."""

import json
import os
import pty
import re
import subprocess
import sys
import textwrap
import time
from contextlib import suppress
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from rich.progress import Progress, TextColumn

from vanelock.common.tables import Column, Table
from vanelock.files import parse_study
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.display import PlainLines, _Bar, _width_of
from vanelock.pipeline.progress import (
    Begun,
    Done,
    Event,
    Failed,
    Finished,
    Notice,
    PointDone,
    Tasks,
    Trial,
    _json_lines,
)
from vanelock.pipeline.text_table import _digits, text_lines, wrapped
from vanelock.results.listing import _response_table, stage_times
from vanelock.stages.cost_estimate import Clock
from vanelock.stages.plan import plan
from vanelock.stages.response.summary import Peak, Summary

ANSWER = Table(
    "Responses", (Column("case"), Column("peak", "µm")), [("mu=0.3", 4e-5)], ("warning: w",)
)
EVENTS: list[Event] = [
    Notice("about 2 min"),
    Begun("mesh vane"),
    Done("mesh vane", 1.25, False),
    Done("rom vane", 9.0, True),
    Begun("response mu=0.3"),
    PointDone("mu=0.3", 3, 9, 4e-5, 75.0),
    Done("response mu=0.3", 3.5, False),
    Failed("mu=0.5", "too much", 2),
    Table("FAILED cases", (Column("case"),), [("mu=0.5",)], key="failed"),
    ANSWER,
    *(Done(f"{kind} mu=0.3", 0.6, False) for kind in ("stress", "check")),
    *(Done(f"figures/{i}.png", 0.5, False) for i in range(30)),
    Table("Stages", (Column("stage"),), [("meshes",)], key="stages"),
    Finished("runs/a", 21.0, {}, "runs/a/report.html", 3.14e9),
]


LAST = "done in 21.0 s, at most 3.1 GB of memory: pictures 15.0 s, responses 3.5 s, meshes 1.2 s"


def test_plain_lines_say_each_thing_once_and_a_file_has_no_width_unless_asked_for(
    capsys, monkeypatch
):
    lines = PlainLines()
    for event in EVENTS:
        lines(event)
    heard = capsys.readouterr()
    stages = ["mesh vane: 1.2 s", "rom vane: unchanged", "response mu=0.3: 3.5 s"]
    failed = "FAILED mu=0.5: too much (tried 2 times)"
    last = [LAST, "open runs/a/report.html"]
    assert heard.err.splitlines() == ["note: about 2 min", *stages, failed, *last]
    shown = [line.strip() for line in heard.out.splitlines() if "─" not in line]
    assert shown == ["", "Responses", "peak", "case    [um]", "mu=0.3    40", "warning: w"]
    monkeypatch.delenv("COLUMNS", raising=False)
    assert _width_of(StringIO()) == 1000
    monkeypatch.setenv("COLUMNS", "72")
    assert _width_of(StringIO()) == 72


SHOW = """
from tests.vanelock.pipeline.test_display import EVENTS
from vanelock.pipeline.progress import choose_listener
with choose_listener(False, False) as listener:
    for event in EVENTS:
        listener(event)
"""


def test_a_terminal_is_left_with_the_answer():
    """On a real terminal, whose screen is made of what was written there."""
    width, (mine, theirs) = 72, pty.openpty()
    environment = {**os.environ, "COLUMNS": str(width), "TERM": "xterm", "PYTHONPATH": "."}
    command = [sys.executable, "-c", SHOW]
    done = subprocess.Popen(command, stdout=theirs, stderr=theirs, env=environment)
    os.close(theirs)
    written = b""
    with suppress(OSError):  # the other end is closed
        while chunk := os.read(mine, 65536):
            written += chunk
    assert done.wait() == 0
    os.close(mine)
    lines = screen(written.decode())
    assert max(map(len, lines)) <= width
    failed = ["FAILED mu=0.5: too much (tried 2 times)", "FAILED cases", " case", " mu=0.5"]
    answer = ["Responses", "         peak", " case    [um]", " mu=0.3    40", "warning: w"]
    first, *more = textwrap.wrap(LAST, width - 2)
    assert [line for line in lines if line and "─" not in line] == [
        "note: about 2 min",
        *failed,
        *answer,
        *[first, *(f"  {line}" for line in more)],
        "open runs/a/report.html",
    ]


def test_a_stage_without_points_is_named_while_it_lasts(capsys):
    """Until it is done."""
    lines = PlainLines()
    lines.interval = 0.02
    lines(Begun("component bar"))
    heard = ""
    while heard.count("so far") < 2:
        heard += capsys.readouterr().err
    lines(Done("component bar", 1.0, False))
    assert heard.startswith("  component bar: 0 s so far\n")
    capsys.readouterr()
    time.sleep(0.1)
    assert "so far" not in capsys.readouterr().err


def screen(written: str) -> list[str]:
    """Lines of a terminal that knows carriage returns, line feeds, cursor up and erase line."""
    lines, row, column = [""], 0, 0
    for sequence, text in re.findall(r"(\x1b\[[0-9;?]*[A-Za-z])|([^\x1b])", written):
        if sequence.endswith("A"):
            row -= int(sequence[2:-1] or 1)
        elif sequence == "\x1b[2K":
            lines[row] = ""
        elif text == "\n":
            row += 1
            lines += [""] * (row + 1 - len(lines))
        elif text == "\r":
            column = 0
        elif text:
            lines[row] = lines[row].ljust(column)[:column] + text + lines[row][column + 1 :]
            column += 1
    return [line.rstrip() for line in lines]


def test_a_kind_of_stage_has_one_bar():
    bar, shown = bars()
    for event in EVENTS[:-1]:
        bar(event)
    assert {task.description: task.fields["said"] for task in shown.tasks} == {
        "meshes": "1 in 1.2 s",
        "reduced models": "1 unchanged",
        "responses": "1 in 3.5 s",
        "stresses": "1 in 0.6 s",
        "checks": "1 in 0.6 s",
        "pictures": "30 in 15.0 s",
    }
    bar(Tasks(3, 16, 1, 4e-5, 75.0))
    (cases,) = [task for task in shown.tasks if task.description == "cases"]
    assert (cases.completed, cases.total) == (3, 16)
    assert cases.fields["said"] == "3 of 16 cases, 1 FAILED, largest peak 40.0 um, 1:15 left"


def bars() -> tuple[_Bar, Progress]:
    shown = Progress(TextColumn("{task.fields[said]}"), console=Console(file=StringIO()))
    return _Bar(shown), shown


def test_a_fit_says_its_responses(capsys, monkeypatch):
    """One at once on a terminal, now and then elsewhere."""
    lines = PlainLines()
    monkeypatch.setattr(lines, "interval", 0.0)
    trial = Trial(7, 1.25, 1.125, "standard deviations", 22, 75.0)
    lines(trial)
    said = "response 7 of about 22, misfit 1.25 standard deviations, least so far 1.12, 1:15 left"
    assert capsys.readouterr().err == f"  {said}\n"
    bar, shown = bars()
    bar(trial)
    bar(Begun("fit"))
    bar(trial)
    assert [task.fields["said"] for task in shown.tasks] == [said]


FOUND = 3, 6.309e-5, 252.021, 0.4752, 8e-4, "63/63"
CASES = Table(
    "Responses of a very long name of an output node, circumferential",
    (
        Column("case"),
        Column("H", minor=True),
        Column("peak", "µm"),
        Column("at", "Hz", ".6g"),
        Column("relative to free"),
        Column("dissipated", "µJ", note="dissipated: by friction in a cycle, of one sector"),
        Column("converged", minor=True),
    ),
    [
        (f"mu={mu},interference={i}um,engine_order={order}", *FOUND)
        for mu in ("0.15", "0.3")
        for i in (4, 17)
        for order in (1, 3)
    ],
    ("warning: a part is held by no closed contact at rest; where it lies is not determined",),
)


def test_a_table_stands_under_its_heads_and_units():
    columns = (Column("joint"), Column("n", "N", ".2f"), Column("safety factor", form=".1f"))
    table = Table("A title", columns, (("hook", 280.126, None),), ("a note [µm]",))
    assert text_lines(table) == [
        "",
        "A title",
        "             n  safety",
        " joint     [N]  factor",
        " ─────────────────────",
        " hook   280.13       -",
        "a note [um]",
    ]


@pytest.mark.parametrize("width", [40, 60, 80, 100, 140, 200])
def test_lines_fit_and_words_are_whole(width):
    lines = text_lines(CASES, width)
    assert max(map(len, lines)) <= width
    whole = {
        word for line in text_lines(CASES) for part in line.split() for word in part.split(",")
    }
    for line in lines:
        for part in line.split():
            assert set(part.split(",")) <= whole | {"─" * len(part)}
    # Every number that is not minor is there for each of the eight cases.
    text = "\n".join(lines)
    for number in ("63.09", "252.021", "0.4752", "800"):
        assert text.count(number) == 8


def test_folded_rows_begin_with_their_names_and_long_reasons_are_on_several_lines():
    columns = Column("a"), *(Column(f"number {i}") for i in range(6))
    table = Table("T", columns, [("row", *[12345.0] * 6)])
    lines = text_lines(table, 30)
    assert sum(line.startswith(" row ") for line in lines) == 3
    assert max(map(len, lines)) <= 30
    why = "the mesh of the vane cannot be made: " + "its sides cross; " * 9
    columns = Column("case"), Column("tried"), Column("why")
    table = Table("FAILED cases", columns, [("mu=0.3", 2, why)])
    lines = text_lines(table, 60)
    assert max(map(len, lines)) <= 60
    assert sum("its sides" in line for line in lines) >= 3
    assert len([line for line in lines if line.startswith(" mu=0.3")]) == 1


def test_lines_break_after_commas_and_spaces_alone_and_no_rows_leave_heads():
    assert wrapped("mu=0.15,interference=4um", 10) == ["mu=0.15,", "interference=4um"]
    assert wrapped("", 10) == [""]
    table = Table("Inputs that differ", [Column("key"), Column("value")], [])
    assert text_lines(table, 80)[:3] == ["", "Inputs that differ", " key  value"]


def test_a_column_has_the_same_decimals():
    plain = Column("peak", "µm")
    assert _digits(plain, [132.8, 6.3, None, 0.0]) == ["132.8", "6.3", "-", "0.0"]
    assert _digits(plain, [257.4, 1.437]) == ["257.40", "1.44"]
    assert _digits(Column("mu", form=".3g"), [0.3, 0.15]) == ["0.30", "0.15"]
    assert _digits(Column("f", form=".6g"), [1319.0, 1348.55]) == ["1319.00", "1348.55"]
    # One that would be left with a single digit keeps its own.
    assert _digits(plain, [132.8, 0.0123]) == ["132.8", "0.0123"]
    assert _digits(plain, [9.99999, 1.5]) == ["10.0", "1.5"]
    assert _digits(Column("error", form=".0e"), [6e-7, np.nan]) == ["6e-07", "nan"]


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
