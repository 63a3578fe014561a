"""Pages of docs/benchmarks: a head that names command, commit and machine, then the report."""

import os
import shlex
import subprocess
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "benchmarks"


def page(name: str, title: str, lines: list[str], write: bool) -> None:
    """Put a report, whose tables were printed as they grew, into docs/benchmarks if wanted."""
    if write:
        text = "\n".join([f"# {title}\n", f"{head()}\n", *lines, ""])
        (FOLDER / f"{name}.md").write_text(text, "utf-8")


def head() -> str:
    """The program that runs and its arguments, the commit, the day and the machine."""
    program = getattr(sys.modules["__main__"].__spec__, "name", Path(sys.argv[0]).stem)
    given = [Path(word).name if Path(word).is_absolute() else word for word in sys.argv[1:]]
    command = shlex.join(["python", "-m", program, *given])
    return f"Made by `{command}` at commit {commit()}, {date.today()}, on {machine()}."


def commit() -> str:
    """The commit checked out, "-dirty" where files other than the manual's have changed."""
    name = git("rev-parse", "--short", "HEAD") or "unknown"
    return name + "-dirty" * bool(git("status", "--porcelain", "-uno", "--", ".", ":!docs"))


def git(*words: str) -> str:
    """What git answers, nothing where there is no repository."""
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip()


def machine() -> str:
    """Kind of the processor, cores that may be used, memory."""
    info = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    kinds = [line.partition(":")[2].strip() for line in info if line.startswith("model name")]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    cores = len(os.sched_getaffinity(0))
    return f"{kinds[0] if kinds else os.uname().machine}, {cores} cores, {memory:.0f} GB"
