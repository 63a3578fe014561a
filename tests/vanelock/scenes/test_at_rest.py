"""What cannot lie at rest is refused by a check, and by a run before anything is reduced."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from tests.vanelock.scenes.conftest import Write, chain, joined
from vanelock import load_scene, run_scene
from vanelock.commands.check.file import check_file
from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble
from vanelock.mesh import Part
from vanelock.nonlinear import static_response

MU, WIDTH = 0.3, 0.1


@pytest.fixture
def block(lattice: Callable[..., Part], tmp_path: Path, scene_file: Write):
    """Scene of a free block on the ground's four contacts below its corners, and a load on top."""
    part = lattice((2, 2, 2), lambda p: p * WIDTH, "hexahedron")
    model = assemble(part, Material(E=70e9, nu=0.3, rho=2700))
    for name, A in (("K", model.K), ("M", model.M)):
        sp.save_npz(tmp_path / f"{name}.npz", sp.csc_array(A))
    lines = [f"{i},{x},{y},{z}" for i, (x, y, z) in enumerate(part.points, 1)]
    (tmp_path / "nodes.csv").write_text("\n".join(["node,x,y,z", *lines]) + "\n")

    def node(*place: float) -> int:
        return 1 + int(np.linalg.norm(part.points - place, axis=1).argmin())

    corners = [node(x, y, 0) for x in (0, WIDTH) for y in (0, WIDTH)]

    def write(force: tuple[float, float, float]) -> Path:
        return scene_file(
            '[components.block]\nstiffness = "K.npz"\nmass = "M.npz"\nnodes = "nodes.csv"\n'
            f'[contacts.floor]\nbetween = ["block", "ground"]\npairs = {corners}\n'
            f"normal = [0, 0, -1]\nkn = 1e7\nkt = 1e7\nmu = {MU}\n"
            f'[[loads]]\ncomponent = "block"\nnodes = [{node(WIDTH / 2, WIDTH / 2, WIDTH)}]\n'
            f"direction = {list(force)}\namplitude = {np.linalg.norm(force)}\nharmonic = 0\n"
            f'[[loads]]\ncomponent = "block"\nnodes = [{node(0, 0, WIDTH)}]\n'
            "direction = [1, 0, 0]\namplitude = 1e-3\n"
            "[outputs]\nloops = false\nreport = false\n"
        )

    return write


def test_a_block_rests_as_long_as_friction_holds_it(block) -> None:
    """Pushed sideways by T under N it slides where T > μN; the static state agrees."""
    held = block((0.99 * MU * 100, 0, -100))
    assert "warning" not in {row[0] for row in check_file(held).rows}
    assert static_response(joined(held)).converged.all()
    with pytest.raises(InputError, match=r"components\.block: held by contacts alone, whose"):
        check_file(block((1.01 * MU * 100, 0, -100)))


def test_a_block_tips_over(block) -> None:
    """Pushed at its top by T under N at its middle it tips where T > N/2, if friction lets it."""
    path = block((51, 0, -100))
    path.write_text(path.read_text().replace(f"mu = {MU}", "mu = 0.6"))
    with pytest.raises(InputError, match="cannot balance the static load"):
        check_file(path)
    path.write_text(path.read_text().replace("[51, 0", "[49, 0"))
    check_file(path)


def test_a_run_is_refused_before_anything_is_reduced(block, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="pushes the part away from them"):
        run_scene(load_scene(block((0, 0, 1))), tmp_path / "run")
    stages = {path.name.partition("-")[0] for path in (tmp_path / "run" / "cache").rglob("*")}
    assert not any("component" in stage for stage in stages)


def test_what_nothing_presses_is_reported(tmp_path: Path, scene_file: Write) -> None:
    """An interference alone pushes a free part away and leaves it."""
    text = chain(1, 3, (3e5, 2e5, 1e5)).write(tmp_path, "one") + (
        '[contacts.pad]\nbetween = ["one", "ground"]\npairs = [3]\nnormal = [0, 0, 1]\nkn = 1e4\n'
        "kt = 1e4\nmu = 0.3\ninterference = 1e-6\n"
        '[[loads]]\ncomponent = "one"\nnodes = [1]\ndirection = [0, 0, 1]\namplitude = 1\n'
    )
    rows = check_file(scene_file(text)).rows
    assert ("warning", LOOSE) in rows
    pressed = text + text[text.index("[[loads]]") :] + "harmonic = 0\n"
    assert "warning" not in {row[0] for row in check_file(scene_file(pressed)).rows}


LOOSE = "components.one: held by contacts alone, which nothing presses: at rest it may lie anywhere"


def test_ties_carry_what_holds_a_part(tmp_path: Path, scene_file: Write) -> None:
    """A free part that is tied to a clamped one moves no contact by itself."""
    springs = (3e5, 2e5, 1e5)
    text = chain(1, 3, springs, ground=1.0).write(tmp_path, "one")
    text += chain(11, 3, springs).write(tmp_path, "two") + (
        '[ties.glue]\nbetween = ["one", "two"]\npairs = [[3, 11]]\n'
        '[contacts.pad]\nbetween = ["two", "ground"]\npairs = [13]\nnormal = [0, 0, 1]\nkn = 1e4\n'
        "kt = 1e4\nmu = 0.3\n"
        '[[loads]]\ncomponent = "two"\nnodes = [13]\ndirection = [0, 0, -1]\namplitude = 1\n'
        "harmonic = 0\n"
        '[[loads]]\ncomponent = "two"\nnodes = [13]\ndirection = [0, 0, 1]\namplitude = 1\n'
    )
    assert "warning" not in {row[0] for row in check_file(scene_file(text)).rows}


def test_an_inner_row_without_stiffness_is_refused(tmp_path: Path, scene_file: Write) -> None:
    one = chain(1, 6, (3e5, 2e5, 1e5))
    one.K[4] = one.K[:, 4] = 0
    text = one.write(tmp_path, "one") + (
        '[[loads]]\ncomponent = "one"\nnodes = [1]\ndirection = [0, 0, 1]\namplitude = 1\n'
    )
    with pytest.raises(InputError, match=r"components\.one: node 2, y: held by nothing"):
        check_file(scene_file(text))
