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
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any, NoReturn

SECONDS, MEMORY = 10, 1_000_000_000
"""Of processor time and bytes that a command may take."""
COMPUTING = 6 * SECONDS
"""Of processor time that a run may take."""
PATIENCE = 120
"""Seconds after which a command that takes no processor time is taken to hang."""
LOADED = (
    "ansys.mapdl.reader", "meshio", "pyuff", "vanelock.__main__", "vanelock.commands.check.file",
    "vanelock.commands.check.study", "vanelock.mesh", "vanelock.mesh.files.read",
    "vanelock.mesh.matching.pairing", "vanelock.commands.check.study",
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
        found = []
        lines = self.err.splitlines()
        if self.status not in statuses:
            found.append(f"exit status {self.status}")
        if "Traceback" in self.err or "Error:" in self.err.partition("vanelock:")[0]:
            found.append("a traceback")
        if self.status == 2 and not lines:
            found.append("nothing said")
        if len(lines) > 24 or max(map(len, lines), default=0) > 3000:
            found.append(f"{len(lines)} lines, {len(self.err)} characters on standard error")
        if not all(line.isprintable() for line in lines + self.out.splitlines()):
            found.append("control characters on the terminal")
        if self.seconds > most:
            found.append(f"{self.seconds:.0f} s")
        if self.memory > MEMORY:
            found.append(f"{self.memory / 1e6:.0f} MB")
        return found


class Here:
    """A context manager in the place of a server: this process, without its limits."""

    def __enter__(self) -> "Here":
        """Begin."""
        return self

    def __exit__(self, *_: object) -> None:
        """End."""

    def run(self, arguments: list[str], folder: Path) -> Outcome:
        """Run the command line in a folder."""
        out, err, status = StringIO(), StringIO(), 70
        began = time.process_time()
        with chdir(folder), redirect_stdout(out), redirect_stderr(err):
            try:
                import_module("vanelock.__main__").main(arguments)
            except SystemExit as error:
                status = error.code if isinstance(error.code, int) else 1
            except BaseException:
                traceback.print_exc()
        seconds = time.process_time() - began
        return Outcome(status, seconds, 0, out.getvalue(), err.getvalue())


class Server:
    """The process that forks; a context manager."""

    def __enter__(self) -> "Server":
        """Start it."""
        self._process = subprocess.Popen(
            [sys.executable, "-u", str(Path(__file__).resolve())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        assert self._process.stdin
        self._process.stdin.close()
        self._process.wait()

    def run(self, arguments: list[str], folder: Path) -> Outcome:
        """Run the command line in a folder."""
        assert self._process.stdin
        assert self._process.stdout
        print(json.dumps([arguments, str(folder)]), file=self._process.stdin, flush=True)
        return Outcome(**json.loads(self._process.stdout.readline()))


def _child(arguments: list[str], folder: str, files: tuple[int, int]) -> NoReturn:
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
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)
        import_module("vanelock.__main__").main(arguments)
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _serve(scratch: Path) -> None:
    for line in sys.stdin:
        arguments, folder = json.loads(line)
        paths = [scratch / name for name in ("out", "err")]
        files = [os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC) for path in paths]
        began, child = time.monotonic(), os.fork()
        if child == 0:
            _child(arguments, folder, (files[0], files[1]))
        state, used = _waited(child, began)
        answer: dict[str, Any] = {
            "status": os.waitstatus_to_exitcode(state),
            "seconds": used.ru_utime + used.ru_stime,
            "memory": used.ru_maxrss * 1024,
        }
        for name, path, file in zip(("out", "err"), paths, files, strict=True):
            os.close(file)
            answer[name] = path.read_bytes()[:100_000].decode("utf-8", "replace")
        print(json.dumps(answer), flush=True)


def _waited(child: int, began: float) -> tuple[int, resource.struct_rusage]:
    while True:
        number, state, used = os.wait4(child, os.WNOHANG)
        if number:
            return state, used
        if time.monotonic() - began > PATIENCE:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.002)


if __name__ == "__main__":
    import tempfile

    for module in LOADED:
        import_module(module)
    from vanelock.common.quantities import si

    si("1 mm", "m")  # the registry of units
    with tempfile.TemporaryDirectory() as place:
        _serve(Path(place))
