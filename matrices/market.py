"""Matrix Market files: text, a list of entries or a full array, one triangle where symmetric.

The format: R. Boisvert, R. Pozo, K. Remington, "The Matrix Market Exchange Formats: Initial
Design", NISTIR 5935, 1996 (math.nist.gov/MatrixMarket/formats.html). Ansys writes it
by `*EXPORT, K, MMF`, SciPy by `scipy.io.mmwrite`.
"""

import io
import re
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

from vanelock.errors import InputError
from vanelock.matrices.choosing import Wanted
from vanelock.matrices.contents import content
from vanelock.matrices.entries import FULL, HERMITIAN, SYMMETRIC, Entries, dense_entries, square

_FORMS = {"general": FULL, "symmetric": SYMMETRIC, "hermitian": HERMITIAN}
_FIELDS = ("real", "double", "complex", "integer", "unsigned-integer")


def read_market(path: Path, wanted: Wanted) -> Entries:
    """Read a .mtx or .mtx.gz file that begins with a Matrix Market banner.

    Raises
    ------
    InputError
        One line with the file's name.
    """
    source, held = str(path), content(path)
    banner, _, rest = held.partition(b"\n")
    words = banner[:200].decode("ascii", "replace").lower().split()
    if len(words) != 5 or words[:2] != ["%%matrixmarket", "matrix"]:
        raise InputError(f"{source}: line 1: not the banner of a Matrix Market matrix")
    layout, field, symmetry = words[2:]
    for word, allowed in (
        (layout, ("coordinate", "array")), (field, _FIELDS), (symmetry, tuple(_FORMS))
    ):  # fmt: skip
        if word not in allowed:
            raise InputError(f"{source}: line 1: {word}: allowed are {', '.join(allowed)}")
    _check_sizes(source, layout, symmetry != "general", rest)
    # Entries one by one, symmetric ones too: what is given twice must not be added.
    general = layout == "coordinate"
    if general:
        banner = " ".join(["%%MatrixMarket", "matrix", layout, field, "general"]).encode()
    try:
        found = scipy.io.mmread(io.BytesIO(banner.strip() + b"\n" + rest), spmatrix=False)
    except (ValueError, OverflowError, MemoryError, IndexError, RuntimeError) as error:
        raise InputError(f"{source}: {_reason(error)}") from None
    if sp.issparse(found):
        coo = found.tocoo()
        form = _FORMS[symmetry]
        return Entries(source, coo.shape[0], coo.row, coo.col, coo.data, form)
    return dense_entries(source, np.asarray(found))


def _check_sizes(source: str, layout: str, half: bool, rest: bytes) -> None:
    """Whether as many entries as the file claims can stand in it, before they get memory."""
    start = 0
    line = b"%"
    while line.startswith(b"%") or not line.strip():
        if start >= len(rest):
            raise InputError(f"{source}: ends before its sizes")
        end = rest.find(b"\n", start)
        end = len(rest) if end < 0 else end
        line, start = rest[start : min(end, start + 1000)].strip(), end + 1
    wanted = 3 if layout == "coordinate" else 2
    words = line.decode("ascii", "replace").split()
    if len(words) != wanted or not all(re.fullmatch(r"\d{1,18}", word) for word in words):
        shown = line[:60].decode("ascii", "replace")
        raise InputError(f"{source}: its sizes are {shown!r}: {wanted} whole numbers are needed")
    sizes = [int(word) for word in words]
    square(source, tuple(sizes[:2]))
    n = sizes[0]
    given = sizes[2] if wanted == 3 else n * (n + 1) // 2 if half else n * n
    shortest = 6 if wanted == 3 else 2  # "1 1 1\n", "1\n"
    left = len(rest) - start + 1
    if given * shortest > left + shortest:
        raise InputError(f"{source}: {given:,} entries are announced, but {left:,} bytes follow")
    if n > left:
        raise InputError(f"{source}: {n:,} rows are announced, but {left:,} bytes follow")


def _reason(error: Exception) -> str:
    """One line of a library's message."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
