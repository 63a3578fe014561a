"""Whatever computes asks `plan` for its steps: no command and no analysis has a way of its own."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.small_study import SMALL
from vanelock import (
    converge_study,
    fit_study,
    load_scene,
    load_study,
    optimise_study,
    run_scene,
    run_study,
)
from vanelock.analyses import ANALYSES
from vanelock.common.files.csv_table import write_columns
from vanelock.stages import plan as stage

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
FIT = """measured = [{ file = "rig.csv", sigma = 0.3 }]
fit = { parameters = ["joints.interlock.mu"], starts = 1 }
"""
OPTIMISE = 'optimise = { parameters = ["joints.interlock.mu"], starts = 1 }\n'
OF_A_KEY = {
    "scatter": '[scatter]\nsamples = 2\nkeys."joints.interlock.mu" = { uniform = [0.1, 0.2] }\n',
    "mistuning": "[mistuning]\nrings = 1\nkeys.joints.interlock.mu = 0.05\n",
    "wear": "joints.interlock.wear_coefficient = 1e-13\n[wear]\ndwells = [{ cycles = 1e6 }]\n",
    "campbell": "[campbell]\nspeeds = [0, 9000]\nengine_orders = [1]\n",
    "gauges": "[outputs]\ngauges = [{ aerofoil = 1, span = 0.1, chord = 0.5 }]\n",
    "bounds": "[bounds]\n",
    "stability": "[stability]\n",
    "settled": "[stability]\n[settled]\n",
    "damped_modes": "[damped_modes]\n",
}
"""Of analyses that a key asks for; the others are of each run."""


class Planned(Exception):
    """`plan` was asked."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every module that has `plan` is given one that raises."""

    def refuse(*_: Any, **__: Any) -> None:
        raise Planned

    plan = stage.plan
    for module in list(sys.modules.values()):
        ours = getattr(module, "__name__", "").startswith("vanelock")
        if ours and vars(module).get("plan") is plan:
            monkeypatch.setattr(module, "plan", refuse)


@pytest.mark.parametrize(
    ("command", "keys"),
    [
        (run_study, ""),
        (fit_study, FIT),
        (optimise_study, OPTIMISE),
        (converge_study, ""),
        *((run_study, OF_A_KEY.get(analysis.key, "")) for analysis in ANALYSES),
    ],
)
def test_every_command_and_analysis_asks_plan(
    command: Callable[..., Any],
    keys: str,
    asked: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = f"{SMALL}{keys}"
    (tmp_path / "study.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    curve = {"frequency (Hz)": np.arange(1.0, 5.0), "amplitude (um)": np.ones(4)}
    write_columns(tmp_path / "rig.csv", curve)
    with pytest.raises(Planned):
        command(load_study(tmp_path / "study.toml"), tmp_path / "run")


def test_scenes_ask_plan(asked: None, tmp_path: Path) -> None:
    with pytest.raises(Planned):
        run_scene(load_scene(EXAMPLES / "lap_joint" / "scene.toml"), tmp_path / "run")
