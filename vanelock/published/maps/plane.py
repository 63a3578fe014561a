"""Peaks over a plane of two parameters, by several methods: where each statement holds.

The plane is friction by interference, or friction by load. Every point is a case of its own, of
which the peaks are kept; all share the stuck modes, which none of these parameters changes.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.nonlinear import HarmonicModes, System

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


PEAKS = ("amplitude", "frequency", "opening", "slipping", "lost", "seconds", "points")
Row = tuple[float, float, float, float, int, float, int]
"""Of these each."""


def joined(points: Sequence[Plane], mu: Sequence[float], value: Sequence[float]) -> Plane:
    """The plane of planes of one point each, friction by friction."""
    shape = len(mu), len(value), -1
    peaks: dict[str, Any] = {
        name: np.reshape([getattr(each, name) for each in points], shape) for name in PEAKS
    }
    return replace(points[0], mu=np.array(mu), value=np.array(value), **peaks)


def of_point(
    other: str, mu: float, value: float, methods: Sequence[Method], rows: Sequence[Row]
) -> Plane:
    """The plane of one point, from what each method finds there."""
    columns = zip(PEAKS, zip(*rows, strict=True), strict=True)
    peaks: dict[str, Any] = {name: np.reshape(column, (1, 1, -1)) for name, column in columns}
    names = tuple(method.name for method in methods)
    return Plane(other, np.array([mu]), np.array([value]), names, **peaks)


def changed(system: System, mu: float, other: str, value: float) -> System:
    """A system with another friction and interference of the interlock, or another load.

    Parameters
    ----------
    system : System
    mu : float
    other : {"interference", "load"}
    value : float
        Interference, m, or a factor of the load.
    """
    contacts, force = system.contacts, system.force
    own = _interlock(system)
    contacts = replace(contacts, mu=np.where(own, mu, contacts.mu))
    if other == "interference":
        contacts = replace(contacts, v0=np.where(own, value, contacts.v0))
    else:
        force = {
            h: replace(each, vector=value * each.vector) if h else each for h, each in force.items()
        }
    return replace(system, contacts=contacts, force=force)


def _interlock(system: System) -> NDArray[np.bool_]:
    return np.array([joint == "interlock" for joint in system.contacts.joint])


def peak(
    system: System,
    method: Method,
    range: tuple[float, float],
    output: tuple[int, int],
    modes: HarmonicModes,
) -> Row:
    """What a method finds of the peak of an output node's direction within a range, Hz."""
    began = time.process_time()
    found = nonlinear.frequency_response(
        system,
        range,
        nonlinear.Options(
            method.harmonics, coupling=method.coupling, harmonic_diameters=method.diameters
        ),
        modes=modes.diameters,
        find_jumps=False,
    )
    spent = time.process_time() - began
    lost = int((~found.converged).sum())
    size = found.amplitude[:, *output]
    known = np.where(found.converged, size, -np.inf)
    top = int(known.argmax())
    if not np.isfinite(known[top]) or not _sure(found.converged, top):
        return (np.nan, np.nan, np.nan, np.nan, lost, spent, found.points)
    own = _interlock(system)
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
