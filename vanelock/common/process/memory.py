"""How much memory a process may take, what is refused before it runs out, and what it keeps."""

import ctypes
import os
import resource
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, TypeVar

K = TypeVar("K")
V = TypeVar("V")
LEAST, LEAST_SPACE = 0.5e9, 1.5e9
"""Bytes that the libraries and the smallest run take, and of address space."""
SPACE = "the address space that `ulimit -v` allows"
MACHINE, GROUP = "this machine's memory", "this control group's memory"
OF_ITS_OWN = 2**28
"""Bytes from which on an array gets memory of its own, which it returns."""
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_PROC, _GROUPS = Path("/proc"), Path("/sys/fs/cgroup")


class Bound(NamedTuple):
    """What bounds a process: bytes in all, bytes still left, and its name."""

    total: float
    left: float
    name: str


def bounds() -> list[Bound]:
    """What the machine, control groups and `ulimit` let this process take; empty if not known."""
    machine = _numbers(_PROC / "meminfo")
    found = list(_of_groups())
    if "MemTotal" in machine:
        total = machine["MemTotal"]
        found.append(Bound(total, machine.get("MemAvailable", total), MACHINE))
    own = _numbers(_PROC / "self" / "status")
    for limit, field, name in (
        (resource.RLIMIT_AS, "VmSize", SPACE),
        (resource.RLIMIT_DATA, "VmData", "the data that `ulimit -d` allows"),
    ):
        total = resource.getrlimit(limit)[0]
        if total != resource.RLIM_INFINITY:
            found.append(Bound(total, total - own.get(field, 0.0), name))
    return found


def capacity() -> float:
    """Bytes that this process may take in all, whatever else runs now; infinite if not known."""
    return min((each.total for each in bounds()), default=float("inf"))


def require(needed: float, what: str) -> None:
    """Refuse what takes more bytes than are left."""
    for each in bounds():
        if needed > each.left:
            has = f"{gigabytes(max(each.left, 0.0))} of {each.name} are left"
            raise MemoryError(f"{what} takes about {gigabytes(needed)}, {has}")


def largest() -> float:
    """Bytes that this process, or one of those that it started, has held at most."""
    ended = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return 1024.0 * max(resource.getrusage(who).ru_maxrss for who in ended)


def keep_freed() -> None:
    """Have the C library keep what arrays leave for the next ones, all but the largest.

    It returns what an array of 128 kB or more took to the system at once, which then clears each
    page of the next one: a tenth of a run's time. Other C libraries than glibc stay as they are.
    """
    with suppress(AttributeError, OSError):
        set_option = ctypes.CDLL(None).mallopt
        set_option(_MMAP_THRESHOLD, OF_ITS_OWN)
        set_option(_TRIM_THRESHOLD, 2**30)


def require_least() -> None:
    """Refuse to begin where not even the smallest run fits: libraries then fail, or hang.

    OpenBLAS tries for ever to get its buffers.
    """
    for each in bounds():
        least = LEAST_SPACE if each.name == SPACE else LEAST
        if each.total < least:
            has = f"{gigabytes(each.total)} is all of {each.name}"
            raise MemoryError(f"the smallest run takes {gigabytes(least)}, {has}")


def refusal(error: MemoryError) -> str:
    """The line for an error that comes from too little memory."""
    reason = f" ({error})" if str(error) else ""
    return f"not enough memory{reason}: a coarser mesh, fewer harmonics or points take less"


def is_shortage(error: BaseException | None) -> bool:
    """Whether a library could not be loaded for want of memory, as the error or its origin says."""
    if error is None:
        return False
    text = str(error).lower()
    if "failed to map segment" in text or "cannot allocate memory" in text:
        return True
    return is_shortage(error.__cause__ or error.__context__)


def gigabytes(count: float) -> str:
    """Bytes in words."""
    return f"{count / 1e9:.2g} GB" if count < 9.5e9 else f"{count / 1e9:.0f} GB"


def latest(kept: MutableMapping[K, V], key: K, make: Callable[[], V], most: int) -> V:
    """A value that is kept, or made after those that were used longest ago have gone."""
    if key in kept:
        kept[key] = kept.pop(key)
    else:
        while len(kept) >= most:
            del kept[next(iter(kept))]
        kept[key] = make()
    return kept[key]


def _numbers(path: Path) -> dict[str, float]:
    """Fields of a file of /proc in bytes."""
    found = {}
    try:
        for line in path.read_text().splitlines():
            name, _, rest = line.partition(":")
            number, _, unit = rest.strip().partition(" ")
            if unit == "kB":
                found[name] = 1024.0 * int(number)
    except (OSError, ValueError):
        pass
    return found


def _of_groups() -> Iterator[Bound]:
    """Limits of the control groups that this process is in, versions 1 and 2."""
    try:
        lines = (_PROC / "self" / "cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, kinds, own = line.split(":", 2)
        if kinds not in ("", "memory"):
            continue
        root = _GROUPS / kinds
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        most, used, cached = names if kinds else ("memory.max", "memory.current", "inactive_file")
        place = Path(os.path.normpath(f"{root}/{own}"))
        while root == place or root in place.parents:
            total, taken = _number(place / most), _number(place / used)
            if total is not None and taken is not None and total < 1 << 60:
                yield Bound(total, total - taken + _cached(place, cached), GROUP)
            place = place.parent


def _number(path: Path) -> float | None:
    try:
        return float(int(path.read_text()))
    except (OSError, ValueError):  # "max": none
        return None


def _cached(place: Path, field: str) -> float:
    """Bytes of files that the group's limit counts, and that give way."""
    try:
        lines = (place / "memory.stat").read_text().splitlines()
        return float(dict(line.split() for line in lines)[field])
    except (OSError, ValueError, KeyError):
        return 0.0
