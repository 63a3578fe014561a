"""Our cost and error against the Python harmonic balance pyHarm's, on identical matrices.

    python -m benchmarks.solver.peer --peer-python PATH [--quick] [--write]

PATH is the interpreter of an environment of its own in which `pip install pyHarm-os==1.2.2` was
run. The problem is friction under a constant normal load (`jenkins.py`), which both can solve.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.clock import page
from benchmarks.solver.jenkins import Problem, problem, reference
from vanelock.nonlinear import SLIP, SLIP_OPEN, Options, frequency_response

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class Case(NamedTuple):
    """One problem at one number of harmonics; samples and points of the peer."""

    size: int
    contacts: int
    harmonics: int
    samples: tuple[int, ...]
    priced: int = 6


@dataclass(frozen=True)
class Run:
    """What a program made of a list of frequencies.

    Attributes
    ----------
    seconds : (p - 1,) float
        CPU of each point but the first one.
    q : (p, H + 1, 2c) complex
        Displacements of the contacts.
    converged : int
        Points.
    """

    seconds: Floats
    q: Array
    converged: int


def ours(given: Problem, hertz: Floats, harmonics: int, repeat: int = 3) -> tuple[Run, Array]:
    """Our solver at its default tolerance; with all coordinates (p, H + 1, n)."""
    system = given.system()
    times = []
    for _ in range(repeat + 1):  # the first one may compile
        marks: list[float] = []

        def progress(*given: float, marks: list[float] = marks) -> None:
            if given[3] == given[3]:  # a point that is done, not one that is looked for
                marks.append(time.process_time())

        response = frequency_response(system, hertz, Options(harmonics), progress=progress)
        times.append(np.diff(marks))
    q = response.contact[:, :, :, 1:].reshape(len(hertz), harmonics + 1, -1)
    x = np.stack([response.x[h] for h in range(harmonics + 1)], axis=1)
    seconds = np.median(times[1:] or times, axis=0)
    return Run(seconds, q, int(response.converged.sum())), x


def theirs(
    python: str, given: Problem, hertz: Floats, start: Array, samples: int, predictor: str
) -> Run:
    """The peer, odd harmonics only: the others vanish here, and it is cheaper without them.

    It begins at our solution of the first point, because its own linear start often fails.
    """
    harmonics = len(start) - 1
    odd = list(range(1, harmonics + 1, 2))
    force = float(np.abs(given.force).max())
    request: dict[str, Any] = {
        "harmonics": odd,
        "samples": samples,
        "solver": "NewtonRaphson",
        "solver_options": {"tol_residual": 1e-8 * force, "tol_delta_x": 1e9, "max_iter": 40},
        "predictor": predictor,
        "reductor": "noreductor",
    }
    with tempfile.TemporaryDirectory() as folder:
        sent, answer = Path(folder) / "problem.npz", Path(folder) / "result.npz"
        np.savez(
            sent,
            K=given.K,
            M=given.M,
            C=given.C,
            force=given.force,
            kt=given.kt,
            limit=given.limit,
            omegas=2 * np.pi * hertz,
            start=np.concatenate([[start[h].real, -start[h].imag] for h in odd]),
            request=json.dumps(request),
        )
        program = Path(__file__).with_name("peer_pyharm.py")
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | ONE_THREAD
        environment["HOME"] = folder  # the peer writes its state there and where it is run
        done = subprocess.run(
            [python, str(program), str(sent), str(answer)],
            env=environment,
            cwd=folder,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise SystemExit(f"the peer failed:\n{done.stderr[-2000:]}")
        result = np.load(answer)
        x = result["x"][:, :, : given.directions]
    q = np.zeros((len(hertz), harmonics + 1, given.directions), complex)
    for place, h in enumerate(odd):
        q[:, h] = x[:, 2 * place] - 1j * x[:, 2 * place + 1]
    assert np.allclose(result["omegas"], 2 * np.pi * hertz, rtol=1e-9) or not all(
        result["accepted"]
    )
    return Run(result["seconds"], q, int(result["accepted"].sum()))


PREDICTORS = ("previous", "secant", "tangent")
CASES = (
    Case(12, 2, 1, (64, 1024, 16384)),
    Case(12, 2, 5, (64, 1024, 16384)),
    Case(60, 10, 1, (64, 1024, 4096)),
    Case(60, 10, 3, (64, 1024, 4096)),
    Case(60, 10, 5, (64, 1024, 4096)),
    Case(504, 66, 1, (64, 256, 1024), priced=3),
    Case(504, 66, 3, (64, 256), priced=3),
)
QUICK = (Case(12, 2, 1, (64, 256)),)
POINTS = 40
SEVERITY = 30.0


def band(given: Problem) -> tuple[Floats, float]:
    """Frequencies, Hz, at which most contacts slip, and the peak over the stuck one."""
    resonance = given.resonance()
    coarse = np.linspace(0.5 * resonance, 1.3 * resonance, 161)
    response = frequency_response(given.system(), coarse, Options(1))
    slips = np.isin(response.state, (SLIP, SLIP_OPEN)).mean(axis=1) > 0.5
    moved = np.abs(response.contact[:, 1, :, 1:]).max(axis=(1, 2))
    s = 2 * np.pi * resonance
    stuck = np.abs(np.linalg.solve(given.dynamic(s, stuck=True), given.force))
    low, high = coarse[slips][0], coarse[slips][-1]
    return np.linspace(low, high, POINTS), float(moved.max() / stuck[: given.directions].max())


def deviation(q: Array, exact: Array) -> float:
    """Largest difference, relative to the largest displacement of its point."""
    return float((np.abs(q - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))).max())


def rows(python: str, case: Case) -> tuple[list[str], str]:
    """Lines of the table for one case, and the one of the table at equal errors."""
    given = problem(case.size, case.contacts, SEVERITY)
    hertz, lowered = band(given)
    whole, x = ours(given, hertz, case.harmonics)
    top = int(np.abs(whole.q[:, 1]).max(axis=(1)).argmax())
    first = min(max(top - case.priced // 2, 0), POINTS - case.priced)
    chosen = slice(first, first + case.priced)
    count = 32768 if case.contacts < 20 else 8192
    exact = np.array(
        [
            reference(given, float(f), q, count)[0]
            for f, q in zip(hertz[chosen], whole.q[chosen], strict=True)
        ]
    )
    cheapest, best = np.inf, ""
    for predictor in PREDICTORS if case.size < 100 else PREDICTORS[:1]:
        run = theirs(python, given, hertz[chosen], x[first], case.samples[0], predictor)
        if run.converged == case.priced and run.seconds.mean() < cheapest:
            cheapest, best = run.seconds.mean(), predictor
    lines, errors, ratios = [], [], []
    for samples in case.samples:
        before, _ = ours(given, hertz, case.harmonics)
        run = theirs(python, given, hertz[chosen], x[first], samples, best or PREDICTORS[0])
        after, _ = ours(given, hertz, case.harmonics)
        own = 0.5 * (before.seconds + after.seconds)[first : first + case.priced - 1].mean()
        errors.append(deviation(run.q, exact))
        ratios.append(float(run.seconds.mean() / own))
        lines.append(
            f"| {case.size} | {case.contacts} | {case.harmonics} | {lowered:.2f} | {samples} | "
            f"{run.converged} / {case.priced} | {errors[-1]:.1e} | "
            f"{deviation(whole.q[chosen], exact):.1e} | {1e3 * run.seconds.mean():.1f} ms | "
            f"{1e3 * own:.2f} ms | {ratios[-1]:.0f} |"
        )
        print(lines[-1], flush=True)
    return lines, at_errors(case, errors, ratios)


HEADER = (
    "| dofs | contacts | H | peak | samples | converged | error, pyHarm | error, ours |"
    " pyHarm | ours | ratio |",
    "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
)
ABOUT = """
CPU time of a frequency point, one thread, of pyHarm 1.2.2 and of `frequency_response`, on the
same matrices at the same frequencies: six (three for the largest problem) at the peak of the
response, of forty in the band in which most contacts slip. Peak: the largest amplitude over that
of the stuck structure. Each contact is two Jenkins elements of constant normal load on coordinates
of their own. Imports, compilation, the building of either model and the first point are not
counted.

