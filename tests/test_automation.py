"""What other machines run, continuous integration and containers, names what there is."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
GITHUB, GITLAB = ".github/workflows/checks.yml", ".gitlab-ci.yml"
WANTED = {"lint", "test", "test-system", "docs", "wheel"}


def read(name: str) -> dict[Any, Any]:
    found = yaml.safe_load((ROOT / name).read_text("utf-8"))
    assert isinstance(found, dict)
    return found


def made(name: str) -> set[str]:
    """Targets of make that the file's jobs ask for, those of a matrix included."""
    if name == GITHUB:
        job = read(name)["jobs"]["check"]
        lines = [step["run"] for step in job["steps"] if "run" in step]
        matrix = {"${{ matrix.target }}": job["strategy"]["matrix"]["target"]}
    else:
        job = read(name)["check"]
        lines = job["script"]
        matrix = {'"$TARGET"': job["parallel"]["matrix"][0]["TARGET"]}
    asked = [line.removeprefix("make ") for line in lines if line.startswith("make ")]
    return {target for each in asked for target in matrix.get(each, [each])}


@pytest.mark.parametrize("name", [GITHUB, GITLAB])
def test_continuous_integration_makes_targets_that_there_are(name: str) -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert made(name) == WANTED
    assert made(name) <= set(targets)


def test_only_a_tag_is_published_after_everything_has_passed() -> None:
    job = read(GITHUB)["jobs"]["publish"]
    assert job["if"] == "startsWith(github.ref, 'refs/tags/v')"
    assert job["needs"] == "check"
    assert job["permissions"] == {"id-token": "write"}
    job = read(GITLAB)["publish"]
    assert job["rules"] == [{"if": "$CI_COMMIT_TAG =~ /^v/"}]
    assert (read(GITLAB)["check"]["stage"], job["stage"]) == ("test", "deploy")
    for name in (GITHUB, GITLAB):
        assert "secrets." not in (ROOT / name).read_text()


def test_the_container_has_the_libraries_that_the_set_up_looks_for(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    import system_packages

    _, final = re.split(
        r"^FROM debian:bookworm-slim$", (ROOT / "Dockerfile").read_text(), flags=re.M
    )
    named = set(re.findall(r"(?<= )[a-z][\w.+-]+", final.partition("&& rm")[0]))
    assert set(system_packages.REQUIRED_LIBRARIES.values()) <= named
    assert re.findall(r"^USER (\S+)", final, re.MULTILINE) == ["1000"]
    assert final.index("USER 1000") < final.index("ENTRYPOINT")


def test_tests_that_are_named_as_slow_are_there() -> None:
    for name in tomllib.loads((ROOT / "tools" / "slow.toml").read_text()):
        file, _, function = name.partition("::")
        assert f"\ndef {function}(" in (ROOT / file).read_text(), name
