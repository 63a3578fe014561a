"""Our cost and error against the Python harmonic balance pyHarm's, on identical matrices.

    python benchmarks/peer.py --peer-python PATH [--quick] [--write]

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
from clock import page
from jenkins import Problem, problem, reference
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from vanelock.nonlinear import frequency_response

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
SOLVERS = {
    "NewtonRaphson": lambda force: {
        "tol_residual": 1e-8 * force,
        "tol_delta_x": 1e9,
        "max_iter": 40,
    },
    "scipyroot": lambda force: {"residual_tolerance": 1e-6 * force},
}


class Case(NamedTuple):
    """One problem at one number of harmonics."""

    size: int
    contacts: int
    harmonics: int
    points: int


@dataclass(frozen=True)
class Run:
    """What a program made of a case.

    Attributes
    ----------
    seconds : float
        CPU a point, the first one and the set-up aside.
    q : (p, H + 1, 2c) complex
        Displacements of the contacts.
    start : (H + 1, n) complex
        All coordinates at the first point.
    converged : int
        Points.
    """

    seconds: float
    q: Array
    start: Array
    converged: int


def ours(given: Problem, hertz: Floats, harmonics: int, repeat: int) -> Run:
    """Our solver, at its default tolerance."""
    system = given.system()
    best = np.inf
    for _ in range(repeat + 1):  # the first one may compile
        marks: list[float] = []

        def progress(*_: float, marks: list[float] = marks) -> None:
            marks.append(time.process_time())

        response = frequency_response(system, hertz, harmonics, progress=progress)
        best = min(best, float(np.diff(marks).mean()))
    q = response.contact[:, :, :, 1:].reshape(len(hertz), harmonics + 1, -1)
    start = np.array([response.x[h][0] for h in range(harmonics + 1)])
    return Run(best, q, start, int(response.converged.sum()))


def theirs(
    python: str, given: Problem, hertz: Floats, start: Array, samples: int, **options: str
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
        "solver_options": SOLVERS[options["solver"]](force),
        **options,
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
        done = subprocess.run(
            [python, str(program), str(sent), str(answer)],
            env=environment,
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
    return Run(float(np.mean(result["seconds"])), q, start, int(result["accepted"].sum()))


PREDICTORS = ("previous", "secant", "tangent")
CASES = (
    Case(12, 2, 1, 40),
    Case(12, 2, 3, 40),
    Case(12, 2, 5, 40),
    Case(60, 10, 1, 40),
    Case(60, 10, 3, 40),
    Case(60, 10, 5, 40),
    Case(200, 30, 1, 20),
    Case(504, 66, 1, 6),
)
QUICK = (Case(12, 2, 1, 10),)
SAMPLES = (64, 256, 1024, 4096)
CHECKED = 3  # points at which errors are measured


def peak(given: Problem, harmonics: int, points: int) -> Floats:
    """Frequencies, Hz, a fine list that ends a little above the peak of the response."""
    resonance = given.resonance()
    coarse = np.linspace(0.65 * resonance, 1.05 * resonance, 81)
    found = ours(given, coarse, 1, 0)
    top = int(np.abs(found.q[:, 1]).max(axis=1).argmax())
    width = coarse[1] - coarse[0]
    step = 0.25 * width
    return np.asarray(coarse[top] + step * (np.arange(points) - points + 4))


def errors(run: Run, exact: dict[int, Array]) -> float:
    """Largest error at the checked points, relative to the largest displacement of each."""
    return max(float(np.abs(run.q[i] - q).max() / np.abs(q).max()) for i, q in exact.items())


def rows(python: str, case: Case, samples: tuple[int, ...]) -> list[str]:
    """Lines of the table for one case."""
    given = problem(case.size, case.contacts, severity=5.0)
    hertz = peak(given, case.harmonics, case.points)
    first = ours(given, hertz, case.harmonics, 1)
    exact = {
        i: reference(given, float(hertz[i]), first.q[i])[0]
        for i in range(case.points - CHECKED, case.points)
    }
    trial, best = hertz[: min(6, case.points)], ""
    cheapest = np.inf
    for predictor in PREDICTORS:
        run = theirs(
            python,
            given,
            trial,
            first.start,
            samples[0],
            solver="NewtonRaphson",
            predictor=predictor,
            reductor="noreductor",
        )
        if run.converged == len(trial) and run.seconds < cheapest:
            cheapest, best = run.seconds, predictor
    lines = []
    for count in samples:
        before = ours(given, hertz, case.harmonics, 1).seconds
        run = theirs(
            python,
            given,
            hertz,
            first.start,
            count,
            solver="NewtonRaphson",
            predictor=best or PREDICTORS[0],
            reductor="noreductor",
        )
        own = 0.5 * (before + ours(given, hertz, case.harmonics, 1).seconds)
        lines.append(
            f"| {case.size} | {case.contacts} | {case.harmonics} | {count} | {best or 'none'} | "
            f"{run.converged} / {case.points} | {errors(run, exact):.1e} | "
            f"{errors(first, exact):.1e} | {1e3 * run.seconds:.1f} ms | {1e3 * own:.2f} ms | "
            f"{run.seconds / own:.0f} |"
        )
        print(lines[-1], flush=True)
    return lines


HEADER = (
    "| dofs | contacts | H | samples | predictor | converged | error, pyHarm | error, ours |"
    " pyHarm | ours | ratio |",
    "|---:|---:|---:|---:|---|---:|---:|---:|---:|---:|---:|",
)
ABOUT = """
CPU time of a frequency point, one thread, of pyHarm 1.2.2 and of `frequency_response`, on the
same matrices, at the same frequencies up to and across the peak of the response in gross slip.
Imports, compilation, the building of either model and the first point are not counted. Each
contact is two Jenkins elements of constant normal load on coordinates of their own.

How the peer was used: analysis `frf` with Newton's method at a fixed frequency
(`NewtonRaphson`, `nocontinuation`; its `scipyroot` lost most points), constant steps along the
list, the cheapest predictor of three that converged everywhere, analytic Jacobians, no
determinants for bifurcations, odd harmonics only (the others vanish here, which halves its
unknowns; ours solves for all), no reduction (`NLdofs` was slower on each size), one cosine force
element. It begins at our solution of the first point. Its residual is brought below 1e-8 of the
force; ours below 1e-10 relative. A point costs it Newton's steps and three more evaluations of the
Jacobian that the analysis asks for.

Errors: largest of the last three points' contact displacements, all harmonics, against a Newton
iteration written apart on 8192 marched samples, whose own error is near 1e-8. The peer samples the
law, so that its error falls as its samples grow; events are located in ours. Lines at which the
peer's error is what an engineer accepts are to be compared with an error of ours that is smaller
still: equal error asks for the last lines.
"""


def interpreter(path: str | None) -> str:
    """The peer's interpreter, checked."""
    hint = "an environment of its own with `pip install pyHarm-os==1.2.2`"
    if path is None:
        raise SystemExit(f"--peer-python: not given: needs the interpreter of {hint}")
    try:
        done = subprocess.run([path, "-c", "import pyHarm"], capture_output=True, text=True)
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
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    python = interpreter(options.peer_python)
    lines = [ABOUT.strip(), "", *HEADER]
    print("\n".join(HEADER), flush=True)
    with threadpool_limits(limits=1):
        for case in QUICK if options.quick else CASES:
            count = 2 if options.quick else 3 if case.size > 100 else 4
            lines += rows(python, case, SAMPLES[:count])
    page("peer", "Against pyHarm, at equal error", lines, options.write)


if __name__ == "__main__":
    main()
