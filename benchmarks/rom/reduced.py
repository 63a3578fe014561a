"""Reductions of the vane segment compared with its unreduced sector."""

import time
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.rom.direct import direct
from benchmarks.segment import (
    CASES,
    CASING_MASTERS,
    COUNT,
    JOINTS,
    VANE_MASTERS,
    Places,
    Sector,
    casing_model,
    closed,
    unreduced,
    vane_model,
)
from vanelock import fem, rom
from vanelock.stages.parts.segment import Segment

Floats = NDArray[np.float64]

EVERY = 6  # at how many frequencies an estimate is asked for once
BAND = np.linspace(50.0, 1400.0, 181)
DISTANCE = 0.01  # from a natural frequency, below which a response without damping means little


class Setting(NamedTuple):
    """One way to reduce both parts."""

    name: str
    vane: dict[str, Any]
    casing: dict[str, Any]
    modal: int | None = None
    face: int | None = None


@dataclass
class Outcome:
    """What a setting costs and misses, at one nodal diameter.

    Attributes
    ----------
    coordinates : int
        Modal ones, of both parts and the face.
    size : int
        All coordinates of the joined system.
    cost : float
        CPU time of the reductions, s.
    error, estimate : dict of str to (10,) float
        Of the first frequencies, by case; the estimate where the route has one.
    response, estimated : dict of str to (p,) float
        Error of the largest output at each frequency, and its estimate at every sixth.
    """

    coordinates: int
    size: int
    cost: float
    error: dict[str, Floats] = field(default_factory=dict)
    estimate: dict[str, Floats] = field(default_factory=dict)
    response: dict[str, Floats] = field(default_factory=dict)
    estimated: dict[str, Floats] = field(default_factory=dict)

    def second(self) -> float:
        """Error of the second frequency, the worse case."""
        return float(max(abs(e[1]) for e in self.error.values()))

    def worst(self) -> float:
        """Largest error of the first ten frequencies."""
        return float(max(abs(e).max() for e in self.error.values()))

    def worst_response(self) -> float:
        """Largest error of the response."""
        return float(max((e.max() for e in self.response.values()), default=np.nan))


