"""The stages' folders, their links and the list of packages agree, and imports point one way."""

import ast
import re
import tomllib
from pathlib import Path

import pytest
from setuptools import find_packages

ROOT = Path(__file__).resolve().parent.parent
PHYSICS = ["mesh", "fem", "rom", "nonlinear"]
MOST = 20
GENERAL = [
    "fem", "nonlinear", "rom/fixed_interface", "rom/full_fields.py", "rom/routes",
    "vanelock/common", "vanelock/pipeline",
    "vanelock/render/scenes", "vanelock/report",
    "vanelock/stages/matrices", "vanelock/stages/response",
]  # fmt: skip
"""What knows no vane, casing or interlock: of these a study alone has any."""


def test_packages_are_the_folders_on_disk():
    on_disk = {
        ".".join(("vanelock", *init.parent.relative_to(ROOT).parts))
        for stage in PHYSICS
        for init in (ROOT / stage).rglob("__init__.py")
    }
    program = (ROOT / "vanelock").rglob("__init__.py")
    on_disk |= {".".join(init.parent.relative_to(ROOT).parts) for init in program}
    with open(ROOT / "pyproject.toml", "rb") as file:
        given = tomllib.load(file)["tool"]["setuptools"]["packages"]["find"]
    assert given.pop("namespaces") is False
    assert set(find_packages(str(ROOT), **given)) == on_disk


def test_the_top_level_is_physics_and_the_program():
    code = {init.parent.name for init in ROOT.glob("*/__init__.py")}
    assert code == {*PHYSICS, "vanelock"}


def test_no_folder_of_code_is_crowded():
    crowded = {}
    tops = (*PHYSICS, "vanelock", "benchmarks", "tests/verification")
    for folder in {path.parent for top in tops for path in (ROOT / top).rglob("*.py")}:
        held = {path.name for path in folder.iterdir() if not path.is_symlink()}
        held -= {"__pycache__", "py.typed"}
        if len(held) > MOST:
            crowded[str(folder.relative_to(ROOT))] = len(held)
    assert crowded == {}


def test_what_is_general_knows_no_parts_by_name():
    named = re.compile(r"\b(vanes?|casings?|interlocks?|hooks?)\b", re.IGNORECASE)
    sources = [p for at in GENERAL for p in ROOT.glob(at if "." in at else f"{at}/**/*.py")]
    assert len(sources) > 100
    found = {str(f.relative_to(ROOT)) for f in sources if named.search(f.read_text())}
    assert found == set()


def test_every_file_of_code_is_in_a_room():
    for name in (*PHYSICS, "vanelock"):
        for path in (ROOT / name).rglob("*.py"):
            assert (path.parent / "__init__.py").exists(), path


@pytest.mark.parametrize("name", [*PHYSICS, "manual", "examples"])
def test_link_leads_to_what_is_installed_with_the_program(name):
    folder = "docs" if name == "manual" else name
    assert (ROOT / "vanelock" / name).readlink() == Path("..") / folder
    assert (ROOT / folder).is_dir()


def test_a_class_name_means_one_thing():
    places: dict[str, list[str]] = {}
    for name in (*PHYSICS, "vanelock"):
        for path in (ROOT / name).rglob("*.py"):
            for node in ast.parse(path.read_text("utf-8")).body:
                if isinstance(node, ast.ClassDef):
                    places.setdefault(node.name, []).append(str(path.relative_to(ROOT)))
    assert {name for name, found in places.items() if len(found) > 1} == set()


def test_files_that_contributing_names_are_there():
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    named = set(
        re.findall(r"`((?:mesh|fem|rom|nonlinear|vanelock|tests|tools|examples)/[\w/.]+)`", text)
    )
    assert len(named) > 30
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []
