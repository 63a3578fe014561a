"""Our cost and error against the Python harmonic balance pyHarm's, on identical matrices.

    python -m benchmarks.peers.peer --peer-python PATH [--quick] [--write]

PATH is the interpreter of an environment of its own in which `pip install pyHarm-os==1.2.2` was
run. The problem is friction under a constant normal load (`jenkins.py`), which both can solve.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.pages import page
from benchmarks.solver.jenkins import Problem, problem, reference
from vanelock.nonlinear import SLIP, SLIP_OPEN, Options, frequency_response
from vanelock.nonlinear.contact.sampling import FRICTIONS

Floats = NDArray[np.float64]
Array = NDArray[np.complex128]

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class Case(NamedTuple):
    """One problem at one number of harmonics; samples of the peer, points of a call."""

    size: int
    contacts: int
    harmonics: int
    samples: tuple[int, ...]
    points: int = 100
    checked: int = 5
    marched: int = 32768  # samples of the reference


@dataclass(frozen=True)
class Run:
    """What a program made of a list of frequencies.

    Attributes
    ----------
    seconds : float
        CPU of the whole call.
    q : (p, H + 1, 2c) complex
        Displacements of the contacts.
    converged : int
        Points.
    start : (H + 1, n) complex
        All coordinates at the first point.
    """

    seconds: float
    q: Array
    converged: int
    start: Array


def ours(given: Problem, hertz: Floats, options: Options) -> Run:
    """Our solver at its default tolerance."""
    system = given.system()
    begin = time.process_time()
    response = frequency_response(system, hertz, options, find_jumps=False)
    seconds = time.process_time() - begin
    q = response.contact[:, :, :, 1:].reshape(len(hertz), -1, given.directions)
    start = np.stack([response.x[h][0] for h in range(q.shape[1])])
    return Run(seconds, q, int(response.converged.sum()), start)


def theirs(
    python: str,
    given: Problem,
    hertz: Floats,
    options: Options,
    start: Array,
    samples: Sequence[int],
) -> tuple[list[Run], str]:
    """The peer with each number of samples, and the predictor that it took.

    Odd harmonics only: the others vanish here, and it is cheaper without them. It begins at our
    solution of the first point, because its own linear start often fails.
    """
    harmonics = len(start) - 1
    odd = list(range(1, harmonics + 1, 2))
    force = float(np.abs(given.force).max())
    request: dict[str, Any] = {
        "harmonics": odd,
        "samples": samples,
        "friction": options.friction,
        "solver": "NewtonRaphson",
        "solver_options": {"tol_residual": 1e-8 * force, "tol_delta_x": 1e9, "max_iter": 40},
        "predictors": PREDICTORS,
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
        result = dict(np.load(answer))
    runs = []
    for x, seconds, accepted, omegas in zip(
        result["x"], result["seconds"], result["accepted"], result["omegas"], strict=True
    ):
        q = np.zeros((len(hertz), harmonics + 1, given.directions), complex)
        for place, h in enumerate(odd):
            pair = x[:, 2 * place : 2 * place + 2, : given.directions]
            q[:, h] = pair[:, 0] - 1j * pair[:, 1]
        assert np.allclose(omegas, 2 * np.pi * hertz, rtol=1e-9) or not accepted.all()
        runs.append(Run(float(seconds), q, int(accepted.sum()), start))
    return runs, str(result["predictor"])


PREDICTORS = ("previous", "secant", "tangent")
CASES = (
    Case(12, 2, 1, (64, 512, 2048)),
    Case(60, 10, 1, (64, 512)),
    Case(504, 66, 1, (64, 256), points=10, marched=8192),
    Case(60, 10, 3, (64, 256)),
    Case(504, 66, 3, (64, 256), points=4, checked=4, marched=8192),
)
QUICK = (Case(12, 2, 1, (64, 256), points=10),)
SEVERITY = 30.0


def band(given: Problem, points: int) -> Floats:
    """Frequencies, Hz, from the first to the last at which most contacts slip."""
    resonance = given.resonance()
    coarse = np.linspace(0.5 * resonance, 1.3 * resonance, 81)
    response = frequency_response(given.system(), coarse, Options(1))
    slips = np.isin(response.state, (SLIP, SLIP_OPEN)).mean(axis=1) > 0.5
    return np.linspace(coarse[slips][0], coarse[slips][-1], points)


def deviation(q: Array, exact: Array) -> float:
    """Largest difference, relative to the largest displacement of its point."""
    return float((np.abs(q - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))).max())


def rows(python: str, case: Case, friction: str) -> tuple[list[str], str]:
    """Lines of the table for one case and law, and the one of the table at equal errors."""
    given = problem(case.size, case.contacts, SEVERITY)
    hertz, options = band(given, case.points), Options(case.harmonics, friction=friction)
    own = ours(given, hertz, options)  # compiles
    chosen = np.linspace(0, case.points - 1, case.checked).round().astype(int)
    exact = np.array(
        [reference(given, float(hertz[i]), own.q[i], case.marched, friction)[0] for i in chosen]
    )
    before = ours(given, hertz, options).seconds
    runs, predictor = theirs(python, given, hertz, options, own.start, case.samples)
    seconds = 0.5 * (before + ours(given, hertz, options).seconds)
    named = f"| {friction} | {case.size} | {case.contacts} | {case.harmonics} |"
    error = deviation(own.q[chosen], exact)
    errors = [deviation(run.q[chosen], exact) for run in runs]
    ratios = [run.seconds / seconds for run in runs]
    lines = [
        f"{named} {case.points} | {samples} | {run.converged} / {own.converged} | {off:.1e} | "
        f"{error:.1e} | {run.seconds:.2f} s | {seconds:.3f} s | {ratio:.0f} |"
        for samples, run, off, ratio in zip(case.samples, runs, errors, ratios, strict=True)
    ]
    print("\n".join(lines), predictor, flush=True)
    return lines, f"{named} " + " | ".join(at_errors(errors, ratios)) + " |"


HEADER = (
    "| law | dofs | contacts | H | points | samples | converged | error, pyHarm | error, ours |"
    " pyHarm | ours | ratio |",
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
)
LEVELS_HEADER = (
    "| law | dofs | contacts | H | 1e-3 | 1e-5 | 1e-7 |",
    "|---|---:|---:|---:|---:|---:|---:|",
)
ABOUT = """
CPU time of a whole call, one thread, of pyHarm 1.2.2 and of `frequency_response`, on the same
matrices, with the same law at the same frequencies, equally spaced over the band in which most
contacts slip. Each natural shape of the structure occurs twice, at right angles and 1 % apart in
frequency, and the load goes round: contacts move on ellipses, and the two laws differ. A call
solves all its points; in ours it sums modes and makes tables, too. Imports, compilation and the
building of either model are not counted. Fewer points than 100 where the peer takes too long.

