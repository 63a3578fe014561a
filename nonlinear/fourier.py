"""Real trigonometric polynomials, and the compiled kernels that they and others are.

Kernels are kept on disk by the sources that they were made of. A cached kernel contains the code of
the kernels that it calls, but Numba looks at the age of its own file only. Each state of the
sources therefore gets its own folder of cached code.

A polynomial of degree H is its 2H + 1 coefficients (a_0, Re a_1, Im a_1, ..., Re a_H, Im a_H), so
that with θ = ωt

    a(θ) = a_0 + Σ_h Re(a_h e^{ihθ}) = Σ_k a_k φ_k(θ),     φ = (1, cos θ, -sin θ, cos 2θ, ...).
"""

import hashlib
import math
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from threadpoolctl import threadpool_limits

from vanelock.common.arrays import Complex, Floats
from vanelock.common.errors import InputError

try:
    import numba
except ValueError as error:
    if "threads" not in str(error):
        raise
    threads = os.environ.get("NUMBA_NUM_THREADS")
    raise InputError(f"NUMBA_NUM_THREADS = {threads}: must be a whole number above 0") from None

Function = TypeVar("Function", bound=Callable[..., Any])


def _sources() -> list[Path]:
    """The files of `nonlinear` that hold kernels."""
    files = sorted(Path(__file__).resolve().parent.rglob("*.py"))
    return [path for path in files if "\n@kernel" in path.read_text("utf-8")]


@lru_cache(maxsize=1)
def _folder() -> str | None:
    """Where compiled code is kept; none where nothing can be written: it is then compiled anew."""
    here = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    for source in _sources():
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


def kernel(function: Function) -> Function:
    """Compile a function when it is first called, or load what an earlier run compiled."""
    settings, folder = vars(numba.config), _folder()
    if folder is None:
        return cast(Function, numba.njit(function))
    given = settings["CACHE_DIR"]
    settings["CACHE_DIR"] = folder
    try:
        compiled = numba.njit(cache=True)(function)
    finally:
        settings["CACHE_DIR"] = given
    return cast(Function, compiled)


def one_thread(function: Function) -> Function:
    """Hold BLAS to one thread while `function` runs.

    The matrices of a point are too small for several: two threads save nothing on an idle machine,
    and cost a factor of thirty where other work keeps one of them waiting for its core.
    """
    return cast(Function, threadpool_limits.wrap(limits=1, user_api="blas")(function))


TURN = 2.0 * math.pi


def basis(harmonics: int, angles: Floats) -> Floats:
    """(s, 2H + 1) values of φ at the angles (s,), rad."""
    h = np.arange(1, harmonics + 1)
    table = np.ones((len(angles), 2 * harmonics + 1))
    table[:, 1::2] = np.cos(np.outer(angles, h))
    table[:, 2::2] = -np.sin(np.outer(angles, h))
    return table


def grid(harmonics: int, count: int | None = None) -> Floats:
    """φ at uniform angles; by default those that bracket roots: 32, or 16 in the shortest wave."""
    count = count or max(32, 16 * harmonics)
    return basis(harmonics, TURN * np.arange(count) / count)


def to_real(q: Complex) -> Floats:
    """One-sided complex coefficients (H + 1, ...) as real ones, (..., 2H + 1)."""
    real = np.empty((*q.shape[1:], 2 * len(q) - 1))
    real[..., 0] = q[0].real
    real[..., 1::2] = np.moveaxis(q[1:].real, 0, -1)
    real[..., 2::2] = np.moveaxis(q[1:].imag, 0, -1)
    return real


