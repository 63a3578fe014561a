"""What one backend costs for one matrix, measured in a process of its own.

    python -m benchmarks.isolated matrix.npz cholmod 1

prints it as JSON; `in_child` runs that. Times are of the CPU, on one thread: the least of three, or
of one where it takes more than two seconds.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
os.environ.update(dict.fromkeys(THREADS, "1"))  # before anything loads a BLAS

import numpy as np  # noqa: E402
import scipy.sparse as sp  # noqa: E402

from vanelock import fem  # noqa: E402

COLUMNS = 128
LONG = 2.0  # s


def seconds(run: Callable[[], Any], times: int = 3) -> float:
    """Least CPU time of a few runs."""
    best = np.inf
    for _ in range(times):
        begin = time.process_time()
        run()
        best = min(best, time.process_time() - begin)
        if best > LONG:
            break
    return best


def memory(field: str) -> float:
    """VmRSS or VmHWM (its peak) of this process, MB; nan where Linux's /proc is not there."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
    return int(lines[field].split()[0]) / 1024


def measured(file: str, backend: str) -> dict[str, Any]:
    """What one backend costs for the matrix in a file. Runs in the child process."""
    with np.load(file) as parts:
        A = sp.csc_array((parts["data"], parts["indices"], parts["indptr"]))
    before = memory("VmRSS")
    begin = time.process_time()
    factor = fem.factorise(A, backend)
    first = time.process_time() - begin
    after = memory("VmHWM")
    if first < LONG:
        first = min(first, seconds(lambda: fem.factorise(A, backend), 2))
    b = np.random.default_rng(0).standard_normal((A.shape[0], COLUMNS)).astype(A.dtype)
    b = np.asfortranarray(b)
    x = factor.solve(b[:, 0])
    residual = abs(A @ x - b[:, 0]).max()
    return {
        "backend": factor.backend,
        "factor": first,
        "block": seconds(lambda: factor.solve(b)) / COLUMNS,
        "single": seconds(lambda: factor.solve(b[:, 0])),
        "memory": after - before,
        "error": residual / (abs(A).sum(axis=1).max() * abs(x).max() + abs(b[:, 0]).max()),
    }


@contextmanager
def stored(A: sp.csc_array) -> Iterator[str]:
    """A file with a matrix."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "matrix.npz")
        np.savez(file, data=A.data, indices=A.indices, indptr=A.indptr)
        yield file


def in_child(file: str, backend: str) -> dict[str, Any]:
    """`measured` in a process of its own."""
    command = [sys.executable, __file__, file, backend]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    result: dict[str, Any] = json.loads(done.stdout)
    return result


if __name__ == "__main__":
    print(json.dumps(measured(sys.argv[1], sys.argv[2])))
