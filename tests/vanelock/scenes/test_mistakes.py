"""What a scene's author gets wrong, and what cannot lie at rest: refused, or warned of."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from tests.vanelock.scenes.conftest import (
    Chain,
    Write,
    chain,
    joined,
    load,
    planar,
    refused_by,
    write_model,
)
from vanelock import check_file, load_scene, run_scene
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.fem import Material, assemble
from vanelock.nonlinear import static_response
from vanelock.pipeline.progress import Event, Notice
from vanelock.rom import linear_modes
from vanelock.stages.response.limits import limits

SPRINGS = (3e5, 2e5, 1e5)
LAP = (
    '[contacts.lap]\nbetween = ["one", "two"]\npairs = {pairs}\nnormal = [1, 0, 0]\nkn = 4e4\n'
    "kt = 7e4\nmu = 0.2\n"
)
LOAD = load("one", 2, "[0, 1, 1]")
QUIET = "[response]\nmode = 1\nharmonics = 1\nfrequencies = [40, 60]\n[outputs]\nshow = []\n"


def two(folder: Path, ground: float = 1.0) -> str:
    """Two chains of three nodes, the second held or not."""
    one, other = chain(1, 3, SPRINGS, ground=1.0), chain(11, 3, SPRINGS, ground=ground)
    return one.write(folder, "one") + other.write(folder, "two")


def notices_and_notes(path: Path) -> tuple[list[str], list[str]]:
    heard: list[Event] = []
    run_scene(load_scene(path), path.parent / "run", heard.append)
    notices = [event.text for event in heard if isinstance(event, Notice)]
    return notices, [n for event in heard if isinstance(event, Table) for n in event.notes]


TIE = '[ties.t]\nbetween = ["one", "two"]\npairs = {pairs}\n'
ORDER = "[excitation]\nengine_order = 3\n"
TOUCHING = LAP.format(pairs="[[3, 11]]")


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (LAP.format(pairs="[[3, 11], [3, 11]]"), r"lap\.pairs: pair 3, 11 is listed twice"),
        (TOUCHING + TIE.format(pairs="[[3, 11]]"), r"contacts\.lap: nodes 3 and 11 are one: "),
        (LAP.format(pairs="[[3, 3]]").replace('"two"', '"one"'), r"nodes 3 and 3 are one"),
        (LAP.format(pairs='"wild.csv"'), r"interference = 30 in .*wild\.csv: must be >= -1 and <="),
        (TIE.format(pairs='"wild.csv"'), r"column 'interference': a tie has node and mate only"),
        (LOAD + "harmonic = 4\n", r"loads\[1\]\.harmonic: given 4: must be <= response\.harm.*, 3"),
        (ORDER, r"excitation\.engine_order: needs ring\.sectors of at least 2"),
        (TOUCHING + '[sweep]\n"contacts.lag.mu" = [0.1]\n', r"no contacts\.lag; there are lap"),
    ],
)
def test_it_is_refused(tmp_path, scene_file, extra, message):
    (tmp_path / "wild.csv").write_text("node,mate,interference\n3,11,30\n")
    with pytest.raises(InputError, match=message):
        run_scene(load_scene(scene_file(two(tmp_path) + LOAD + extra)), tmp_path / "run")


def heads(scene_file: Write, text: str) -> list[str]:
    path = scene_file(text)
    with pytest.raises(InputError) as caught:
        load_scene(path)
    lines = [line.removeprefix(f"{path}: ") for line in str(caught.value).splitlines()]
    return [line.partition(": ")[0] for line in lines]


def test_what_contradicts_comes_before_what_is_swept(tmp_path, scene_file):
    wrong = two(tmp_path) + "modes = -1\n" + LAP.format(pairs='"../elsewhere.csv"')
    assert heads(scene_file, wrong) == [
        'contacts.lap.pairs = "../elsewhere.csv"',
        "components.two.modes = -1",
    ]
    contrary = two(tmp_path) + LOAD + "harmonic = 4\n" + TOUCHING + ORDER
    assert heads(scene_file, contrary) == ["loads[0].harmonic", "excitation.engine_order"]
    swept = '[sweep]\n"contacts.lap.mu" = [-0.1, 0.2, 0.2]\n"contacts.lag.mu" = [0.1]\n'
    assert heads(scene_file, two(tmp_path) + LOAD + TOUCHING + swept) == [
        'sweep."contacts.lap.mu"[0] = -0.1',
        'sweep."contacts.lap.mu"[2] = 0.2',
        'sweep."contacts.lag.mu"[0] = 0.1',
    ]


def test_a_missing_file_is_named_and_a_part_that_nothing_joins_reported(tmp_path, scene_file):
    path = scene_file(two(tmp_path) + LOAD)
    (tmp_path / "two_M.mtx").unlink()
    refused_by(joined, path, r"components\.two\.mass: .*two_M\.mtx")
    notices, _ = notices_and_notes(scene_file(two(tmp_path) + LOAD + QUIET))
    assert "components.two: no contact or tie joins it to another component" in notices


def test_a_direction_without_a_row_is_refused_for_a_load_and_reported_for_a_normal(
    tmp_path, scene_file
):
    text = planar(tmp_path)
    refused_by(
        joined, scene_file(text + LOAD), r"loads\[0\]\.direction: node 2 .* no y displacement"
    )
    pad = LAP.replace("two", "ground").replace("[1, 0, 0]", "[0, 1, 0]").format(pairs="[3]")
    text += LOAD.replace("[0, 1, 1]", "[1, 0, 0]") + pad + 'interference = "20 um"\n'
    notices, _ = notices_and_notes(scene_file(text + QUIET))
    assert "lap: nothing moves along the normal of 1 of its contacts" in "\n".join(notices)


def test_a_loose_part_has_no_answer(tmp_path, scene_file):
    """Left lying anywhere, or pushed away by a static load."""
    text = two(tmp_path, ground=0.0) + LOAD.replace("[0, 1, 1]", "[1, 1, 0]")
    text += TOUCHING + 'interference = "-30 um"\n'
    notices, notes = notices_and_notes(scene_file(text + QUIET.replace(", 60", "")))
    assert any("two: held by contacts alone, which nothing presses" in note for note in notices)
    assert any("NOT DETERMINED" in note for note in notes)
    assert any("the state at rest DID NOT CONVERGE" in note for note in notes)


def test_a_tied_rotation_that_the_part_does_not_resist(tmp_path, scene_file):
    """A rotation with neither stiffness nor mass of its own, held by what it is tied to."""
    text = ""
    for name, twist in (("one", 0.0), ("two", 50.0)):
        part = chain(1, 60, SPRINGS, ground=1.0)
        K, M = np.zeros((181, 181)), np.zeros((181, 181))
        K[:180, :180], M[:180, :180], K[180, 180] = part.K, part.M, twist
        text += Chain(K, M, np.arange(1, 2)).write(tmp_path, name) + "accuracy = 1e-4\n"
        rows = [f"{n},{d}" for n in part.nodes for d in "xyz"] + ["60,rx"]
        (tmp_path / f"{name}_dofs.csv").write_text("\n".join(["node,direction", *rows]) + "\n")
    text += '[ties.t]\nbetween = ["one", "two"]\npairs = [[60, 60]]\n' + LOAD
    frequency, _ = linear_modes(joined(scene_file(text)), 0, 6)
    assert np.isfinite(frequency).all()


@pytest.mark.parametrize("keys", ["modes = 5\n", "accuracy = 1e-3\n", "cutoff = 3000\n"])
def test_a_mass_matrix_is_one(tmp_path, scene_file, keys):
    one = chain(1, 30, SPRINGS, ground=1.0)
    text = one.write(tmp_path, "one") + keys + LOAD + QUIET
    one.M[44, 44] *= -1  # node 15, along z
    one.write(tmp_path, "one")
    refused_by(joined, scene_file(text), r"node 15, direction z: the mass on the diagonal is -0")
    one.M[44, 44] *= -1
    Chain(one.M, one.K, one.nodes).write(tmp_path, "one")
    swapped = r"one_M\.mtx: most of its rows .*: are stiffness and mass swapped\?"
    refused_by(joined, scene_file(text), swapped)


def test_modes_slower_than_any_structure_are_refused_and_other_units_reported(tmp_path, scene_file):
    """Of stiffnesses that hold every node to the ground, which a mass may look like."""
    one = chain(1, 3, SPRINGS, ground=1.0)
    text = Chain(1e-12 * one.M, 1e6 * one.M, one.nodes).write(tmp_path, "one") + LOAD
    with pytest.raises(InputError, match=r"response\.mode = 1: lies at .*: are stiffness and mass"):
        run_scene(load_scene(scene_file(text)), tmp_path / "run")
    pad = LAP.replace("two", "ground").replace("4e4", "1e-4").format(pairs="[3]")
    text = chain(1, 3, SPRINGS, ground=1.0).write(tmp_path, "one") + pad + LOAD
    (warned,) = [text for what, text in check_file(scene_file(text)).rows if what == "warning"]
    assert str(warned).startswith("contacts.lap.kn = 0.0001 N/m: normal stiffness of a pair is")


def test_a_check_finds_all_that_a_run_would_refuse(tmp_path, scene_file):
    text = two(tmp_path).replace("[components.two]", "fixed = [99]\n[components.two]")
    text += LAP.format(pairs="[[3, 13]]") + LOAD + QUIET
    text += 'monitor = "two 2, x"\n[[measured]]\nfile = "rig.csv"\n'
    with pytest.raises(InputError) as caught:
        check_file(scene_file(text))
    lines = str(caught.value).splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("measured[0].file: ")
    assert lines[0].endswith("rig.csv: no such file")
    assert lines[1] == "components.one.fixed: node 99 is not among the matrices' nodes"
    assert lines[2].startswith('outputs.monitor = "two 2, x": allowed are one 2, and after')
    (tmp_path / "rig.csv").write_text("frequency (Hz), amplitude (um)\n40, 1\n60, 2\n")
    right = text.replace("99", "1").replace("two 2", "one 2")
    assert ("measured", "rig: 2 points of displacement") in check_file(scene_file(right)).rows


MU, WIDTH = 0.3, 0.1
PAD = (
    '[contacts.pad]\nbetween = ["{}", "ground"]\npairs = [{}]\nnormal = [0, 0, 1]\nkn = 1e4\n'
    "kt = 1e4\nmu = 0.3\n"
)


@pytest.fixture
def block(lattice, tmp_path, scene_file):
    part = lattice((2, 2, 2), lambda p: p * WIDTH, "hexahedron")
    text = write_model(tmp_path, assemble(part, Material(E=70e9, nu=0.3, rho=2700)), "block")

    def node(*place: float) -> int:
        return 1 + int(np.linalg.norm(part.points - place, axis=1).argmin())

    corners = [node(x, y, 0) for x in (0, WIDTH) for y in (0, WIDTH)]

    def write(force):
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
