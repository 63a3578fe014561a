"""The animation of a loop: where its point and its bounds are at each step."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL.GifImagePlugin import GifImageFile

from vanelock.common.errors import InputError
from vanelock.render import loop_animation
from vanelock.render.plots.contacts import loops, tracing

STEPS = 48
TIME = 2 * np.pi * np.arange(STEPS) / STEPS
MU = 0.3


@pytest.fixture
def contact():
    """A contact that slides all the time, its normal force 10 + 4 sin: friction on its bounds."""
    n = 10 + 4 * np.sin(2 * TIME)
    u = 20e-6 * np.cos(TIME)
    t = np.where(np.sin(TIME) > 0, -MU * n, MU * n)
    zero = np.zeros(STEPS)
    return np.column_stack([1e-6 * n, zero, u]), np.column_stack([n, zero, t])


def test_the_point_and_the_bounds_are_those_of_the_instant(contact):
    u, f = contact
    found = loops.period(u, f, MU)
    loop, normal, friction = Figure().subplots(1, 3)
    tracer = tracing.LoopTracer(found, loop, normal, friction)
    for step in (0, 5, 30, 47):
        tracer.place(step)
        at = [np.asarray(point.get_xydata(), float)[0] for point in tracer.points]
        np.testing.assert_allclose(at[0], [1e6 * u[step, 2], f[step, 2]])
        np.testing.assert_allclose(at[1], [step / STEPS, f[step, 0]])
        np.testing.assert_allclose(at[2], [step / STEPS, f[step, 2]])
        levels = [np.asarray(line.get_xydata(), float)[0, 1] for line in tracer.bounds]
        np.testing.assert_allclose(levels, [MU * f[step, 0], -MU * f[step, 0]])
        assert len(tracer.trace.get_segments()) == step
        if step:
            ends = np.array(tracer.trace.get_segments())[:, 1]
            np.testing.assert_allclose(ends[-1], at[0])


def test_the_file_holds_the_period(contact, tmp_path):
    path = loop_animation(tmp_path / "loop.gif", *contact, MU, "Contact 1", "μ = 0.3", frames=12)
    with GifImageFile(path) as file:
        assert (file.n_frames, file.info["loop"]) == (12, 0)
        frames = []
        for k in range(12):
            file.seek(k)
            frames.append(np.asarray(file.convert("RGB"), int))
    assert all(np.any(a != b) for a, b in pairwise(frames))
    # The point is where the axes put it: right of the middle at first; half a period later
    # the trace has come to the left end.
    red = [(np.abs(f - [213, 94, 0]).sum(axis=2) < 60)[150:490, 90:460] for f in frames]
    first = [np.nonzero(r)[1].min() for r in red]
    assert first[0] > 250
    assert first[6] < 100


def test_arrays_that_do_not_fit_are_refused(contact, tmp_path):
    with pytest.raises(InputError, match=r"loop: displacement of shape \(47, 3\)"):
        loop_animation(tmp_path / "loop.gif", contact[0][1:], contact[1], MU, "Contact 1")
