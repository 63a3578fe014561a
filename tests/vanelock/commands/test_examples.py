"""Examples as `vanelock init --example` writes them: whole, once, and fit to be run."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.vanelock.scenes.scenes import generator
from vanelock.__main__ import app
from vanelock.commands.installed import examples, write_example

ROOT = Path(__file__).resolve().parents[3]
NAMES = (
    "brake_reuss, coupling, engine_orders, ground_damper, lap_joint, loads_at_rest, mistuning, "
    "notebooks, paper, shrouded_ring, vane"
).split(", ")


def test_all_examples_have_names_and_help_tells_them() -> None:
    assert [*examples()] == NAMES
    text = CliRunner().invoke(app, ["init", "--help"]).output
    about = " ".join(text.partition("An example comes")[2].partition("Examples:")[0].split())
    assert [name for name in NAMES if name not in about] == []


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_written_as_it_is(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["init", "--example", name])
    assert done.exit_code == 0
    source = ROOT / "examples" / examples()[name].name
    (written,) = tmp_path.iterdir()
    assert written.name == source.name
    if source.is_file():
        assert written.read_bytes() == source.read_bytes()
        assert done.output == f"{name}.toml written; run it with: vanelock run {name}.toml\n"
    else:
        held = {path.name: path.read_bytes() for path in source.iterdir() if path.is_file()}
        assert sum(map(len, held.values())) < 1e6
        assert {path.name: path.read_bytes() for path in written.iterdir()} == held


@pytest.mark.parametrize("name", [name for name in NAMES if name != "notebooks"])
def test_an_example_that_was_written_passes_check(name: str, tmp_path: Path) -> None:
    written = write_example(name, tmp_path / "mine")
    if name == "brake_reuss":
        generator(name, written).main(columns=6, divisions=1, layers=1)
        nodes = written / "scene.toml"  # those of the whole mesh have other numbers
        nodes.write_text(re.sub("\nmonitor = .*", "", nodes.read_text()))
    study = next(written.glob("s*.toml")) if written.is_dir() else written
    done = CliRunner().invoke(app, ["check", str(study)])
    assert done.exit_code == 0, done.output


def test_what_cannot_be_written_is_refused(tmp_path: Path, refused: Callable[..., str]) -> None:
    """What is there is left alone, and other names are refused with those that there are."""
    (tmp_path / "vane.toml").write_text("mine")
    (tmp_path / "lap_joint").mkdir()
    for arguments, line in (
        (("--example", "vane"), "vane.toml: exists already; name another file"),
        (("--example", "lap_joint"), "lap_joint: exists already; name another folder"),
        (
            ("--example", "vane", "none/vane.toml"),
            "none/vane.toml: cannot be written: none is not a folder",
        ),
        (("--example", "lap"), f'--example "lap": expected one of {", ".join(NAMES)}'),
        (("--scene", "--example", "vane"), "--example: expected without --scene and --all"),
    ):
        assert refused("init", *arguments) == f"vanelock: {line}"
    assert (tmp_path / "vane.toml").read_text() == "mine"
    assert [*(tmp_path / "lap_joint").iterdir()] == []
    assert len([*tmp_path.iterdir()]) == 2


def test_a_failure_leaves_nothing_half_written(tmp_path, monkeypatch, refused):
    def full(source: object, target: object) -> None:
        Path(str(target)).write_bytes(b"some")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("vanelock.commands.installed.shutil.copyfile", full)
    for name, written in (("lap_joint", "lap_joint"), ("vane", "vane.toml")):
        line = refused("init", "--example", name)
        assert line.startswith(f"vanelock: {written}: cannot be written: ")
        assert [*tmp_path.iterdir()] == []
