"""Compiled kernels, kept on disk by the sources that they were made of.

A cached kernel contains the code of the kernels that it calls, but Numba looks at the age of its
own file only. Each state of the sources therefore gets its own folder of cached code.
"""

import hashlib
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TypeVar, cast

from vanelock.common.errors import InputError

try:
    import numba
except ValueError as error:
    if "threads" not in str(error):
        raise
    threads = os.environ.get("NUMBA_NUM_THREADS")
    raise InputError(f"NUMBA_NUM_THREADS = {threads}: must be a whole number above 0") from None

Kernel = TypeVar("Kernel", bound=Callable[..., object])


def sources() -> list[Path]:
    """The files of `nonlinear` that hold kernels."""
    files = sorted(Path(__file__).resolve().parents[1].rglob("*.py"))
    return [path for path in files if "\n@kernel" in path.read_text("utf-8")]


@lru_cache(maxsize=1)
def _folder() -> str | None:
    """Where compiled code is kept; none where nothing can be written: it is then compiled anew."""
    here = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    for source in sources():
        digest.update(source.read_bytes())
    chosen = vars(numba.config)["CACHE_DIR"]
    if chosen:
        base = Path(chosen)
    elif os.access(here, os.W_OK):
        base = here / "__pycache__"
    else:
        base = Path.home() / ".cache" / "vanelock"
    folder = base / f"kernels-{digest.hexdigest()[:12]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return str(folder) if os.access(folder, os.W_OK | os.X_OK) else None


def kernel(function: Kernel) -> Kernel:
    """Compile a function when it is first called, or load what an earlier run compiled."""
    settings, folder = vars(numba.config), _folder()
    if folder is None:
        return cast(Kernel, numba.njit(function))
    given = settings["CACHE_DIR"]
    settings["CACHE_DIR"] = folder
    try:
        compiled = numba.njit(cache=True)(function)
    finally:
        settings["CACHE_DIR"] = given
    return cast(Kernel, compiled)
