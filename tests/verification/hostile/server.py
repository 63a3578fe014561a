"""Runs the command line on one hostile file after the other, each in a child of its own.

A process that has loaded everything forks for each command, which takes milliseconds where a new
interpreter takes a second. Commands come as lines of JSON on standard input, what became of each
goes out as one on standard output.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

SECONDS, MEMORY = 10, 1_000_000_000
"""Of processor time and bytes that a command may take."""
COMPUTING = 6 * SECONDS
"""Of processor time that a run may take."""
PATIENCE = 120
"""Seconds after which a command that takes no processor time is taken to hang."""
LOADED = (
    "ansys.mapdl.reader", "meshio", "pyuff", "vanelock.__main__", "vanelock.commands.check.file",
    "vanelock.commands.check.study", "vanelock.mesh", "vanelock.mesh.files.read",
    "vanelock.mesh.matching.pairing", "vanelock.commands.check.scene",
    "vanelock.commands.compare", "vanelock.pipeline.display", "vanelock.pipeline.progress",
    "vanelock.report.writer", "pint", "h5py", "scipy.io", "scipy.sparse.csgraph",
    "vanelock.fem.matrix_files.load",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """What became of a command: exit status (minus a signal's number), cost, and what it said."""

    status: int
    seconds: float
    memory: int
    out: str
    err: str

    def faults(self, statuses: tuple[int, ...] = (0, 2), most: float = SECONDS) -> list[str]:
        """What is wrong with it, nothing where it did as it should in so many seconds."""
        lines = self.err.splitlines()
        longest = max(map(len, lines), default=0)
        wrong = {
            f"exit status {self.status}": self.status not in statuses,
            "a traceback": "Traceback" in self.err or "Error:" in self.err.split("vanelock:")[0],
            "nothing said": self.status == 2 and not lines,
            f"{len(lines)} lines, up to {longest} characters": len(lines) > 24 or longest > 3000,
            "control characters on the terminal": not all(
                line.isprintable() for line in lines + self.out.splitlines()
            ),
            f"{self.seconds:.0f} s": self.seconds > most,
            f"{self.memory / 1e6:.0f} MB": self.memory > MEMORY,
        }
        return [what for what, true in wrong.items() if true]


class Server:
    """The process that forks; a context manager."""

    def __enter__(self) -> "Server":
        """Start it."""
        command = [sys.executable, "-u", str(Path(__file__).resolve())]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        assert self._process.stdin
        assert self._process.stdout
        self._commands, self._answers = self._process.stdin, self._process.stdout
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self._commands.close()
        self._process.wait()

    def run(self, arguments: list[str], folder: Path) -> Outcome:
        """Run the command line in a folder."""
        print(json.dumps([arguments, str(folder)]), file=self._commands, flush=True)
        return Outcome(**json.loads(self._answers.readline()))


def _child(arguments: list[str], folder: str, files: list[int]) -> NoReturn:
    """Run a command under the limits and end without what the server would do at its end."""
    status = 70
    try:
        for stream, file in zip((1, 2), files, strict=True):
            os.dup2(file, stream)
        os.chdir(folder)
        taken = int(Path("/proc/self/statm").read_text().split()[5]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_DATA, (taken + MEMORY, resource.RLIM_INFINITY))
        resource.setrlimit(resource.RLIMIT_CPU, (COMPUTING, COMPUTING))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        sys.stdout, sys.stderr = (
            open(stream, "w", encoding="utf-8", closefd=False) for stream in (1, 2)
        )
        import_module("vanelock.__main__").main(arguments)
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _waited(child: int) -> tuple[int, resource.struct_rusage]:
    began = time.monotonic()
    while True:
        number, state, used = os.wait4(child, os.WNOHANG)
        if number:
            return os.waitstatus_to_exitcode(state), used
        if time.monotonic() - began > PATIENCE:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.002)


def _serve(scratch: Path) -> None:
    paths = [scratch / name for name in ("out", "err")]
    for line in sys.stdin:
        files = [os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC) for path in paths]
        child = os.fork()
        if child == 0:
            arguments, folder = json.loads(line)
            _child(arguments, folder, files)
        status, used = _waited(child)
        for file in files:
            os.close(file)
        out, err = (path.read_bytes()[:100_000].decode("utf-8", "replace") for path in paths)
        seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss * 1024
        print(json.dumps(vars(Outcome(status, seconds, memory, out, err))), flush=True)


if __name__ == "__main__":
    for module in LOADED:
        import_module(module)
    from vanelock.common.quantities import si

    si("1 mm", "m")  # the registry of units
    with TemporaryDirectory() as place:
        _serve(Path(place))
