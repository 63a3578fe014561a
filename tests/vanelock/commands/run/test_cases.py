"""What a run keeps of a case that fails after some of it was computed."""

from types import SimpleNamespace
from typing import Any

from vanelock import parse_study
from vanelock.commands.run.cases import OngoingRun
from vanelock.input.cases.sweep import cases


def test_a_diagram_whose_case_fails_is_made_by_the_next_try(monkeypatch):
    """Which may be the same case's, or that of the next with the same lines."""
    place = "vanelock.commands.run.cases"
    monkeypatch.setattr(f"{place}.lines_step", lambda *_: SimpleNamespace(key="lines"))
    monkeypatch.setattr(f"{place}.campbell", lambda *_: "diagram")
    shown = SimpleNamespace(monitor=None)
    run: Any = SimpleNamespace(_lines=set(), stages=None, run=shown)
    planned: Any = SimpleNamespace(case=cases(parse_study("[campbell]"))[0])
    found: list[Any] = [OngoingRun._campbell(run, planned) for _ in range(2)]
    assert found == ["diagram", "diagram"]
