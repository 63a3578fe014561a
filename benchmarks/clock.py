"""CPU time of solved points in units of one dense complex solve, both taken in the same run.

The unit is the solution of D x = f, D the dynamic stiffness of the reduced model with a full
complex factorisation and one right-hand side, on one thread. It is timed again and again between
the points that it measures, because the speed of a machine drifts with what else runs on it.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from vanelock.nonlinear import Force, Options, Response, System, frequency_response
from vanelock.nonlinear.balance.stuck_modes import StuckModes

Floats = NDArray[np.float64]


def dynamic_stiffness(system: System, hertz: float) -> NDArray[np.complex128]:
    """D of the first harmonic with all contacts stuck, dense and complex."""
    k = system.nodal_diameter(1)
    matrices = system.at(k)
    B = system.contact_rows(k).reshape(-1, len(matrices.K))
    stuck = matrices.K + (B.conj().T * system.contacts.stiffness.reshape(-1)) @ B
    omega = 2 * np.pi * hertz
    return np.asarray(stuck - omega**2 * matrices.M + 1e-3j * stuck, complex)


@dataclass
class Unit:
    """The dense complex solve and its timings, s."""

    matrix: NDArray[np.complex128]
    seconds: list[float] = field(default_factory=list)

    def sample(self) -> None:
        """Time it once more."""
        right = np.ones(len(self.matrix), complex)
        begin = time.process_time()
        la.solve(self.matrix, right, check_finite=False)
        self.seconds.append(time.process_time() - begin)

    def time(self) -> float:
        """Median so far, s; unlike the least, it has the same chance of disturbance as a point."""
        return float(np.median(self.seconds))


@dataclass(frozen=True)
class Curve:
    """What a swept curve cost.

    Attributes
    ----------
    response : Response
        Without outputs.
    setup : float
        CPU seconds before the first point was begun and after the last one, and the first point.
    seconds : (p - 1,) float
        CPU seconds of each further point.
    unit : float
        CPU seconds of the dense solve meanwhile.
    """

    response: Response
    setup: float
    seconds: Floats
    unit: float

    @property
    def units(self) -> Floats:
        """(p - 1,) cost of each point after the first one."""
        return self.seconds / self.unit


def scaled(system: System, force: float = 1.0, mu: float = 1.0) -> System:
    """The same system under other loads and with other friction, by factors."""
    loads = {
        h: Force(load.vector * (force if h else 1.0), load.omega_power)
        for h, load in system.force.items()
    }
    return replace(
        system, force=loads, contacts=replace(system.contacts, mu=mu * system.contacts.mu)
    )


def without_outputs(system: System) -> System:
    """The same system, nothing recovered at its outputs."""
    bare = {k: replace(matrices, output=None) for k, matrices in system.diameters.items()}
    return replace(system, diameters=bare, output_names=())


def sweep(
    system: System,
    hertz: Sequence[float] | Floats,
    options: Options,
    unit: Unit,
    every: int = 5,
    modes: Mapping[int, StuckModes] | None = None,
) -> Curve:
    """Solve a closed list of frequencies; time each point, and the unit at every fifth one."""
    marks: list[float] = []
    resumed = [0.0]

    def progress(done: int, total: int, at: float, amplitude: float) -> None:
        if amplitude != amplitude:  # looked for, not done
            return
        marks.append(time.process_time() - resumed[0])
        if done % every == 1:
            unit.sample()
        resumed[0] = time.process_time()

    before = len(unit.seconds)
    begin = resumed[0] = time.process_time()
    bare = without_outputs(system)
    response = frequency_response(bare, hertz, options, progress, modes)
    spent = time.process_time() - begin
    own = float(np.sum(unit.seconds[before:]))
    points = np.array(marks[1:])
    meanwhile = float(np.median(unit.seconds[before:]))
    return Curve(response, spent - own - float(points.sum()), points, meanwhile)
