"""Where nothing can be drawn a message says so, instead of a crash."""

import os
import sys

import pytest

from vanelock.common.errors import InputError
from vanelock.render.scenes import offscreen


@pytest.fixture
def unknown():
    """Forget what was found out about this machine, before and after."""
    offscreen.trial.cache_clear()
    yield
    offscreen.trial.cache_clear()


def test_this_machine_draws_and_a_trial_that_crashes_or_errs_does_not_count(unknown):
    assert offscreen.missing(["libc.so.6", "libNoSuchThing.so.1"]) == ["libNoSuchThing.so.1"]
    assert offscreen.render_window() in ("vtkEGLRenderWindow", "")
    crash = "import ctypes; ctypes.string_at(0)"  # a segmentation fault, as VTK's
    assert offscreen.draws("", "pass")
    assert not offscreen.draws("", crash)
    blue = offscreen._PROBE.replace("SetBackground(1.0, 0.0, 0.0)", "SetBackground(0.0, 0.0, 1.0)")
    assert offscreen.draws(offscreen.render_window())
    assert not offscreen.draws(offscreen.render_window(), blue)


@pytest.mark.parametrize(
    ("name", "value"),
    [("missing", lambda libraries: list(libraries)), ("draws", lambda window: False)],
)
def test_the_message_says_what_to_install(unknown, monkeypatch, name, value):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(offscreen, name, value)
    with pytest.raises(InputError) as raised:
        offscreen.pyvista()
    message = str(raised.value)
    assert "apt-get install libgl1 libegl1 libgl1-mesa-dri" in message
    assert "\n" not in message


def test_one_library_of_the_two_is_worth_a_trial(unknown, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(offscreen, "missing", lambda libraries: ["libGL.so.1"])
    monkeypatch.setattr(offscreen, "draws", lambda window: window == "vtkEGLRenderWindow")
    assert offscreen.render_window() == "vtkEGLRenderWindow"


def test_the_environment_is_put_back(monkeypatch):
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "mine")
    with offscreen.selected():
        inside = os.environ.get("VTK_DEFAULT_OPENGL_WINDOW")
    assert inside == (offscreen.render_window() or "mine")
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "mine"
