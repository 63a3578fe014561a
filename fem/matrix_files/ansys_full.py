"""Ansys's .full: assembled stiffness and mass, one triangle, with the freedoms that are held.

Read by ansys-mapdl-reader (an optional library), in a process of its own: its compiled part trusts
the numbers in the file. Rows of held freedoms are left out, as the solver leaves them out.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from vanelock.common.arrays import Array
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files.contents import (
    SYMMETRIC,
    Entries,
    NoMatrixError,
    WantedMatrix,
    size_of,
)

_SECONDS, _A_SECOND = 4, 2 << 20
"""Processor time for a file, and bytes for each second more: a damaged one may not end."""

_CHILD = """
import resource, sys
source, target, most, seconds = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
try:
    from ansys.mapdl.reader import read_binary
except ImportError:
    sys.exit(3)
with open("/proc/self/statm") as file:
    most += int(file.read().split()[0]) * resource.getpagesize()
used = resource.getrusage(resource.RUSAGE_SELF)
seconds += int(used.ru_utime + used.ru_stime) + 1
for what, limit in ((resource.RLIMIT_AS, most), (resource.RLIMIT_CPU, seconds)):
    soft, hard = resource.getrlimit(what)
    at_most = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(what, (at_most, hard))
import numpy as np
try:
    full = read_binary(source)
    label, k, m = full.load_km(sort=False)
    held = np.asarray(full.const).reshape(-1, 2)
    found = {"label": label, "held": held, "equations": full._header.get("ncefull", 0)}
    for name, matrix in (("K", k), ("M", m)):
        if matrix is not None:
            coo = matrix.tocoo()
            found |= {name + "row": coo.row, name + "col": coo.col, name + "data": coo.data}
    np.savez(target, **found)
except NotImplementedError as error:
    print(str(error).splitlines()[0][:150])
    sys.exit(4)
"""


def read_full(path: Path, request: WantedMatrix) -> Entries:
    """Read stiffness or mass."""
    source, size = str(path), size_of(path)
    letter = {"stiffness": "K", "mass": "M"}.get(request.what)
    if letter is None or (request.name is not None and request.name.upper() != letter):
        raise NoMatrixError(f"{source}: holds the stiffness K and the mass M")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "full.npz"
        _in_a_process(source, target, size)
        if not target.is_file():
            raise InputError(f"{source}: not a readable .full file")
        found = _arrays(target)
    if int(found["equations"]):
        raise InputError(f"{source}: constraint equations of the model are not read")
    if f"{letter}data" not in found:
        raise NoMatrixError(f"{source}: holds no {request.what} matrix")
    label, held = found["label"].astype(np.int64), found["held"].astype(np.int64)
    if (label[:, 1] > 5).any() or (label[:, 1] < 0).any() or (label[:, 0] < 1).any():
        raise InputError(f"{source}: displacements and rotations of nodes are read, nothing else")
    fixed = frozenset(map(tuple, held.tolist()))
    free = np.array([tuple(each) not in fixed for each in label.tolist()], bool)
    number = np.cumsum(free) - 1
    row, column = found[f"{letter}row"], found[f"{letter}col"]
    kept = free[row] & free[column]
    return Entries(
        source,
        int(free.sum()),
        number[row[kept]],
        number[column[kept]],
        found[f"{letter}data"][kept],
        SYMMETRIC,
        label[free, 0],
        label[free, 1],
        fixed=fixed,
    )


def _in_a_process(source: str, target: Path, size: int) -> None:
    """Read there, so that a fault in the library ends it and not the program."""
    most, seconds = (500 << 20) + 60 * size, _SECONDS + size // _A_SECOND
    command = [sys.executable, "-c", _CHILD, os.path.abspath(source), str(target)]
    try:
        run = subprocess.run(
            [*command, str(most), str(seconds)],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            timeout=60 + 10 * seconds,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        raise InputError(f"{source}: could not be read") from None
    if run.returncode == 3:
        raise InputError(
            f"{source}: Ansys's .full files need the library ansys-mapdl-reader: "
            "pip install 'vanelock[ansys]'; or export Harwell-Boeing files (HBMAT)"
        )
    if run.returncode == 4:
        raise InputError(f"{source}: {run.stdout.strip() or 'not readable'}")
    if run.returncode:
        raise InputError(f"{source}: not a readable .full file")


def _arrays(path: Path) -> dict[str, Array]:
    """All arrays of a .npz file of one's own."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}
