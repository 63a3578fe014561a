"""Examples of NLvib 1.3, solved by it under Octave and polished to 1e-10, solved here as well.

`nlvib.npz` holds 12 to 30 points of each of its curves: columns of cosine and sine coefficients
with the frequency last, as its `HB_residual` has them. Where NLvib samples a kink 1,024 times a
period, so does this program here; the other laws are smooth, where both integrate exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.conftest import FULL
from vanelock.nonlinear import Element, Options, System, frequency_response
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.newton.newton import solve

Floats = NDArray[np.float64]
SOLVED = np.load(Path(__file__).with_name("nlvib.npz"))


@dataclass(frozen=True)
class Example:
    """One of them: the system, its harmonics, its samples, and lines of code in both programs.

    Lines are counted without comments and blank ones, up to the call that gives the curve, which is
    one more here; classes and functions that chain masses are left out in both.
    """

    system: System
    harmonics: int
    samples: int | None
    lines_there: int = 0
    lines_here: int = 0


def chain(masses: Sequence[float], springs: Sequence[float], dampers: Sequence[float]) -> Any:
    """M, K and C of masses in a row, the first and the last on the ground."""

    def joined(k: Sequence[float]) -> Floats:
        values = np.array(k)
        beside = np.diag(values[1:-1], 1)
        return np.diag(values[:-1] + values[1:]) - beside - beside.T

    return {"M": np.diag(masses), "K": joined(springs), "C": joined(dampers)}


def element(law: str, place: Any, *parameters: float) -> Element:
    """An element by name."""
    return Element(force=law, places=[place], parameters=parameters)


def examples() -> dict[int, Example]:
    """By number."""
    duffing = System.from_matrices(
        [[1.0]],
        [[1.0]],
        C=[[0.05]],
        elements=[element("cubic_spring", 0, 0.1)],
        force={0: 0.18},
    )
    cubic = System.from_matrices(
        **chain([1, 0.05], [1, 0.0453, 0], [0.002, 0.013, 0]),
        elements=[element("cubic_spring", 0, 1.0), element("cubic_spring", (0, 1), 0.0042)],
        force={0: 0.11},
    )
    stop = System.from_matrices(
        **chain([1, 1], [0, 1, 1], [0, 0.03, 0.03]),
        elements=[element("stop", 0, 1e2, 1.0)],
        force={1: 0.1},
    )
    several = System.from_matrices(
        **chain([1, 1, 1], [1] * 4, [0.02] * 4),
        elements=[
            element("jenkins", 0, 20.0, 1.0),
            element("jenkins", (1, 0), 20.0, 1.0),
            element("cubic_spring", 1, 1.0),
            element("cubic_spring", (2, 1), 1.0),
            element("stop", 2, 1.0, 0.25),
        ],
        force={1: 1.0},
    )
    beam = System.from_matrices(
        SOLVED["M8"],
        SOLVED["K8"],
        C=SOLVED["D8"],
        elements=[element("tanh_friction", SOLVED["W8"][:, 0], 1.5, 6e-7)],
        force=SOLVED["F8"][:, 0],
    )
    mode = System.from_matrices(
        SOLVED["M9"],
        SOLVED["K9"],
        elements=[element("cubic_spring", SOLVED["W9"][:, 0], 6e9)],
    )
    return {
        1: Example(duffing, 7, None, 30, 8),
        2: Example(cubic, 7, None, 26, 6),
        3: Example(stop, 21, 1024, 24, 6),
        7: Example(several, 7, 1024, 41, 12),
        8: Example(beam, 7, 128, 20, 8),
        9: Example(mode, 5, None),
    }


EXAMPLES = examples()


def coefficients(example: Example, column: Floats) -> Floats:
    """(c, 3, 2H + 1) displacements of the elements in a column of NLvib's unknowns."""
    matrices = example.system.diameters[0]
    n, count = len(matrices.K), 2 * example.harmonics + 1
    q = column[: n * count].reshape(count, n).T.copy()
    q[:, 2::2] *= -1  # one-sided amplitudes: cosine less i times sine
    return np.asarray(np.einsum("cin,nk->cik", matrices.own.real, q))


@pytest.mark.parametrize("number", [1, 2, 3, 7, 8])
def test_its_points_are_solutions_here(number: int, record: Any, below: Any) -> None:
    example, columns = EXAMPLES[number], SOLVED[f"x{number}"].T
    options = Options(example.harmonics, samples=example.samples)
    ready = options.prepare(example.system, columns[:, -1] / (2 * np.pi), 1)
    law = ready.law(example.harmonics)
    worst, steps = 0.0, 0
    for column in columns:
        omega, given = float(column[-1]), coefficients(example, column)
        begin = law(given, omega).w
        found = solve(fixed(ready.structure.balance(omega), law), begin, 0.0)
        assert found.converged
        worst = max(worst, float(np.abs(found.u - given).max() / np.abs(given).max()))
        steps += found.iterations
    record("points", len(columns))
    below("largest difference", worst, 1e-9)
    record("Newton steps of all", steps)
    record("lines of code there, here", f"{example.lines_there}, {example.lines_here}")


def test_its_nonlinear_mode_is_a_free_vibration_here(record: Any, below: Any) -> None:
    example, columns = EXAMPLES[9], SOLVED["x9"].T
    ready = Options(example.harmonics).prepare(example.system, [20.0, 50.0], 1)
    law, worst = ready.law(example.harmonics), 0.0
    for column in columns:
        omega, size = float(column[-3]), 10 ** float(column[-1])
        given = size * coefficients(example, column[:-3])
        w = law(given, omega).w
        moved = ready.structure.balance(omega).displacement(w)
        worst = max(worst, float(np.abs(moved - given).max() / np.abs(given).max()))
    record("points", len(columns))
    below("largest difference", worst, 1e-6)


@pytest.mark.parametrize(
    "number", [1, 2, 8] if FULL else [1, 8]
)  # points of 3 and 7 crowd between folds
def test_sweeps_find_its_stable_points(number: int, record: Any) -> None:
    example, columns = EXAMPLES[number], SOLVED[f"x{number}"].T
    columns = columns[np.argsort(columns[:, -1])][:: 1 if FULL else 3]
    hertz = columns[:, -1] / (2 * np.pi)
    options = {"harmonics": example.harmonics, "samples": example.samples}
    both = [
        frequency_response(example.system, hertz, Options(direction=way, **options))
        for way in ("up", "down")
    ]
    given = np.array([coefficients(example, column) for column in columns])
    first = np.hypot(given[:, :, 0, 1], given[:, :, 0, 2])
    apart = [
        np.abs(np.abs(each.contact[:, 1, :, 0]) - first).max(axis=1) / first.max() for each in both
    ]
    nearest = np.min(apart, axis=0)
    record("points", len(columns))
    record("met by a sweep within 1e-6", int((nearest < 1e-6).sum()))
    assert all(each.converged.all() for each in both)
    # The others lie between two folds, where no sweep of so few frequencies comes.
    assert (nearest < 1e-6).mean() > 0.6
