"""Elements with laws of their own, and a stop swept up and down."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.nonlinear.forced_response.test_hysteresis import DAMPING, FORCE, HIGH, LOW, closed_folds
from tests.vanelock.scenes.conftest import Chain, chain
from vanelock import check_file, load_scene, run_scene
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import ELEMENT, Response
from vanelock.nonlinear.fourier import TURN
from vanelock.pipeline.progress import Event
from vanelock.rom import System

CHAIN = chain(1, 3, (3e5, 2e5, 1e5), ground=1.0)
LOAD = '[[loads]]\ncomponent = "one"\nnodes = [2]\ndirection = [1, 0, 0]\namplitude = 1\n'
RUN = (
    "[response]\nmode = 1\nharmonics = 3\npoints = 9\n[damping]\nratio = 0.01\n"
    "[outputs]\nshow = ['report']\n"
)
CONTACT = (
    '[contacts.stop]\nbetween = ["one", "ground"]\npairs = [3]\nnormal = [1, 0, 0]\nkn = 4e4\n'
    "kt = 1.0\nmu = 0\ninterference = -1e-5\n"
)
ELEMENT_TABLE = (
    '[elements.stop]\nbetween = ["one", "ground"]\npairs = [3]\ndirection = [2, 0, 0]\n'
    'law = "stop"\nparameters = [4e4, 1e-5]\n'
)


def test_a_stop_is_the_contact_that_it_is(tmp_path, scene_file):
    found = {}
    for name, table in ("contact", CONTACT), ("element", ELEMENT_TABLE):
        path = scene_file(CHAIN.write(tmp_path, "one") + table + LOAD + RUN)
        (found[name],) = run_scene(load_scene(path), tmp_path / name)
    peak, other = found["element"].peak, found["contact"].peak
    assert peak is not None
    assert other is not None
    # The contact has springs across its normal, too, which move nothing here.
    assert peak.amplitude == pytest.approx(other.amplitude, rel=2e-4)
    assert peak.frequency == pytest.approx(other.frequency, rel=2e-4)
    with h5py.File(tmp_path / "element" / "results.h5") as file:
        assert np.all(file["response/nominal/state"][()] == ELEMENT)
        read = System.load(file["response/nominal/system"])
    (element,) = read.contacts.elements.values()
    assert (element.force, element.name) == ("stop", "stop")
    np.testing.assert_array_equal(element.parameters, [4e4, 1e-5])
    assert (tmp_path / "element" / "report.html").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"stop"\nparam', '"quintic"\nparam', r"elements\.stop\.law"),
        ("[4e4, 1e-5]", "[4e4]", r"elements\.stop: parameters = \[40000\.0\]: stop needs k"),
        ("[2, 0, 0]", "[0, 0, 0]", r"elements\.stop\.direction: must not be zero"),
        ("[3]", "[99]", r"components\.one: node 99 is not among the matrices' nodes"),
        ("[elements.stop]", "[bounds]\n[elements.stop]", r"elements: \[bounds\] is of contacts"),
        ('["one", "ground"]', '["ground", "one"]', r"elements\.stop\.between"),
    ],
)
def test_mistakes_name_their_key(tmp_path, scene_file, old, new, message):
    table = ELEMENT_TABLE.replace(old, new)
    path = scene_file(CHAIN.write(tmp_path, "one") + table + LOAD + RUN)
    with pytest.raises(InputError, match=message):
        check_file(path)


SCENE = """
{mass}
[contacts.stop]
between = ["mass", "ground"]
pairs = [1]
normal = [1, 0, 0]
tangent = [0, 1, 0]
kn = "1 N/m"
kt = "1 N/m"
mu = 0
interference = "-1 m"
[[loads]]
component = "mass"
nodes = [1]
direction = [1, 0, 0]
amplitude = {force}
[damping]
joints = "stuck"
ratio = {ratio}
[response]
direction = "{direction}"
harmonics = 1
range = [{low}, {high}]
"""


def run(folder: Path, direction: str) -> tuple[Path, list[str], str]:
    """A run: its folder, the notes under its table, and its page."""
    folder.mkdir()
    mass = Chain(np.diag([1.0, 50.0, 50.0]), np.eye(3), np.array([1])).write(folder, "mass")
    ratio = DAMPING / (2 * np.sqrt(2))  # of the mass on both springs
    text = SCENE.format(
        mass=mass, force=FORCE, ratio=ratio, direction=direction, low=LOW / TURN, high=HIGH / TURN
    )
    (folder / "scene.toml").write_text(text)
    heard: list[Event] = []
    run_scene(load_scene(folder / "scene.toml"), folder / "run", heard.append, text)
    (table,) = (each for each in heard if isinstance(each, Table) and each.key == "cases")
    return folder / "run", list(table.notes), (folder / "run" / "report.html").read_text()


def test_both_directions_and_their_jumps_are_reported_everywhere(tmp_path):
    (upper, _), (lower, _) = closed_folds()
    folder, notes, page = run(tmp_path / "both", "both")
    with h5py.File(folder / "results.h5") as file:
        case = file["response/nominal"]
        responses = {r.direction: r for r in map(Response.load, (case, case["lower"]))}
        assert Response.load(case).direction == "up"  # it hardens
        jumps = {"up": case["jumps"][()], "down": case["lower/jumps"][()]}
        assert case.attrs["peak_amplitude"] == responses["up"].amplitude[:, 0, 0].max()
    assert responses["up"].amplitude.max() > 1.5 * responses["down"].amplitude.max()
    for direction, fold in (("up", upper), ("down", lower)):
        ((before, after, *heights),) = jumps[direction]
        assert min(before, after) <= fold / TURN <= max(before, after)
        found = responses[direction]
        (pair,) = np.asarray(found.jump)
        assert heights == found.amplitude[pair, 0, 0].tolist()
    words = " ".join(notes)
    assert "sweeping up JUMPS from" in words
    assert "sweeping down JUMPS from" in words
    assert "the peak is that of the sweep up; sweeping down reaches" in words
    assert "sweeping up JUMPS from" in page
    table = (folder / "figures" / "response.csv").read_text()
    for direction in ("up", "down"):
        assert f'"with friction, sweeping {direction}, H = ' in table
        assert f"with friction, sweeping {direction}" in page


@pytest.mark.parametrize("direction", ["up", "down"])
def test_one_direction_says_that_others_were_not_looked_for(tmp_path, direction):
    folder, notes, _ = run(tmp_path / "one", direction)
    with h5py.File(folder / "results.h5") as file:
        assert Response.load(file["response/nominal"]).direction == direction
        assert "lower" not in file["response/nominal"]
        assert len(file["response/nominal/jumps"]) == 1
    words = " ".join(notes)
    assert f"sweeping {direction} JUMPS from" in words
    assert 'not looked for, and may reach higher: response.direction = "both"' in words