class Bench:
    """The parts, their unreduced sectors, and what reductions of them miss."""

    def __init__(self, size: str | float, band: Floats = BAND) -> None:
        self.vane, self.casing = vane_model(size), casing_model(size)
        self.sector = cache(self._sector)
        self.small_vane = cache(self._small_vane)
        self.frequencies = band
        for case in CASES:
            own = self.sector(case, 1).frequency
            away = abs(self.frequencies[:, None] / own - 1).min(axis=1) > DISTANCE
            self.frequencies = self.frequencies[away]
        self.truth: dict[str, NDArray[np.complex128]] = {}

    def _sector(self, case: str, diameter: int) -> Sector:
        return unreduced(self.vane, self.casing, case, diameter)

    def _small_vane(self, given: tuple[tuple[str, Any], ...]) -> tuple[rom.Component, float]:
        begin = time.process_time()
        return rom.reduce(self.vane, VANE_MASTERS, **dict(given)), time.process_time() - begin

    def unit(self) -> float:
        """CPU time of a factorisation of the vane, s."""
        length = float(np.linalg.norm(np.ptp(self.vane.part.points, axis=0)))
        material = self.vane.material
        low = (0.01 / length) ** 2 * material.E / material.rho
        K = self.vane.K + low * self.vane.M
        spent = []
        for _ in range(3):
            begin = time.process_time()
            fem.factorise(K)
            spent.append(time.process_time() - begin)
        return float(np.median(spent))

    def outcome(self, setting: Setting, diameter: int = 1) -> Outcome:
        """Reduce, join and compare."""
        vane, casing, spent = self.pair(setting, diameter)
        return self.compared(vane, casing, spent, diameter)

    def pair(
        self, setting: Setting, diameter: int = 1
    ) -> tuple[rom.Component, rom.Component, float]:
        """Both parts reduced, and the CPU time of it, s."""
        vane, spent = self.small_vane(tuple(setting.vane.items()))
        band = {} if vane.band is None else {"band": vane.band}
        begin = time.process_time()
        reduce = direct if "interface" in setting.casing else rom.reduce
        casing = reduce(
            self.casing, CASING_MASTERS, nodal_diameters=[diameter], **setting.casing, **band
        )
        return vane, casing, spent + time.process_time() - begin

    def compared(
        self, vane: rom.Component, casing: rom.Component, spent: float, diameter: int = 1
    ) -> Outcome:
        """Join and compare."""
        system = Segment(JOINTS, diameter, force=1.0).join(vane, casing)
        parts = {"vane": vane, "casing": casing}
        modal = vane.fixed_modes + casing.fixed_modes + casing.interface_modes
        made = Outcome(modal, len(system.at(diameter).K), spent)
        for case in CASES:
            chosen = closed(system, case)
            exact = self.sector(case, diameter).frequency[:COUNT]
            made.error[case] = rom.linear_modes(system, diameter, COUNT, chosen)[0] / exact - 1
            if casing.route == "cyclic":
                estimated = rom.frequency_errors(system, parts, diameter, COUNT, chosen)
                made.estimate[case] = estimated.total
            if diameter == 1:
                self._respond(made, case, system, parts)
        return made

    def _respond(
        self,
        made: Outcome,
        case: str,
        system: rom.System,
        parts: dict[str, rom.Component],
    ) -> None:
        casing = parts["casing"]
        if case not in self.truth:
            places = Places(self.vane, self.casing, 1)
            self.load = places.load(system, casing)
            x = self.sector(case, 1).response(self.frequencies, self.load)
            self.probe = x[:, len(self.frequencies) // 2]
            self.truth[case] = places.output(x)
        exact = self.truth[case]
        scale = abs(exact).max(axis=(1, 2))
        chosen = closed(system, case)
        found = response(system, self.frequencies, chosen)
        if casing.route == "cyclic":
            few = self.frequencies[::EVERY]
            _, error = rom.response_errors(system, parts, few, chosen)
            made.estimated[case] = abs(error).max(axis=(1, 2)) / scale[::EVERY]
        made.response[case] = abs(found - exact).max(axis=(1, 2)) / scale

    def doubt_of_response(self) -> float:
        """Of the middle of the band, the last case."""
        middle = float(self.frequencies[len(self.frequencies) // 2])
        case = list(CASES)[-1]
        return self.sector(case, 1).doubt_of_response(middle, self.load, self.probe)


def fewer(part: rom.Component, modes: int, face: int = 0) -> rom.Component:
    """The component with less of its lowest fixed-interface modes and face modes.

    Exactly what a reduction to so many would give, as each set begins with the same modes.
    """
    middle = part.interface_modes + 3 * len(part.masters.nodes)
    kept = np.r_[:face, part.interface_modes : middle + modes]
    small = {
        k: rom.Reduced(K=r.K[np.ix_(kept, kept)], M=r.M[np.ix_(kept, kept)])
        for k, r in part.diameters.items()
    }
    return replace(part, interface_modes=face, fixed_modes=modes, diameters=small)


def response(
    system: rom.System, frequencies: Floats, chosen: NDArray[np.bool_]
) -> NDArray[np.complex128]:
    """(p, o, 3) undamped linear response of a reduced system at its outputs, by all its modes."""
    matrices = system.at(1)
    hertz, shapes = rom.linear_modes(system, 1, len(matrices.K), chosen)
    share = shapes.conj().T @ system.force[1].vector
    q = share[:, None] / (2 * np.pi) ** 2 / (hertz[:, None] ** 2 - frequencies**2)
    assert matrices.output is not None
    return np.asarray(np.einsum("oin,np->poi", matrices.output @ shapes, q))
