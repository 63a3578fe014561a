"""Peaks over a plane of two parameters, by several methods: where each statement holds.

The plane is friction by interference, or friction by load. Every point is a response of its own
over the range of frequencies; all share the stuck modes, which none of these parameters changes.
Points are dealt out to processes, since each is independent of the others.
"""

import json
import os
import time
from collections.abc import Callable, Container, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.nonlinear import Journal, System
from vanelock.pipeline.executor.processes import end_with

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Method:
    """A way to solve: harmonics, coupling, nodal diameters of the harmonics."""

    harmonics: int
    coupling: str = "coupled"
    diameters: str = "wave"

    @property
    def name(self) -> str:
        """Short and unique."""
        same = "" if self.diameters == "wave" else ", one diameter"
        return f"{self.coupling}, H = {self.harmonics}{same}"


@dataclass(frozen=True)
class Plane(Product):
    """Peaks at m frictions by v values of another parameter, by k methods.

    Attributes
    ----------
    other : str
        "interference" (of the interlock, m) or "load" (factor).
    mu : (m,) float
    value : (v,) float
    methods : tuple of str
    amplitude, frequency : (m, v, k) float
        Of the largest converged point, m and Hz; NaN where a point beside it was lost, or where it
        lies at an end of the range.
    opening : (m, v, k) float
        Share of the interlock's pairs that open in every period at the peak.
    slipping : (m, v, k) float
        Share that slips.
    lost : (m, v, k) int
        Points of the response that did not converge.
    seconds : (m, v, k) float
        Processor time spent, s.
    points : (m, v, k) int
        Frequencies solved.
    """

    other: str
    mu: Floats
    value: Floats
    methods: tuple[str, ...]
    amplitude: Floats = field(metadata={"unit": "m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    opening: Floats
    slipping: Floats
    lost: NDArray[np.int64]
    seconds: Floats = field(metadata={"unit": "s"})
    points: NDArray[np.int64]

    def of(self, method: Method) -> tuple[Floats, Floats]:
        """(m, v) amplitude and frequency of the peaks by a method."""
        k = self.methods.index(method.name)
        return self.amplitude[:, :, k], self.frequency[:, :, k]


@dataclass(frozen=True)
class PlaneTask:
    """Points of a plane.

    Attributes
    ----------
    system : System
        At any friction, interference and load.
    other : {"interference", "load"}
    mu, value : sequence of float
    methods : sequence of Method
    range : (float, float)
        Hz.
    output : (int, int)
        Output node and direction whose peak it is.
    """

    system: System
    other: str
    mu: Sequence[float]
    value: Sequence[float]
    methods: Sequence[Method]
    range: tuple[float, float]
    output: tuple[int, int]

    def at(self, mu: float, value: float) -> System:
        """The system at a point."""
        contacts, force = self.system.contacts, self.system.force
        own = np.array([joint == "interlock" for joint in contacts.joint])
        contacts = replace(contacts, mu=np.where(own, mu, contacts.mu))
        if self.other == "interference":
            contacts = replace(contacts, v0=np.where(own, value, contacts.v0))
        else:
            force = {
                h: replace(each, vector=value * each.vector) if h else each
                for h, each in force.items()
            }
        return replace(self.system, contacts=contacts, force=force)


Row = tuple[float, float, float, float, int, float, int]


def plane(
    task: PlaneTask,
    told: Callable[[int, int, float], None] | None = None,
    journal: Journal | None = None,
    workers: int = 1,
) -> Plane:
    """Solve a plane; `told` hears points done, points in all and the last peak, m.

    So many processes solve its points, none but this one where that is 1. Points are written to the
    `journal` as they come, in any order, and those in it not solved.
    """
    m, v, k = len(task.mu), len(task.value), len(task.methods)
    found = np.full((m, v, k, 7), np.nan)
    known = _written(journal, k)
    for (i, j), rows in known.items():
        found[i, j] = rows
    for done, (i, j, rows) in enumerate(_solved(task, set(known), workers), 1 + len(known)):
        found[i, j] = rows
        if journal is not None:
            journal.add(json.dumps([i, j, rows]).encode())
        if told is not None:
            told(done, m * v, float(found[i, j, 0, 0]))
    return Plane(
        other=task.other,
        mu=np.asarray(task.mu, float),
        value=np.asarray(task.value, float),
        methods=tuple(method.name for method in task.methods),
        amplitude=found[..., 0],
        frequency=found[..., 1],
        opening=found[..., 2],
        slipping=found[..., 3],
        lost=found[..., 4].astype(np.int64),
        seconds=found[..., 5],
        points=found[..., 6].astype(np.int64),
    )


def _written(journal: Journal | None, methods: int) -> dict[tuple[int, int], Any]:
    """Rows of the points that a journal holds, by their places."""
    found = {}
    while journal is not None and (record := journal.next()) is not None:
        i, j, rows = json.loads(record)
        if len(rows) == methods:
            found[i, j] = rows
    return found


def _solved(
    task: PlaneTask, known: Container[tuple[int, int]], workers: int
) -> Iterator[tuple[int, int, list[Row]]]:
    """Places and rows of all points but those that are known as they come."""
    workers = min(workers, len(task.mu))
    every = [(i, j) for i in range(len(task.mu)) for j in range(len(task.value))]
    places = [place for place in every if place not in known]
    if workers < 2 or len(places) < 8:
        solver = PlaneSolver(task)
        for i, j in places:
            yield i, j, solver.point(task.mu[i], task.value[j])
        return
    with ProcessPoolExecutor(workers, get_context("spawn"), _prepare, (task, os.getpid())) as pool:
        pending = {pool.submit(_point, task.mu[i], task.value[j]): (i, j) for i, j in places}
        try:
            for future in as_completed(pending):
                yield *pending[future], future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


class PlaneSolver:
    """Solves points of a plane with stuck modes computed once."""

    def __init__(self, task: PlaneTask) -> None:
        self._task = task
        system = task.system
        most = max(each.harmonics for each in task.methods)
        self._modes = nonlinear.harmonic_modes(system, most).diameters

    def point(self, mu: float, value: float) -> list[Row]:
        """What each method finds at a point."""
        system = self._task.at(mu, value)
        return [self._row(system, method) for method in self._task.methods]

    def _row(self, system: System, method: Method) -> Row:
        began = time.process_time()
        found = nonlinear.frequency_response(
            system,
            self._task.range,
            nonlinear.Options(
                method.harmonics, coupling=method.coupling, harmonic_diameters=method.diameters
            ),
            modes=self._modes,
            find_jumps=False,
        )
        spent = time.process_time() - began
        lost = int((~found.converged).sum())
        size = found.amplitude[:, *self._task.output]
        known = np.where(found.converged, size, -np.inf)
        top = int(known.argmax())
        if not np.isfinite(known[top]) or not _sure(found.converged, top):
            return (np.nan, np.nan, np.nan, np.nan, lost, spent, found.points)
        own = np.array([joint == "interlock" for joint in system.contacts.joint])
        state, work = found.state[top, own], found.dissipation[top, own]
        opens = np.isin(state, (nonlinear.OPEN, nonlinear.SLIP_OPEN))
        slips = work > 1e-6 * max(float(work.max(initial=0.0)), np.finfo(float).tiny)
        return (
            float(size[top]),
            float(found.frequency[top]),
            float(opens.mean()),
            float(slips.mean()),
            lost,
            spent,
            found.points,
        )


def _sure(converged: NDArray[np.bool_], top: int) -> bool:
    """Whether the largest point lies within the range and its neighbours converged too."""
    return 0 < top < len(converged) - 1 and bool(converged[top - 1 : top + 2].all())


_solver: PlaneSolver | None = None


def _prepare(task: PlaneTask, parent: int) -> None:
    """In each process: the modes, once."""
    global _solver
    end_with(parent)
    _solver = PlaneSolver(task)


def _point(mu: float, value: float) -> list[Row]:
    assert _solver is not None
    return _solver.point(mu, value)
