"""Loads and outputs far from contacts: no coordinates, and answers of the whole matrices."""

from pathlib import Path

import numpy as np

from tests.vanelock.scenes.conftest import Write, chain, joined
from vanelock import nonlinear

COUNT = 40
SPRINGS = (3e5, 2e5, 1e5)
SCENE = f"""
[contacts.pad]
between = ["bar", "ground"]
pairs = [1, 2]
normal = [1, 0, 0]
tangent = [0, 1, 0]
kn = 4e4
kt = 7e4
mu = 0.2
[[loads]]
component = "bar"
nodes = {[*range(20, 30)]}
direction = [3, 0, 4]
amplitude = 2
phase = 30
[outputs]
nodes = {{bar = [33, 2, 25]}}
"""


def test_vibration_is_that_of_the_whole(tmp_path: Path, scene_file: Write) -> None:
    """At the load's own nodes, too, up to the sixth mode."""
    bar = chain(1, COUNT, SPRINGS, ground=1.0)
    text = bar.write(tmp_path, "bar") + "accuracy = 1e-6\nband = 60\n" + SCENE
    system = joined(scene_file(text + "[damping]\nratio = 0.01\n"))
    K = bar.K.copy()
    K[:6, :6] += np.diag([4e4, 7e4, 7e4] * 2)
    load = np.zeros((COUNT, 3))
    load[19:29] = [1.2, 0, 1.6]
    omega2, V = np.linalg.eigh(bar.K / 0.1)
    C = 0.1 * (V * (0.02 * np.sqrt(omega2.clip(0)))) @ V.T
    for hertz in (3.0, 17.0, 45.0):
        s = 2 * np.pi * hertz
        D = K - s**2 * bar.M + 1j * s * C
        exact = np.linalg.solve(D, load.ravel()).reshape(COUNT, 3)[[32, 1, 24]]
        found = nonlinear.linear_response(system, [hertz]).amplitude[0]
        np.testing.assert_allclose(found, np.abs(exact), atol=2e-5 * np.abs(exact).max())


def test_what_needs_its_load_to_be_held_keeps_it(tmp_path: Path, scene_file: Write) -> None:
    """A node without mass that is loaded stays a coordinate, as all others do."""
    bar = chain(1, COUNT, SPRINGS, ground=1.0)
    bar.M[96:99] = 0  # node 33
    text = SCENE.replace(str([*range(20, 30)]), "[33]")
    system = joined(scene_file(bar.write(tmp_path, "bar") + "modes = 6\n" + text))
    assert len(system.at(0).K) == 3 * 3 + 6
