"""Elements with laws of their own in a scene: beside the contact that a stop is, and mistakes."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.vanelock.scenes.conftest import Write, chain
from vanelock import check_file, load_scene, run_scene
from vanelock.common.errors import InputError
from vanelock.nonlinear import ELEMENT
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


def test_a_stop_is_the_contact_that_it_is(tmp_path: Path, scene_file: Write) -> None:
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
