"""Write requirements.lock: the newest versions that pyproject.toml allows, and their digests.

Run by `make lock`. An environment in build/lock gets one extra after the other; what each adds is a
part of the file. `uv` then adds the digests of all files of each version, whatever their platform.
"""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build" / "lock"
PYTHON = str(FOLDER / "bin" / "python")
HEADER = (
    "# Exact versions that the set-up installs, with the digests of their files; written by "
    "'make lock'.\n"
)
PURPOSES = ("test, docs", "cholmod", "pardiso")
UV = ("--no-deps", "--generate-hashes", "--no-header", "--no-annotate", "--no-emit-index-url")


def main() -> None:
    """Write the file."""
    os.chdir(ROOT)
    own = str(ROOT / ".venv" / "bin" / "python")
    subprocess.run([own, "-m", "venv", "--clear", str(FOLDER)], check=True)
    _pip("--upgrade", "pip", "setuptools", "setuptools-scm", "Cython", "numpy")
    known: set[str] = set()
    parts = {}
    for purpose in PURPOSES:
        _pip("--no-build-isolation", f".[{purpose.replace(' ', '')}]")
        command = [PYTHON, "-m", "pip", "freeze", "--all", "--exclude", "vanelock"]
        frozen = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        parts[purpose] = [line for line in frozen.splitlines() if line not in known]
        known.update(parts[purpose])
    _pip("uv")
    text = HEADER + "".join(f"# For: {purpose}\n{_hashed(parts[purpose])}" for purpose in PURPOSES)
    temporary = ROOT / "requirements.lock.new"
    temporary.write_text(text)
    temporary.replace(ROOT / "requirements.lock")


def _pip(*arguments: str) -> None:
    subprocess.run([PYTHON, "-m", "pip", "install", "--quiet", *arguments], check=True)


def _hashed(pins: list[str]) -> str:
    """Pinned versions with the digests of their files."""
    command = [PYTHON, "-m", "uv", "pip", "compile", "--quiet", *UV, "--no-emit-find-links", "-"]
    given = "".join(f"{pin}\n" for pin in pins)
    return subprocess.run(
        command, input=given, stdout=subprocess.PIPE, text=True, check=True
    ).stdout


if __name__ == "__main__":
    main()
