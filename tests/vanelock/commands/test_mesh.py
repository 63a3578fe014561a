"""`vanelock mesh`: what it writes, prints and refuses."""

import csv
import json
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from typer.testing import CliRunner

from tests.small_study import SMALL
from vanelock import choose_listener, load_study, mesh, mesh_study, parse_study
from vanelock.__main__ import app
from vanelock.mesh import Part
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Done, Notice
from vanelock.pipeline.step import Stages
from vanelock.quantities.meshes import figures, sets_table
from vanelock.render.scenes import offscreen
from vanelock.stages.parts.components import mesh_step

STUDY = f"{SMALL}[material.casing]\nrho = 7800\n"
FILES = {f"{name}.{kind}" for name in ("vane", "casing") for kind in ("vtu", "msh")} | {
    "quality.csv",
    "sets.csv",
    "mesh.png",
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a study and its meshes, pictures blank, and what the command printed."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "a.toml").write_text(STUDY)

    def blank(path, *_):
        path.touch()
        return path

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("vanelock.render.mesh_picture", blank)
        patched.chdir(folder)
        done = CliRunner().invoke(app, ["mesh", "a.toml"])
    assert done.exit_code == 0, done.stderr
    return folder, done


@pytest.fixture(scope="module")
def parts(made):
    stages = Stages(Cache(made[0] / "runs" / "a" / "cache", print), lambda event: None)
    return [stages.get(mesh_step(parse_study(STUDY), name)) for name in ("vane", "casing")]


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_files_hold_the_parts(made, parts):
    for part in parts:
        path = made[0] / "runs" / "a" / "mesh" / part.name
        shown = offscreen.pyvista().read(path.with_suffix(".vtu"))
        np.testing.assert_array_equal(shown.points, part.points)
        for name, nodes in part.node_sets.items():
            marked = np.flatnonzero(shown.point_data[name])
            np.testing.assert_array_equal(marked, np.sort(nodes))
        read = meshio.read(path.with_suffix(".msh"))
        np.testing.assert_array_equal(read.points[read.cells[0].data], part.points[part.cells])


def test_the_tables_are_those_of_the_parts(made, parts):
    folder = made[0] / "runs" / "a" / "mesh"
    counts = {row["set"]: row for row in rows(folder / "sets.csv")}
    assert set(counts) == {name for part in parts for name in part.node_sets}
    for part, row, density in zip(parts, rows(folder / "quality.csv"), (8200, 7800), strict=True):
        found, count = mesh.quality(part), len(part.points)
        assert (row["part"], row["cell_type"]) == (part.name, "tetra10")
        sizes = [int(row[name]) for name in ("nodes", "dofs", "elements")]
        assert sizes == [count, 3 * count, len(part.cells)]
        for name, expected in (
            ("volume_cm3", 1e6 * found.volume),
            ("mass_kg", density * found.volume),
            ("smallest_jacobian", found.smallest_jacobian),
            ("sicn_min", found.smallest_sicn),
        ):
            assert float(row[name]) == pytest.approx(expected, rel=1e-9)
        against_cad = found.volume / part.cad_volume - 1
        assert float(row["against_cad"]) == pytest.approx(against_cad, rel=1e-6, abs=1e-12)
        assert found.smallest_sicn < float(row["sicn_1_percent"]) < float(row["sicn_median"]) < 1
        for name, nodes in part.node_sets.items():
            assert int(counts[name][part.name]) == len(nodes)
    assert counts["left"]["vane"] == ""


def test_a_second_call_meshes_nothing_and_json_says_so(made, monkeypatch, capsys):
    monkeypatch.setattr("vanelock.render.mesh_picture", lambda path, *_: path)
    folder = made[0]
    with choose_listener(False, True) as listener:
        mesh_study(load_study(folder / "a.toml"), folder / "runs" / "a", listener)
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    stages = {e["stage"]: e["cached"] for e in events if e["event"] == "done"}
    assert stages == {"mesh vane": True, "mesh casing": True}
    tables = {e["table"]: e["rows"] for e in events if e["event"] == "table"}
    assert [row["part"] for row in tables["quality"]] == ["vane", "casing"]
    kept = rows(folder / "runs" / "a" / "mesh" / "quality.csv")
    assert [row["seconds"] for row in tables["quality"]] == [float(row["seconds"]) for row in kept]
    assert {row["set"]: row["casing"] for row in tables["sets"]}["hook_rear"] == 10
    written = {file.rpartition("/")[2] for file in events[-1]["summary"]["files"]}
    assert written == set(FILES)


@pytest.mark.parametrize(
    ("text", "arguments", "line"),
    [
        ("[mesh]\nsize = 2\n", (), "a.toml: mesh.size = 2: element size must be "),
        ("", ("-o", "taken"), "taken: cannot be used as a folder to write to"),
        ("", ("-o", "half"), "half/mesh: is not a folder; move it away or name another"),
    ],
)
def test_what_cannot_be_used_is_one_line(tmp_path, refused, text, arguments, line):
    (tmp_path / "a.toml").write_text(text)
    (tmp_path / "taken").write_text("a file")
    (tmp_path / "half").mkdir()
    (tmp_path / "half" / "mesh").write_text("a file")
    assert refused("mesh", "a.toml", *arguments).startswith(f"vanelock: {line}")


def test_a_sweep_of_dimensions_is_not_meshed_silently(tmp_path, monkeypatch):
    monkeypatch.setattr("vanelock.render.mesh_picture", lambda path, *_: path)
    text = STUDY + '[sweep]\n"vane.chord" = [0.046, 0.047]\n'
    events: list[Any] = []
    found = mesh_study(parse_study(text), tmp_path, events.append)
    assert {event.stage for event in events if isinstance(event, Done)} == {
        "mesh vane",
        "mesh casing",
    }
    (notice,) = (event.text for event in events if isinstance(event, Notice))
    assert notice == "the sweep changes the geometry; these meshes have the unswept values"
    assert found["vane"].dofs == 3 * found["vane"].nodes


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_figures_of_boxes(lattice, cell_type):
    """A block of 2 x 1 x 3 m cut in boxes of 1 m: regular hexahedra, or Kuhn's tetrahedra."""
    part = lattice((2, 1, 3), lambda p: p * [2, 1, 3], cell_type)
    found = figures(part)
    tetra = cell_type.startswith("tetra")
    assert found.elements == (36 if tetra else 6)
    assert found.volume == pytest.approx(6, rel=1e-12)
    assert found.smallest_jacobian > 0
    assert found.largest_edge == pytest.approx(np.sqrt(3) if tetra else 1, rel=1e-12)
    # Kuhn's tetrahedra are all alike.
    assert np.ptp(found.sicn) == pytest.approx(0, abs=1e-12)
    assert found.sicn[0] == pytest.approx(mesh.quality(part).smallest_sicn if tetra else 1)


def test_what_the_notes_say_of_faces():
    points = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 2], [0, 1, 2.5]])
    cells = np.array([[0, 1, 2, 3]])
    sets = {"left": np.array([0, 2]), "right": np.array([1, 3]), "mine": np.array([0])}
    casing = Part("casing", points, cells, "tetra", sets, {}, 4)
    vane = Part("vane", points, cells, "tetra", {"interlock_left": np.array([0])}, {}, 4)
    table = sets_table({"vane": vane, "casing": casing}, 3)
    assert [row[0] for row in table.rows] == ["left", "right", "interlock_left", "mine"]
    assert "Nodes on each cyclic face of the casing: 2, mesh.face_nodes asked for 3." in table.notes
    assert table.notes[-1].endswith("cyclic faces of the casing 5.0e-01 m.")
    assert "2, as asked for." in sets_table({"vane": vane, "casing": casing}, 2).notes[1]


FOLDER = Path(__file__).resolve().parents[3] / "examples"
PAPER = FOLDER / "paper" / "study.toml"


@pytest.mark.system
def test_the_paper_s_scale(tmp_path, monkeypatch):
    monkeypatch.setattr("vanelock.render.mesh_picture", lambda path, *_: path)
    found = mesh_study(load_study(PAPER), tmp_path)
    with (tmp_path / "mesh" / "sets.csv").open() as file:
        rows = {row["set"]: (row["vane"], row["casing"]) for row in csv.DictReader(file)}
    fixed = rows.pop("fixed")
    assert rows == {
        "left": ("", "326"),
        "right": ("", "326"),
        "hook_front": ("30", "30"),
        "hook_rear": ("30", "30"),
        "key": ("4", "4"),
        "interlock_left": ("10", ""),
        "interlock_right": ("10", ""),
        "force": ("", "16"),
        "output": ("3", "3"),
    }
    assert int(fixed[1]) > 100
    assert 100_000 < found["vane"].dofs < 200_000
    assert found["casing"].dofs == pytest.approx(43_000, rel=0.05)
    for each in found.values():
        assert each.smallest_jacobian > 0
        assert each.sicn[0] > 0.05
