"""Every command and every worker takes the steps of a case from one plan."""

import pytest

from tests.small_study import SMALL
from vanelock import parse_study, run_study
from vanelock.commands.converge.converge import converge_study
from vanelock.commands.fit.fit import fit_study
from vanelock.commands.optimise.optimise import optimise_study
from vanelock.commands.run.graph import CaseWork
from vanelock.input.cases.sweep import cases

TEXT = f"""{SMALL}
[optimise]
parameters = ["joints.interlock.kn"]
[fit]
parameters = ["joints.interlock.mu"]
[[measured]]
file = "measured.csv"
"""


class Planless(Exception):
    """There is no plan."""


def no_plan(*_):
    raise Planless


@pytest.mark.parametrize("command", [run_study, fit_study, optimise_study, converge_study])
def test_no_command_goes_without_the_plan(command, tmp_path, monkeypatch):
    (tmp_path / "measured.csv").write_text("frequency (Hz),amplitude (um)\n255,8\n258,9\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vanelock.stages.plan._planned", no_plan)
    with pytest.raises(Planless):
        command(parse_study(TEXT), tmp_path / "run")


def test_no_worker_goes_without_the_plan(monkeypatch):
    monkeypatch.setattr("vanelock.stages.plan._planned", no_plan)
    with pytest.raises(Planless):
        CaseWork(cases(parse_study(TEXT))[0]).steps()
