"""Help, completion, pages of the manual and examples: whole, and what they name is there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.vanelock.scenes.conftest import generator
from vanelock import Study, __main__
from vanelock.__main__ import app, main
from vanelock.commands.converge.settings import settings_of
from vanelock.commands.installed import contents_list, examples, page_text, pages, write_example
from vanelock.commands.options import setting_keys, study_files

COMMANDS = sorted(
    each.name or getattr(each.callback, "__name__", "") for each in app.registered_commands
)


def printed(*words: str) -> str:
    done = CliRunner().invoke(app, [*words, "--help"], prog_name="vanelock", terminal_width=200)
    assert done.exit_code == 0
    return done.output


HEAVY = "gmsh vtk vtkmodules pyvista".split()
SOLVING = "skfem sksparse matplotlib".split()
QUICK = {
    "import vanelock.__main__": ["numpy", "h5py", "pydantic"],
    "import vanelock; vanelock.Run, vanelock.load": [*HEAVY, "pandas", "xarray"],
    "import vanelock; vanelock.check_file('a.toml')": [
        *HEAVY, *SOLVING, "numba", "scipy.optimize", "scipy.stats",
    ],
    "import vanelock.nonlinear as n; [getattr(n, it) for it in dir(n)]": [
        *HEAVY, *SOLVING, "meshio",
    ],
}  # fmt: skip
"""What is to be quick, and what it therefore does not load."""


@pytest.mark.parametrize("code", QUICK)
def test_what_is_to_be_quick_loads_no_more_than_it_needs(code, tmp_path):
    (tmp_path / "a.toml").write_text('name = "x"\n')
    code += "; import sys; print(*sys.modules)"
    loaded = subprocess.check_output([sys.executable, "-c", code], text=True, cwd=tmp_path).split()
    assert "vanelock" in loaded
    assert {*QUICK[code.partition("; import sys")[0]]} & {*loaded} == set()


@pytest.mark.parametrize("words", [[], *([name] for name in COMMANDS)])
def test_help_fits_a_terminal_of_80_columns(words):
    done = CliRunner().invoke(app, [*words, "--help"], prog_name="vanelock", terminal_width=80)
    assert [line for line in done.output.splitlines() if len(line) > 80] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_purpose_example_statuses_and_pages(name):
    text = printed(name)
    missing = "add the command to vanelock/commands/options.py"
    purpose = text.partition("Arguments:")[0].partition("Usage:")[2]
    assert len(purpose.split()) > 8, missing
    assert f"\n    vanelock {name} " in text, missing
    for status in ("0 done", "2 input that cannot be used", "130 stopped"):
        assert status in " ".join(text.split()), missing
    assert ("some cases of a sweep failed" in " ".join(text.split())) == (name == "run")
    named = re.search(r"More: (.*)", text)
    assert named, missing
    assert set(re.findall(r"`vanelock manual ([\w/]+)`", named[1])) <= set(pages())
    assert named[1].count("`vanelock manual ") == named[1].count(", ") + 1


def test_the_help_of_all_shows_the_way_of_a_first_study():
    text = printed()
    steps = re.findall(r"^    vanelock (\w+) ", text, re.MULTILINE)
    assert steps == ["init", "check", "mesh", "run", "converge", "compare"]
    assert set(steps) <= set(COMMANDS)
    named = re.search(r"`vanelock manual PAGE` prints one: ([^.]*)", " ".join(text.split()))
    assert named
    assert set(named[1].split(", ")) <= set(pages())
    listed = re.findall(r"^  (\w+)  +(\S.*)$", text.partition("Commands:")[2], re.MULTILINE)
    assert [name for name, _ in listed if name in COMMANDS] == [
        each.name or each.callback.__name__ for each in app.registered_commands if each.callback
    ]
    assert [line for _, line in listed if line.endswith("...")] == []


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "tcsh"])
def test_a_completion_script_names_the_program(shell):
    done = CliRunner().invoke(app, ["completion", shell])
    known = shell != "tcsh"
    assert done.exit_code == (0 if known else 2)
    expected = f"_VANELOCK_COMPLETE=complete_{shell}" if known else "'bash', 'zsh', 'fish'"
    assert expected in done.output


def test_study_files_and_every_setting_of_a_study_are_completed(tmp_path):
    (tmp_path / "a.toml").write_text("")
    (tmp_path / "a.csv").write_text("")
    assert study_files(f"{tmp_path}/") == [f"{tmp_path}/a.toml"]
    assert study_files(f"{tmp_path}/b") == []
    assert study_files(f"{tmp_path}/none/") == []
    studies = [{}, {"rom": {"route": "paper", "modes": 5}}, {"rom": {"modes": 5}}]
    found = {key for each in studies for key in settings_of(Study.model_validate(each))}
    assert found <= set(setting_keys(""))
    assert setting_keys("mesh") == ["mesh.size"]


def test_too_little_memory_is_one_line_and_status_2(monkeypatch, capsys):
    def greedy(*arguments: object, **options: object) -> None:
        raise MemoryError("Unable to allocate 50 GiB")

    monkeypatch.setattr(__main__, "app", greedy)
    with pytest.raises(SystemExit) as ended:
        __main__.main(["run", "study.toml"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("vanelock: not enough memory (Unable to allocate 50 GiB): ")


ROOT = Path(__file__).resolve().parents[3]
NOT_INSTALLED = {"index", "project/changelog", "project/contributing", "project/licence"}


def page_printed(*words: str) -> str:
    done = CliRunner().invoke(app, ["manual", *words])
    assert done.exit_code == 0
    return done.output


def test_all_pages_are_listed_and_plain_markdown_where_no_terminal_shows_them():
    docs = ROOT / "docs"
    names = {str(page.relative_to(docs).with_suffix("")) for page in docs.rglob("*.md")}
    names = {name for name in names if not name.startswith("reference/")}  # made by `make docs`
    assert set(pages()) == names - NOT_INSTALLED
    lines = page_printed().splitlines()
    assert page_printed() == f"{contents_list()}\n"
    assert [line.split()[0] for line in lines if line.startswith("  ")] == [*pages()]
    assert re.search(r"^  theory/contact +Contact law$", page_printed(), re.MULTILINE)
    text = page_printed("start/install")
    assert text.startswith("# Install\n\nLinux with Python")
    assert "$ make study\n" in text
    assert "\x1b" not in text


@pytest.mark.parametrize("name", pages())
def test_a_page_points_at_no_file_that_is_not_installed(name):
    text = page_text(name)
    assert text.startswith("# ")
    assert not re.search(r"\]\([^)\s]*\.(md|png)", text)
    assert "```{" not in text


def test_a_page_that_there_is_not_is_one_line(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["manual", "sweep"])
    said = capsys.readouterr()
    assert (ended.value.code, said.out) == (2, "")
    (line,) = said.err.splitlines()
    assert line.startswith(
        'vanelock: manual: "sweep" is no page; expected one of start/first_study, '
    )
    assert ", sweeps, trust, theory/..., " in line


def test_pages_that_the_program_and_examples_name_are_there():
    sources = [
        path
        for top in ("mesh", "fem", "rom", "nonlinear", "vanelock", "examples")
        for ending in ("py", "toml", "html", "js", "ipynb")
        for path in (ROOT / top).rglob(f"*.{ending}")
    ]
    text = "\n".join(path.read_text("utf-8") for path in sources)
    named = set(re.findall(r"`vanelock manual ([a-z_/]+)`", text))
    assert len(named) > 8
    assert named <= set(pages())


NAMES = (
    "brake_reuss, coupling, engine_orders, ground_damper, lap_joint, loads_at_rest, mistuning, "
    "notebooks, paper, shrouded_ring, vane"
).split(", ")


def test_all_examples_have_names_and_help_tells_them():
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
def test_an_example_that_was_written_passes_check(name, tmp_path):
    written = write_example(name, tmp_path / "mine")
    if name == "brake_reuss":
        generator(name, written).main(columns=6, divisions=1, layers=1)
        nodes = written / "scene.toml"  # those of the whole mesh have other numbers
        nodes.write_text(re.sub("\nmonitor = .*", "", nodes.read_text()))
    study = next(written.glob("s*.toml")) if written.is_dir() else written
    done = CliRunner().invoke(app, ["check", str(study)])
    assert done.exit_code == 0, done.output


def test_what_cannot_be_written_is_refused(tmp_path, refused):
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
