"""Scenes at rest and free ones: what cannot lie still is refused, what floats is solved."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from tests.vanelock.scenes.conftest import chain, joined, load, refused_by, write_model
from vanelock import load_scene, run_scene
from vanelock.commands.check.file import check_file
from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble
from vanelock.nonlinear import static_response
from vanelock.stages.response.limits import limits

MU, WIDTH = 0.3, 0.1
SPRINGS = (3e5, 2e5, 1e5)
PAD = (
    '[contacts.pad]\nbetween = ["{}", "ground"]\npairs = [{}]\nnormal = [0, 0, 1]\nkn = 1e4\n'
    "kt = 1e4\nmu = 0.3\n"
)


@pytest.fixture
def block(lattice, tmp_path, scene_file):
    """Scene of a free block on the ground's four contacts below its corners, and a load on top."""
    part = lattice((2, 2, 2), lambda p: p * WIDTH, "hexahedron")
    text = write_model(tmp_path, assemble(part, Material(E=70e9, nu=0.3, rho=2700)), "block")

    def node(*place: float) -> int:
        return 1 + int(np.linalg.norm(part.points - place, axis=1).argmin())

    corners = [node(x, y, 0) for x in (0, WIDTH) for y in (0, WIDTH)]

    def write(force: tuple[float, float, float]) -> Path:
        top, size = node(WIDTH / 2, WIDTH / 2, WIDTH), float(np.linalg.norm(force))
        return scene_file(
            f'{text}[contacts.floor]\nbetween = ["block", "ground"]\npairs = {corners}\n'
            f"normal = [0, 0, -1]\nkn = 1e7\nkt = 1e7\nmu = {MU}\n"
            + load("block", top, str([*force]), size, "harmonic = 0\n")
            + load("block", node(0, 0, WIDTH), "[1, 0, 0]", 1e-3)
            + "[outputs]\nshow = []\n"
        )

    return write


def test_a_block_rests_as_long_as_friction_holds_it_and_it_does_not_tip_over(block):
    """It slides where T > μN, pushed under N at its middle, and tips where T > N/2."""
    held = block((0.99 * MU * 100, 0, -100))
    assert "warning" not in {row[0] for row in check_file(held).rows}
    assert static_response(joined(held)).converged.all()
    with pytest.raises(InputError, match=r"components\.block: held by contacts alone, whose"):
        check_file(block((1.01 * MU * 100, 0, -100)))
    path = block((51, 0, -100))
    path.write_text(path.read_text().replace(f"mu = {MU}", "mu = 0.6"))
    with pytest.raises(InputError, match="cannot balance the static load"):
        check_file(path)
    path.write_text(path.read_text().replace("[51, 0", "[49, 0"))
    check_file(path)


def test_what_nothing_presses_is_reported_but_not_what_ties_hold(tmp_path, scene_file):
    """An interference alone pushes a free part away; one tied to a clamped one moves no contact."""
    pad = PAD.format("one", 3) + "interference = 1e-6\n"
    text = chain(1, 3, SPRINGS).write(tmp_path, "one") + pad + load("one", 1, "[0, 0, 1]")
    assert ("warning", LOOSE) in check_file(scene_file(text)).rows
    pressed = text + load("one", 1, "[0, 0, 1]", 1, "harmonic = 0\n")
    assert "warning" not in {row[0] for row in check_file(scene_file(pressed)).rows}
    text = chain(1, 3, SPRINGS, ground=1.0).write(tmp_path, "one")
    text += chain(11, 3, SPRINGS).write(tmp_path, "two") + PAD.format("two", 13)
    text += '[ties.glue]\nbetween = ["one", "two"]\npairs = [[3, 11]]\n'
    text += load("two", 13, "[0, 0, -1]", 1, "harmonic = 0\n") + load("two", 13, "[0, 0, 1]")
    assert "warning" not in {row[0] for row in check_file(scene_file(text)).rows}


LOOSE = "components.one: held by contacts alone, which nothing presses: at rest it may lie anywhere"


def test_an_inner_row_without_stiffness_is_refused(tmp_path, scene_file):
    """Node 2 of nodes 1 to 6, 6 of them kept, is counted among all rows."""
    one = chain(1, 6, SPRINGS)
    one.K[4] = one.K[:, 4] = 0
    path = scene_file(one.write(tmp_path, "one") + load("one", 1, "[0, 0, 1]"))
    refused_by(check_file, path, r"components\.one: node 2, y: held by nothing")
    refused_by(joined, path, "can still move although .*most at node 2, y")


STEEL = Material(E=210e9, nu=0.3, rho=7800)


@pytest.fixture
def beam(lattice, tmp_path):
    """A free beam of 0.3 x 0.02 x 0.01 m, its matrices, and its component in a scene file."""
    model = assemble(lattice((15, 2, 1), lambda p: p * [0.3, 0.02, 0.01], "hexahedron"), STEEL)
    return model, write_model(tmp_path, model, "beam")


def pushed(node: int, harmonic: int, direction: str) -> str:
    return load("beam", node, direction, 1, f"harmonic = {harmonic}\n")


def test_modes_are_counted_from_the_first_that_vibrates(beam, scene_file):
    model, text = beam
    text += pushed(1, 1, "[0, 0, 1]")
    found = limits(joined(scene_file(text)), 1)
    values = sp.linalg.eigsh(model.K, 8, model.M, sigma=-1e5)[0]
    exact = np.sqrt(np.sort(values)[6]) / (2 * np.pi)
    assert found.stuck_mode == 6
    assert found.stuck_frequency == pytest.approx(exact, rel=1e-4)
    assert found.free_frequency == found.stuck_frequency


@pytest.mark.parametrize("second", ["[0, 0, -1]", "[0, 0, 1]"])
def test_loads_at_rest_that_do_not_balance_are_reported(beam, tmp_path, scene_file, second):
    _, text = beam
    text += pushed(1, 1, "[0, 0, 1]") + pushed(2, 0, "[0, 0, 1]") + pushed(2, 0, second)
    text += "[outputs]\nshow = []\n[response]\npoints = 3\n"
    (summary,) = run_scene(load_scene(scene_file(text)), tmp_path / "run")
    warned = [line for line in summary.warnings if "do not balance each other" in line]
    assert len(warned) == (second == "[0, 0, 1]")
