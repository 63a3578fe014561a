"""A run that is killed again and again ends at the bits of one that was not.

`kill -9` at moments of a fixed seed, in every stage, and while files are written; then the same
command, until it is done. Finished stages must not be computed again, files be whole at any moment,
and all datasets of results.h5 in the end be those of an uninterrupted run, times aside.
"""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import FULL
from tests.verification.kills import killing
from tests.verification.kills.killing import Moment, Victim

pytestmark = pytest.mark.system
SEED = 20
EACH = 5 if FULL else 1
"""Kills in each stage."""

SCENE = """
name = "kills"
mesh.size = "coarse"
excitation.force = 30
joints.interlock.mu = 0.15
response.harmonics = 1
[campbell]
engine_orders = [1]
[outputs]
gauges = [{ aerofoil = 2, span = 0.1, chord = 0.5, side = "suction", direction = "span" }]
"""
PLAIN = "show = []\n"
"""What the sample leaves out: pictures of shapes take half a run's time."""

STAGES = {
    "meshes": "mesh ", "fem": "fem ", "rom vane": "rom vane", "rom casing": "rom casing",
    "limits": "linear limits", "linear responses": "linear response", "gauges": "gauges",
    "preload": "preload", "responses": "response ", "campbell": "Campbell", "curves": "figures/",
    "shapes": "shapes/", "fatigue": "stress ", "report": "report",
}  # fmt: skip
"""Beginnings of the names of the stages that are hit, in the order in which they come."""

SAMPLE = ("meshes", "rom casing", "responses", "curves")
"""Those of the sample."""

WRITES = {
    "mesh entry": ("mesh ", "cache/.mesh*.tmp"), "rom entry": ("rom ", "cache/.rom*.tmp"),
    "points": ("response ", "cache/response*.points"),
    "response entry": ("response ", "cache/.response*.tmp"),
    "results.h5": ("", ".results.h5.*.tmp"), "results": ("", "results/.*.tmp"),
}  # fmt: skip


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scene's file."""
    path = tmp_path_factory.mktemp("kills") / "scene.toml"
    path.write_text(SCENE + ("" if FULL else PLAIN))
    return path


@pytest.fixture(scope="module")
def whole(study: Path) -> Path:
    """Folder of a run that was not killed."""
    folder = study.parent / "whole"
    found = killing.run(study, folder)
    assert found.status == 0, found.errors
    return folder


def test_killed_runs_end_at_the_bits_of_one_that_was_not(
    study: Path, whole: Path, record: Callable[[str, object], None]
) -> None:
    rng = np.random.default_rng(SEED)
    victim = Victim(study, study.parent / "killed")
    took = killing.seconds(whole)
    for name, prefix in STAGES.items():
        if not FULL and name not in SAMPLE:
            continue
        spans = [s for stage, s in took.items() if stage.startswith(prefix)]
        tries = 0
        while victim.hits[name] < EACH:
            after = float(rng.uniform(0, 0.8)) * max(spans)
            if not victim.kill(Moment(name, prefix, after)):
                victim.forget(prefix)
            tries += 1
            assert tries < 12 + 4 * EACH, f"{name}: {tries} kills did not hit it"
        record(name, victim.hits[name])
    victim.finish(whole)
    record("kills in all", victim.kills)
    record("seed", SEED)
    record("datasets and attributes compared", len(killing.numbers(whole / "results.h5")))


def test_killed_while_a_file_is_written(
    study: Path, whole: Path, record: Callable[[str, object], None]
) -> None:
    rng = np.random.default_rng(SEED + 1)
    victim = Victim(study, study.parent / "cut")
    if not FULL:  # the sample begins with the reduced parts
        kept = shutil.ignore_patterns("response*", "Campbell*", "pictures.json", "rom-vane*")
        shutil.copytree(whole / "cache", victim.folder / "cache", ignore=kept)
    wanted = WRITES if FULL else {name: WRITES[name] for name in ("rom entry", "points", "results")}
    for name, (stage, file) in wanted.items():
        tries = 0
        while victim.hits[name] < EACH and tries < 4 * EACH:
            if not victim.kill(Moment(name, stage, 0.0, file)) and stage:
                victim.forget(stage)
            tries += 1
            if name == "points" and tries % 2:
                victim.tear(rng)
        record(name, victim.hits[name])
        assert victim.hits[name] >= EACH
    victim.finish(whole)
    record("kills in all", victim.kills)
    record("seed", SEED + 1)