def to_complex(a: Floats) -> Complex:
    """Real coefficients (..., 2H + 1) as one-sided complex ones, (H + 1, ...)."""
    q = np.empty(((a.shape[-1] + 1) // 2, *a.shape[:-1]), complex)
    q[0] = a[..., 0]
    q[1:] = np.moveaxis(a[..., 1::2] + 1j * a[..., 2::2], -1, 0)
    return q


def resized(a: Floats, harmonics: int) -> Floats:
    """Real coefficients (..., 2H + 1) of another number of harmonics, zeros where none were."""
    out = np.zeros((*a.shape[:-1], 2 * harmonics + 1))
    shared = min(out.shape[-1], a.shape[-1])
    out[..., :shared] = a[..., :shared]
    return out


@kernel
def value(a: Floats, angle: float) -> float:
    """a(θ)."""
    c, s = math.cos(angle), math.sin(angle)
    ch, sh = 1.0, 0.0
    total = a[0]
    for h in range(1, (a.size + 1) // 2):
        ch, sh = ch * c - sh * s, sh * c + ch * s
        total += a[2 * h - 1] * ch - a[2 * h] * sh
    return float(total)


@kernel
def value_and_slope(a: Floats, angle: float) -> tuple[float, float]:
    """a(θ) and da/dθ."""
    c, s = math.cos(angle), math.sin(angle)
    ch, sh = 1.0, 0.0
    total, slope = a[0], 0.0
    for h in range(1, (a.size + 1) // 2):
        ch, sh = ch * c - sh * s, sh * c + ch * s
        total += a[2 * h - 1] * ch - a[2 * h] * sh
        slope -= h * (a[2 * h - 1] * sh + a[2 * h] * ch)
    return total, slope


@kernel
def derivative(a: Floats) -> Floats:
    """Coefficients of da/dθ: every a_h times ih."""
    d = np.zeros(a.size)
    for h in range(1, (a.size + 1) // 2):
        d[2 * h - 1] = -h * a[2 * h]
        d[2 * h] = h * a[2 * h - 1]
    return d


@kernel
def spread(a: Floats) -> float:
    """Σ |a_h| over h >= 1: no value is further from the mean (and one is as far, if H = 1)."""
    total = 0.0
    for h in range(1, (a.size + 1) // 2):
        total += math.hypot(a[2 * h - 1], a[2 * h])
    return total


@kernel
def crossing(a: Floats, level: float, begin: float, end: float) -> float:
    """The angle between `begin` and `end` where a(θ) = level, which must lie between its values.

    Newton's iteration kept inside a shrinking bracket, to the last bits. Where the values at the
    ends have the same sign, one of them is zero but for rounding, and that is the root: a caller
    who found a change of sign by other arithmetic gets it, too.
    """
    f_begin = value(a, begin) - level
    f_end = value(a, end) - level
    if f_begin == 0.0:
        return begin
    if f_end == 0.0:
        return end
    if (f_begin > 0.0) == (f_end > 0.0):
        return begin if abs(f_begin) < abs(f_end) else end
    angle = begin - f_begin * (end - begin) / (f_end - f_begin)
    for _ in range(80):
        f, slope = value_and_slope(a, angle)
        f -= level
        if f == 0.0:
            return angle
        if (f > 0.0) == (f_begin > 0.0):
            begin = angle
        else:
            end = angle
        step = -f / slope if slope != 0.0 else 10.0
        if abs(step) <= 2e-16 * max(1.0, abs(angle)):
            return angle
        following = angle + step
        if not begin < following < end:
            following = 0.5 * (begin + end)
            if following <= begin or following >= end:
                return following
        angle = following
    return angle


@kernel
def roots(a: Floats, table: Floats, angles: Floats) -> int:
    """Angles in [0, 2π) where a changes sign, ascending into `angles`; returns how many.

    `table` holds φ on a uniform grid. Between two of its points of equal sign a pair of roots is
    found through the extremum between them, so that only a pair that comes with a second extremum
    in the same sixteenth of the shortest wave could escape. Their number is even, and at the first
    one a falls if a(0) >= 0; slopes at roots would not say so where a only touches zero.
    """
    if abs(a[0]) >= spread(a):  # touching zero is not crossing it
        return 0
    slopes = derivative(a)
    size = table.shape[0]
    count = 0
    f_first, d_first = 0.0, 0.0
    for k in range(a.size):
        f_first += table[0, k] * a[k]
        d_first += table[0, k] * slopes[k]
    f, d = f_first, d_first
    for i in range(size):
        if count + 2 > angles.size:  # a degree H has 2H roots; more are rounding
            break
        if i + 1 < size:
            f_next, d_next = 0.0, 0.0
            for k in range(a.size):
                f_next += table[i + 1, k] * a[k]
                d_next += table[i + 1, k] * slopes[k]
        else:
            f_next, d_next = f_first, d_first
        begin, end = TURN * i / size, TURN * (i + 1) / size
        above = f >= 0.0
        if above != (f_next >= 0.0):
            angles[count] = crossing(a, 0.0, begin, end)
            count += 1
        elif (d < 0.0 and d_next > 0.0) if above else (d > 0.0 and d_next < 0.0):
            middle = crossing(slopes, 0.0, begin, end)
            if (value(a, middle) >= 0.0) != above:
                angles[count] = crossing(a, 0.0, begin, middle)
                angles[count + 1] = crossing(a, 0.0, middle, end)
                count += 2
        f, d = f_next, d_next
    return count


@kernel
def add_integrals(begin: float, end: float, moments: Complex) -> None:
    """Add ∫ e^{ikθ} dθ from begin to end to moments[k], k = 0, 1, ..."""
    moments[0] += end - begin
    if end - begin == TURN:
        return
    first, last = complex(math.cos(begin), math.sin(begin)), complex(math.cos(end), math.sin(end))
    p, q = complex(1.0, 0.0), complex(1.0, 0.0)
    for k in range(1, moments.size):
        p *= first
        q *= last
        moments[k] += (q - p) * complex(0.0, -1.0 / k)


@kernel
def basis_at(angle: float, phi: Floats) -> None:
    """φ(θ) into `phi`."""
    c, s = math.cos(angle), math.sin(angle)
    ch, sh = 1.0, 0.0
    phi[0] = 1.0
    for h in range(1, (phi.size + 1) // 2):
        ch, sh = ch * c - sh * s, sh * c + ch * s
        phi[2 * h - 1] = ch
        phi[2 * h] = -sh


@kernel
def gram(moments: Complex, out: Floats) -> None:
    """∫ φ_j φ_k dθ from the moments ∫ e^{ikθ} dθ, k = 0 ... 2H, of the same angles."""
    harmonics = (out.shape[0] - 1) // 2
    for i in range(harmonics + 1):
        for j in range(i, harmonics + 1):
            total, difference = moments[i + j], moments[j - i]
            cc = 0.5 * (difference.real + total.real)
            ss = 0.5 * (difference.real - total.real)
            i_sin_j = -0.5 * (total.imag + difference.imag)  # cos iθ · (-sin jθ)
            j_sin_i = -0.5 * (total.imag - difference.imag)  # cos jθ · (-sin iθ)
            ci, cj = max(2 * i - 1, 0), max(2 * j - 1, 0)
            out[ci, cj] = cc
            out[cj, ci] = cc
            if j > 0:
                out[ci, 2 * j] = i_sin_j
                out[2 * j, ci] = i_sin_j
            if i > 0:
                out[2 * i, 2 * j] = ss
                out[2 * j, 2 * i] = ss
                out[cj, 2 * i] = j_sin_i
                out[2 * i, cj] = j_sin_i
