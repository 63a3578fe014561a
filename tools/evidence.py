"""What made the pages of evidence, at which commit, and what has changed since.

    python tools/evidence.py                   writes the tables in docs/evidence
    python tools/evidence.py --run [PAGE ...]  runs programs of docs/benchmarks first, all or some

A page's head names its command and its commit. All benchmarks take some hours; those that need
another program besides are left out. `make benchmarks` and `make verify` end with the tables.
"""

import argparse
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
HEAD = re.compile(r"^(?:Made|Written) by `([^`]+)` at commit ([0-9a-f]+)", re.MULTILINE)
BEGIN = "<!-- Table from here to its end written by tools/evidence.py. -->"
END = "<!-- End of Table. -->"
EVERYTHING = ("mesh", "fem", "rom", "nonlinear", "vanelock")
MEASURED = {
    "mesh": ("mesh", "fem"),
    "fem": ("mesh", "fem"),
    "rom": ("mesh", "fem", "rom"),
    "nonlinear": ("nonlinear",),
    "solver": ("nonlinear",),
    "peers": ("nonlinear",),
    "hostile": ("fem", "vanelock"),
}
"""Code that a page measures, by the folder of its program; everything where none is named."""


class Made(NamedTuple):
    """What a page says of itself."""

    path: Path
    title: str
    command: str
    commit: str


def pages(kind: str) -> list[Made]:
    """All pages of a folder of docs/."""
    found = []
    for path in sorted((DOCS / kind).glob("*.md")):
        text = path.read_text("utf-8")
        head = HEAD.search(text)
        if head is None:
            raise SystemExit(f"{path.relative_to(ROOT)}: names no command and commit")
        found.append(Made(path, text.partition("\n")[0].lstrip("# "), *head.groups()))
    return found


def program(made: Made) -> Path:
    """The file that made a page, below the root."""
    words = shlex.split(made.command)
    if words[:2] == ["python", "-m"]:
        return Path(*words[2].split(".")).with_suffix(".py")
    if words[0] == "python":
        return Path(words[1])
    (path,) = (ROOT / "tests" / "verification").rglob(f"test_{made.path.stem}.py")
    return path.relative_to(ROOT)


def git(*words: str) -> str:
    """What git answers; nothing where that is an error."""
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip()


def stored(made: Made) -> str:
    """The commit that a page names, or where this history has it not the one with the page."""
    found = git("rev-parse", "--verify", "--quiet", f"{made.commit}^{{commit}}")
    return found or git("log", "-1", "--format=%H", "--", str(made.path))


def since(made: Made) -> str:
    """Commits to the code that a page measures since it was made."""
    rooms = set(program(made).parts) & set(MEASURED)
    measured = MEASURED[rooms.pop()] if rooms else EVERYTHING
    files = [f"{folder}/*.py" for folder in measured]
    commits = git("rev-list", "--count", f"{stored(made)}..HEAD", "--", *files)
    return f"{commits} commits to {'all code' if measured == EVERYTHING else ', '.join(measured)}"


def table(kind: str) -> str:
    """What a page of docs/evidence lists."""
    rows = ["| page | made by | at commit | of | since then |", "|---|---|---|---|---|"]
    for made in pages(kind):
        link = f"[{made.title.removeprefix('Verification: ')}](../{kind}/{made.path.name})"
        day = git("show", "-s", "--format=%as", stored(made))
        cells = (link, f"`{program(made)}`", made.commit, day, since(made))
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def run(names: list[str]) -> None:
    """Run programs of docs/benchmarks, each as its page has it."""
    listed = {made.path.stem: made for made in pages("benchmarks")}
    unknown = sorted(set(names) - set(listed))
    if unknown:
        raise SystemExit(f"no such page: {', '.join(unknown)}; there are {', '.join(listed)}")
    for name in names or listed:
        words = shlex.split(listed[name].command)
        if "PATH" in words:
            print(f"{name}: left out, needs another program: {listed[name].command}", flush=True)
            continue
        print(f"{name}: {listed[name].command}", flush=True)
        given = [word for word in words[1:] if word != "--kept"]  # which computes nothing
        subprocess.run([sys.executable, *given], cwd=ROOT, check=True)


def main() -> None:
    """Run what is asked for, then write the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--run", nargs="*", metavar="PAGE", help="benchmarks, all if none is named")
    given = parser.parse_args()
    if given.run is not None:
        run(given.run)
    counted = f"Counted at commit {git('rev-parse', '--short=8', 'HEAD')}."
    for kind in ("benchmarks", "verification"):
        path = DOCS / "evidence" / f"{kind}.md"
        before, _, rest = path.read_text("utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        text = "\n\n".join([BEGIN, counted, table(kind), END])
        path.write_text(f"{before}{text}{after}", "utf-8")


if __name__ == "__main__":
    main()