How the peer was used: its analysis `frf`, Newton's method (`NewtonRaphson`) at fixed frequencies
(`nocontinuation`, constant steps), analytic Jacobians, no determinants for bifurcations, no
reduction, one cosine force element, and odd harmonics only, since the others vanish here; ours
solves for all. Its predictor is the cheapest of three that converged at all points; for the
largest problem, where a trial of all three showed no difference, the last solution. In trials on
12 and 60 coordinates with 128 samples `scipyroot` lost most points, and `NLdofs` took 1.5 to 2
times as long; neither was tried on the largest. It begins at our solution of the first point,
because on the largest problem its own linear start did not converge. It stops at a residual of
1e-8 of the force, ours at 1e-10.

Both have the same damping; ours is given its modal ratio, the peer the matrix.

Errors: the largest of the contact displacements, all harmonics, of those points, relative to the
largest displacement, against a Newton iteration written apart on forces marched on 32768 samples
(8192 for the largest problem), which bounds what is said of our error. The peer samples the law,
and its error falls with its samples, about as their square, while events are located in ours.
The second table gives the ratio of CPU time where the peer's error is the one at the head of the
column, along the lines between its runs; in brackets, continued beyond them.
"""
LEVELS = (1e-3, 1e-5, 1e-7)


def at_errors(case: Case, errors: list[float], ratios: list[float]) -> str:
    """One line: the ratio where the peer's error is 1e-3, 1e-5, 1e-7."""
    x, y = np.log(errors)[::-1], np.log(ratios)[::-1]
    cells = []
    for level in np.log(LEVELS):
        place = int(np.clip(np.searchsorted(x, level), 1, len(x) - 1))
        slope = (y[place] - y[place - 1]) / (x[place] - x[place - 1])
        ratio = np.exp(y[place] + slope * (level - x[place]))
        cells.append(f"{ratio:.0f}" if x[0] <= level <= x[-1] else f"({ratio:.0f})")
    return f"| {case.size} | {case.contacts} | {case.harmonics} | " + " | ".join(cells) + " |"


