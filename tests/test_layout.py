"""The stages' folders, their links and the list of packages agree, and imports point one way."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from setuptools import find_packages

ROOT = Path(__file__).resolve().parent.parent
STAGES = [
    "mesh",
    "matrices",
    "fem",
    "rom",
    "nonlinear",
    "render",
    "report",
    "study",
    "campaign",
    "assembly",
]  # each imports those before it


def imported_modules(source: Path) -> set[str]:
    """Full names of all that a file imports; relative ones begin with dots."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = "." * node.level + (node.module or "")
            names.update({origin} | {f"{origin}.{alias.name}" for alias in node.names})
    return names


def test_packages_are_the_folders_on_disk() -> None:
    on_disk = {
        ".".join(("vanelock", *init.parent.relative_to(ROOT).parts))
        for stage in STAGES
        for init in (ROOT / stage).rglob("__init__.py")
    }
    with open(ROOT / "pyproject.toml", "rb") as file:
        given = tomllib.load(file)["tool"]["setuptools"]["packages"]["find"]
    assert set(find_packages(str(ROOT), **given)) == on_disk | {"vanelock"}


@pytest.mark.parametrize("stage", ["mesh", "fem", "rom", "nonlinear"])
def test_no_room_is_crowded(stage: str) -> None:
    for folder in [init.parent for init in (ROOT / stage).rglob("__init__.py")]:
        held = [path for path in folder.iterdir() if path.name != "__pycache__"]
        assert len(held) <= 12, folder


def test_every_folder_of_code_is_a_stage() -> None:
    code = {init.parent.name for init in ROOT.glob("*/__init__.py")}
    assert code == {*STAGES, "vanelock"}


@pytest.mark.parametrize("stage", STAGES)
def test_link_leads_to_the_stage(stage: str) -> None:
    link = ROOT / "vanelock" / stage
    assert link.is_symlink()
    assert link.readlink() == Path("..") / stage
    assert link.resolve() == ROOT / stage


@pytest.mark.parametrize("position", range(len(STAGES)), ids=STAGES)
def test_stage_imports_only_those_before_it(position: int) -> None:
    allowed = {f"vanelock.{stage}" for stage in STAGES[: position + 1]}
    sources = list((ROOT / STAGES[position]).rglob("*.py"))
    assert len(sources) >= 2
    wrong = {}
    for source in sources:
        imported = imported_modules(source)
        later = {f"vanelock.{stage}" for stage in STAGES} - allowed
        wrong[source.name] = sorted(
            name
            for name in imported
            if name.startswith(".")
            or name.split(".")[0] in STAGES
            or ".".join(name.split(".")[:2]) in later | {"vanelock.__main__"}
        )
    assert {name: found for name, found in wrong.items() if found} == {}


def test_shared_modules_import_no_stage() -> None:
    for source in (ROOT / "vanelock").glob("*.py"):
        if source.name != "__main__.py":
            stages = {
                name.split(".")[1] for name in imported_modules(source) if "vanelock." in name
            }
            assert stages.isdisjoint(STAGES), source.name


def test_nonlinear_loads_no_mesher_and_no_renderer() -> None:
    code = (
        "import sys, vanelock.nonlinear as stage\n"
        "for name in dir(stage): getattr(stage, name)\n"
        "assert stage.System.__module__ == 'vanelock.rom.system'\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True, cwd="/"
    )
    loaded = set(run.stdout.split())
    assert "numpy" in loaded
    assert loaded.isdisjoint(
        {"gmsh", "meshio", "skfem", "vtk", "vtkmodules", "pyvista", "matplotlib"}
    )