Laws: pyHarm's element `Jenkins` bounds the length of the force in all its directions together.
Under constant normal load one element for each direction is `Options(friction="orthogonal")`, one
for both is `"isotropic"`. Its others have no equal here: `DLFTFriction` has no tangential
stiffness; the normal force of `Penalty3D` jumps from zero back to the preload where the contact
opens, and without preload its friction is zero.

How the peer was used: its analysis `frf`, Newton's method (`NewtonRaphson`) at fixed frequencies
(`nocontinuation`, constant steps), analytic Jacobians, no determinants for bifurcations, no
reduction, and odd harmonics only, since the others vanish here; ours solves for all. Its predictor
is the one of three that took least over the first four points. It begins at our solution of the
first point, because its own linear start often fails. It stops at a residual of 1e-8 of the force,
ours at 1e-10. Neither looks for jumps. Both have the same damping; ours is given its modal ratio,
the peer the matrix.

Errors: the largest of the contact displacements, all harmonics, at five of the points, relative to
the largest displacement, against a Newton iteration written apart on forces marched on 32768
samples (8192 for the largest problem), in the plane by the generalised midpoint rule: its own
error falls as the square of the samples and bounds what is said of ours. The peer samples the law,
in the plane by radial return; events are located in ours. The second table gives the ratio of CPU
time where the peer's error is the one at the head of the column, along the lines between its runs;
in brackets, continued beyond them. Ours is at its own, smaller error throughout.
"""
LEVELS = (1e-3, 1e-5, 1e-7)


def at_errors(errors: list[float], ratios: list[float]) -> list[str]:
    """The ratios where the peer's error is 1e-3, 1e-5, 1e-7."""
    x, y = np.log(errors)[::-1], np.log(ratios)[::-1]
    cells = []
    for level in np.log(LEVELS):
        place = int(np.clip(np.searchsorted(x, level), 1, len(x) - 1))
        slope = (y[place] - y[place - 1]) / (x[place] - x[place - 1])
        ratio = np.exp(y[place] + slope * (level - x[place]))
        cells.append(f"{ratio:.0f}" if x[0] <= level <= x[-1] else f"({ratio:.0f})")
    return cells


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
    lines: list[str] = []
    levels: list[str] = []
    print("\n".join(HEADER), flush=True)
    with threadpool_limits(limits=1):
        for case in QUICK if options.quick else CASES:
            if options.sizes and case.size not in options.sizes:
                continue
            for friction in FRICTIONS:
                measured, level = rows(python, case, friction)
                lines += measured
                levels.append(level)
                report = [ABOUT.strip(), "", *HEADER, *lines, "", *LEVELS_HEADER, *levels]
                page("peer", "Against pyHarm, at equal error", report, options.write)


if __name__ == "__main__":
    main()