def interpreter(path: str | None) -> str:
    """The peer's interpreter, checked."""
    hint = "an environment of its own with `pip install pyHarm-os==1.2.2`"
    if path is None:
        raise SystemExit(f"--peer-python: not given: needs the interpreter of {hint}")
    try:
        done = subprocess.run(
            [path, "-c", "import importlib.util as i; assert i.find_spec('pyHarm')"],
            capture_output=True,
        )
    except OSError as error:
        raise SystemExit(f"--peer-python: given {path}: {error.strerror}: needs {hint}") from None
    if done.returncode:
        raise SystemExit(f"--peer-python: given {path}: it cannot import pyHarm: needs {hint}")
    return path


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--peer-python", help="interpreter of an environment with pyHarm")
    parser.add_argument("--quick", action="store_true", help="one small case")
    parser.add_argument("--sizes", type=int, nargs="+", help="only problems of these sizes")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    python = interpreter(options.peer_python)
    lines = [ABOUT.strip(), "", *HEADER]
    levels = ["", "| dofs | contacts | H | 1e-3 | 1e-5 | 1e-7 |", "|---:|---:|---:|---:|---:|---:|"]
    print("\n".join(HEADER), flush=True)
    with threadpool_limits(limits=1):
        for case in QUICK if options.quick else CASES:
            if options.sizes and case.size not in options.sizes:
                continue
            measured, level = rows(python, case)
            lines += measured
            levels.append(level)
    page("peer", "Against pyHarm, at equal error", [*lines, *levels], options.write)


if __name__ == "__main__":
    main()
