"""The table of sizes has the budget's lines, and names, keys and words as counted by hand."""

import subprocess
from pathlib import Path

import pytest

from vanelock import Study
from vanelock.common.checked import known_keys

TOOLS = Path(__file__).resolve().parent.parent / "tools"
CURVE = """from budget import count
_modules = {"count": "budget"}
LIMIT, _step = [size for size in (1, 2)]
SIZES: dict[str, int] = {}
def found(given, *at, **each): kept = lambda known: known
class Curve:
    whole: int
    def first(self, own: int) -> None: base: int = own
class _Inner: ...
"""
PROGRAM = """from pydantic import BaseModel
class Joint(BaseModel): mu: float; kn: float = 1
class Study(BaseModel): joint: Joint | None; gauges: tuple[Joint, ...]; name: str; sweep: dict
template_text = "name = 'a'\\n[joint]\\n".lower
"""
BEFORE = {"mesh/curve.py": CURVE, "vanelock/__init__.py": PROGRAM, "tests/test_a.py": "a = 1\n"}
BEFORE |= {"docs/start/a.md": "Two words", "docs/keys.md": "no", "docs/evidence/a.md": "no"}
AFTER = {"mesh/curve.py": "LIMIT = 1\n", "docs/a.md": "three more words"}
EXPECTED = {
    "mesh, fem, rom: lines": ["9", "1", "-8"],
    "product: code": ["11", "4", "-7"],
    "tests: files": ["1", "1", "+0"],
    "public names": ["4", "2", "-2"],  # found and Curve; Joint and Study
    "public constants and aliases": ["3", "2", "-1"],
    "names that say no type": ["6", "0", "-6"],  # not kept, first, base
    "keys of a study": ["5", "5", "+0"],
    "words of guides and theory": ["2", "5", "+3"],
    "lines of `vanelock init`": ["2", "2", "+0"],
}


def table(text: str, width: int) -> dict[str, list[str]]:
    """Numbers of each row by its title."""
    return {line[:width].strip(): line[width:].split() for line in text.splitlines()[1:]}


def test_sizes_of_two_commits_and_of_the_tree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(str(TOOLS))
    import budget
    import targets

    monkeypatch.setattr(budget, "ROOT", tmp_path)
    monkeypatch.setattr(targets, "ROOT", tmp_path)
    who = ("-c", "user.name=a", "-c", "user.email=a@example.org")
    for files in (BEFORE, AFTER):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        for command in (["init", "-q"], ["add", "--all"], [*who, "commit", "-q", "-m", "a"]):
            subprocess.run(["git", *command], cwd=tmp_path, check=True)
    targets.main(["HEAD~1", "HEAD", "--trial", "HEAD"])
    printed = capsys.readouterr().out
    rows = table(printed, 48)
    assert rows | EXPECTED == rows
    assert printed.splitlines()[-1].endswith(" 2")
    targets.main([])
    rows = table(capsys.readouterr().out, 48)
    assert budget.main() == 0
    for folder, (lines, code, *_) in table(capsys.readouterr().out, 40).items():
        assert (rows[f"{folder}: lines"], rows[f"{folder}: code"]) == ([lines], [code])
    every = known_keys(Study)
    leaves = {key for key in every if not any(k.startswith(f"{key}.") for k in every)}
    assert len(targets.keys(Study)) == len(leaves - {"sweep", "rows"})
