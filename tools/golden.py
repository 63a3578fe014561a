"""Compare the golden runs with those of another commit, number by number, on this machine.

Each state makes the runs that it describes itself, so that keys may have changed between them.

    python tools/golden.py            # beside the last commit
    python tools/golden.py v0.1.0 default sweep
    python tools/golden.py --write    # the numbers that `make test` compares with, anew

Every number of the tables, the CSV files and the results file that differs by more than 1e-10 of
the largest of its column is a line; ends with status 1 if there is one.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOLERANCE = 1e-10


def main() -> None:
    """Write the numbers of the tests, or compare those of two states and print what differs."""
    import vanelock  # noqa: F401  the state that is asked about

    sys.path.insert(0, str(ROOT))
    from tests.golden.runs import NAMES

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commit", nargs="?", default="HEAD")
    parser.add_argument("names", nargs="*", metavar="run", help=", ".join(NAMES))
    parser.add_argument("--write", action="store_true", help="write the numbers of the tests anew")
    parser.add_argument("--found", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    names = given.names or list(NAMES)
    with tempfile.TemporaryDirectory() as folder:
        if given.write:
            _write(names, Path(folder))
        elif given.found:
            given.found.write_text(json.dumps(_found(names, Path(folder))))
        else:
            lines = _compared(given.commit, names, Path(folder))
            print("\n".join(lines) or f"{len(names)} runs agree to {TOLERANCE:g}")
            sys.exit(bool(lines))


def _write(names: list[str], place: Path) -> None:
    """The numbers that tests compare with, a line a column."""
    from tests.golden.numbers import short, shown
    from tests.golden.runs import golden_run

    for name in names:
        numbers = short(shown(golden_run(name, place)))
        text = ",\n".join(f"{json.dumps(key)}: {json.dumps(each)}" for key, each in numbers.items())
        (ROOT / "tests" / "golden" / f"{name}.json").write_text(f"{{\n{text}\n}}\n")


def _compared(commit: str, names: list[str], place: Path) -> list[str]:
    """A line for each number that differs between a commit and this state."""
    from tests.golden.numbers import differences

    tree = place / "before"
    _git("worktree", "add", "--detach", str(tree), commit)
    try:
        before, now = (_of(each, names, place) for each in (tree, ROOT))
    finally:
        _git("worktree", "remove", "--force", str(tree))
    return [
        f"{name}, {line}"
        for name in names
        for line in sorted(differences(before[name], now[name], TOLERANCE))
    ]


def _found(names: list[str], place: Path) -> dict[str, dict[str, list[float]]]:
    """All numbers of the runs, by the program that this process imports."""
    from tests.golden.numbers import shown, stored
    from tests.golden.runs import golden_run

    runs = {name: golden_run(name, place) for name in names}
    return {name: shown(run) | stored(run.folder) for name, run in runs.items()}


def _of(tree: Path, names: list[str], place: Path) -> dict[str, dict[str, list[float]]]:
    """The same by the program in a tree, in a process of its own."""
    out = place / f"{tree.name}.json"
    environment = os.environ | {"PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1"}
    script = tree / "tools" / "golden.py"
    command = [sys.executable, str(script), "--found", str(out), "HEAD", *names]
    subprocess.run(command, check=True, cwd=place, env=environment)
    read: dict[str, dict[str, list[float]]] = json.loads(out.read_text())
    return read


def _git(*arguments: str) -> None:
    subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True)


if __name__ == "__main__":
    main()
