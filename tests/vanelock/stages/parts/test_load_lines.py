"""What excites a case, in words: resultants by hand."""

import numpy as np

from vanelock.files import load_study
from vanelock.input.schema.scene import LoadKeys, Scene
from vanelock.rom.joining.connections import Load
from vanelock.stages.matrices.gather import Gathered
from vanelock.stages.matrices.piece import NodalForces
from vanelock.stages.parts.loads import load_lines


def test_forces_on_nodes_are_summed_over_nodes_and_segments(tmp_path):
    """1.5 kN on each of 40 nodes of 16 segments are 960 kN."""
    file = tmp_path / "study.toml"
    file.write_text("[ring]\nsectors = 16\n[excitation]\nforce = 1500\n")
    (line,) = load_lines(load_study(file), 40)
    assert line == (
        "excitation: 1,500 N on each of 40 nodes, 60,000 N together, 960,000 N around the ring, "
        "radial"
    )
    assert not list(load_lines(load_study(file), None))


def test_directions_are_shown_at_length_one():
    loads = [
        {"component": "a", "nodes": [1, 2], "direction": [0, 3, 4], "amplitude": 5},
        {"component": "a", "nodes": [3], "direction": [1, 0, 0], "amplitude": 2},
        {"component": "a", "file": "gas.csv", "scale": 2.0},
    ]
    given = Scene.model_construct(loads=tuple(LoadKeys.model_validate(each) for each in loads))
    acting = [Load(f"loads[{i}]", "a", np.arange(2 - i), np.zeros(3, complex), 1) for i in (0, 1)]
    forces = np.array([[1.0, 2.0, 0.0], [0.5, -2.0, 0.0]])
    gas = NodalForces("loads[2]", "a", "", np.array([8, 9]), forces, 2.0, 0)
    lists = Gathered((), (), tuple(acting), (gas,), (), ())
    assert list(load_lines(given, None, lists)) == [
        "loads[0]: 5 N on each of 2 nodes, 10 N together, along [0, 0.6, 0.8], "
        "the direction [0, 3, 4] at length 1",
        "loads[1]: 2 N on 1 node, along [1, 0, 0]",
        "loads[2]: forces on 2 nodes, sum [3, 0, 0] N",
    ]
