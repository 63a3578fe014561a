"""Runs that a signal or a lost output ends: exit status, one line, and no unfinished files."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import pytest

from tests.small_study import SMALL
from tests.vanelock.scenes.test_run import PAD, QUIET, arm
from vanelock import open_results
from vanelock.common.files.hdf5 import written
from vanelock.common.process import Stopped, held, raise_dropped, raised
from vanelock.pipeline import progress

pytestmark = pytest.mark.usefixtures("undrawn")

VANELOCK = [sys.executable, "-m", "vanelock"]
RUN = ("run", "a.toml", "--json", "--workers", "1")

STUDY = f"""{SMALL}
response = {{ frequencies = [252, 256], harmonics = 1 }}
outputs = {{ show = [] }}
"""
GOES_ON = (
    "vanelock: stopped; finished work is kept in runs/a, and the same command goes on from there\n"
)
# The command, which sends itself a signal as soon as it prints that a stage begins, or is done.
STOPPED = """
import os, sys
from vanelock import __main__ as command
from vanelock.pipeline import progress

json_lines, (event, stage, number, *arguments) = progress._json_lines, sys.argv[1:]

def printed(said):
    json_lines(said)
    if type(said).__name__ == event and said.stage == stage:
        os.kill(os.getpid(), int(number))

progress._json_lines = printed
command.main(arguments)
"""


def started(program, *arguments, **options):
    command = [*program, *map(str, arguments)]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.run(command, text=True, check=False, timeout=1800, **options)


def stopped(folder, stage, number, event="Begun"):
    """Run until a stage begins or is done, then send a signal: status and standard error."""
    done = started([sys.executable, "-c", STOPPED], event, stage, int(number), *RUN, cwd=folder)
    return done.returncode, done.stderr


def unfinished(folder):
    return [str(path) for path in Path(folder).rglob("*.tmp")]


def write_scene(folder):
    sweep = '[sweep]\n"contacts.pad.mu" = [0.15, 0.3]\n'
    (folder / "a.toml").write_text(arm(folder) + PAD + QUIET + sweep)


@pytest.fixture
def stopped_here(called, monkeypatch):
    """Function that runs the command in this process and sends it a signal at a stage."""

    def call(number, event, stage):
        def printed(said):
            json_lines(said)
            if type(said).__name__ == event and said.stage == stage:
                os.kill(os.getpid(), number)

        json_lines = progress._json_lines
        with monkeypatch.context() as patched:
            patched.setattr(progress, "_json_lines", printed)
            return called(*RUN)

    return call


def test_an_interrupted_run_keeps_what_was_finished_and_goes_on(tmp_path, called, stopped_here):
    write_scene(tmp_path)
    results = tmp_path / "runs" / "a" / "results.h5"
    moments = {
        signal.SIGHUP: ("Begun", "response mu=0.3"),
        signal.SIGINT: ("Begun", "response mu=0.3"),
        signal.SIGTERM: ("Done", "figures/response.png"),
    }
    for number, (event, stage) in moments.items():
        status, _, said = stopped_here(number, event, stage)
        assert (status, said) == (128 + number, GOES_ON)
        assert not unfinished(tmp_path)
        with open_results(results) as file:
            found = {"free", "stuck", "mu=0.15"} | ({"mu=0.3"} if event == "Done" else set())
            assert set(file["response"]) == found
            assert not file.attrs["complete"]

    status, out, said = called(*RUN)
    assert (status, said) == (0, "")
    events = [json.loads(line) for line in out.splitlines()]
    computed = {e["stage"] for e in events if e["event"] == "done" and not e["cached"]}
    assert {stage for stage in computed if not stage.startswith("figures/")} <= {"preload"}
    summary = events[-1]["summary"]
    assert [case["case"] for case in summary["cases"]] == ["mu=0.15", "mu=0.3"]
    with h5py.File(results) as file:
        assert file.attrs["complete"]
        assert set(file["response"]) == {"free", "stuck", "mu=0.15", "mu=0.3"}
        peaks = [file[f"response/mu={mu}"].attrs["peak_amplitude"] for mu in (0.15, 0.3)]
    assert peaks == [case["peak"]["amplitude"] for case in summary["cases"]]

    assert called("run", "a.toml", "--quiet") == (0, "", "")
    status, out, said = called("run", "a.toml")
    assert status == 0
    assert "Response" in out
    assert "response mu=0.3: unchanged" in said
    assert "\x1b" not in out + said


@pytest.mark.system
def test_a_stopped_process_leaves_no_unfinished_file(tmp_path):
    """At moments of which gmsh, at the signals itself, has just ended the first."""
    (tmp_path / "a.toml").write_text(STUDY)
    moments = {
        signal.SIGTERM: ("Done", "mesh vane"),
        signal.SIGHUP: ("Begun", "response nominal"),
        signal.SIGINT: ("Done", "figures/response.png"),
    }
    for number, (event, stage) in moments.items():
        assert stopped(tmp_path, stage, number, event) == (128 + number, GOES_ON)
        assert not unfinished(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_waits_until_a_file_is_whole(tmp_path, number):
    def write():
        with raised(), held(), written(tmp_path / "a.h5") as file:
            os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)
            file["x"] = [1.0, 2.0]

    with pytest.raises(Stopped) as caught:
        write()
    assert caught.value.status == 128 + number
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["x"][1] == 2


class Killing:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)


def dropped_by_a_library():
    with suppress(BaseException):
        os.kill(os.getpid(), signal.SIGTERM)


@pytest.mark.parametrize("drop", [Killing, dropped_by_a_library])
def test_a_signal_that_is_dropped_is_raised_again(drop):
    """A moment later, if Python drops it; at the next step; at the end of the command."""
    later = [] if drop is dropped_by_a_library else [lambda: time.sleep(60)]
    for step in (raise_dropped, *later, None):
        went_on: list[Any] = []

        def work(step=step, went_on=went_on):
            with raised():
                drop()
                if step is not None:
                    step()
                    went_on.append(step)

        with pytest.raises(Stopped) as caught:
            work()
        assert caught.value.status == 143
        assert not went_on


def test_what_is_ignored_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with raised():
            os.kill(os.getpid(), signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def check(folder, *arguments, **options):
    (folder / "a.toml").write_text(STUDY)
    return started(VANELOCK, "check", "a.toml", *arguments, cwd=folder, **options)


@pytest.mark.system
def test_output_that_nobody_reads_ends_it_quietly(tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    done = check(tmp_path, stdout=writing)
    assert (done.returncode, done.stderr) == (141, "")
    assert started(VANELOCK, "--help", cwd=tmp_path, stdout=writing).returncode == 141
    os.close(writing)


@pytest.mark.system
def test_output_that_cannot_be_written_is_one_line(tmp_path):
    with open("/dev/full", "w") as full:
        done = check(tmp_path, stdout=full)
        assert (done.returncode, done.stderr) == (
            2,
            "vanelock: standard output: cannot be written: No space left on device\n",
        )
        done = started(VANELOCK, "check", "none.toml", cwd=tmp_path, stderr=full)
        assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.system
def test_streams_that_are_closed_are_done_without(tmp_path):
    expected = check(tmp_path)
    assert expected.returncode == 0
    closed = ["bash", "-c", 'exec "$@" 2>&-', "bash", *VANELOCK]
    done = started(closed, "check", "a.toml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, expected.stdout)
    closed[2] = 'exec "$@" >&-'
    done = started(closed, "check", "a.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, expected.stderr)
