"""Natural frequencies of the joined parts against rotor speed, and where engine orders meet them.

    K(n) = s_vane(n) K_vane + s_casing(n) K_casing + Bᴴ K_c B,      s = E(T(n)) / E

at one nodal diameter, with the interlock's contacts in B or not. The modes at a few speeds span
those at all speeds between (Ritz; the error goes as that of the interpolated shapes squared, below
1e-9 where moduli change by a third, as its test shows). A line of engine order EO meets mode j
where f_j(n) = |EO| n / 60, which is solved on the modes themselves, not between points of a drawn
line. Lines are numbered by ascending frequency at every speed.

At which rotor speed the response of a case has its temperatures, where they depend on it.

Unless `temperature.speed` says so: where the engine order of the study meets the mode of interest
with the interlock free, found on the modes with each part at its temperature there. It is
determined before the response is planned, from the same reduced parts that serve the response.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy.linalg as sl
from scipy.optimize import brentq

from vanelock.common.arrays import Complex, Floats
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import diameter_of, with_values
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.structure.structure import ends
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Stages
from vanelock.rom import Component, MeshExcess, System
from vanelock.stages.parts.loads import modulus, reference
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.response.limits import limits

Factors = Callable[[float], tuple[float, float]]
"""Moduli of vane and casing at a speed, rpm, over those of the parts given."""

FEWEST = 24
"""Speeds at least between which a crossing is looked for; bends of the temperatures add to them."""
SPANNING = 5
"""Speeds whose modes span those of all others."""
MORE = 6
"""Modes beyond those asked for that help to."""


class _Meeting(NamedTuple):
    """Where a line of an engine order meets a mode: place of the mode from 0, rpm, Hz."""

    mode: int
    speed: float
    frequency: float


@dataclass
class ModesOverSpeed:
    """Two joined parts at one nodal diameter."""

    system: System
    parts: Mapping[str, Component]
    nodal_diameter: int
    factors: Factors
    ends: tuple[float, float]
    excess: MeshExcess | None = None
    _pieces: tuple[Complex, ...] = field(init=False)
    _spans: dict[tuple[bool, int], tuple[Complex, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Bring K of each part and of each group of contacts to coordinates of unit mass."""
        k, matrices = self.nodal_diameter, self.system.at(self.nodal_diameter)
        n = len(matrices.K)
        lower = sl.cholesky(matrices.M, lower=True)
        blade, shell = (matrices.joined(p, self.parts[p].at(k).K) for p in ("vane", "casing"))
        if self.excess is not None and k in self.excess.diameters:
            off = self.excess.diameters[k].stiffness
            blade, shell = blade - off[0], shell - off[1]
        rows, stays = self.system.contact_rows(k), ~self.system.contacts.opens
        contacts = []
        for own in (stays, ~stays):
            B = rows[own].reshape(-1, n)
            stiffness = self.system.contacts.stiffness[own].ravel()
            contacts.append((B.conj().T * stiffness) @ B)
        self._pieces = tuple(_unit(each, lower) for each in (blade, shell, *contacts))

    def frequencies(self, speed: float, stuck: bool, count: int) -> Floats:
        """(count,) lowest natural frequencies at a rotor speed, rpm, Hz, ascending."""
        if (stuck, count) not in self._spans:
            self._spans[stuck, count] = self._spanned(stuck, count)
        A = _at(self._spans[stuck, count], self.factors(speed), stuck)
        squared = sl.eigh(A, eigvals_only=True, subset_by_index=[0, min(count, len(A)) - 1])
        return np.asarray(np.sqrt(squared.clip(0)) / (2 * np.pi))

    def _spanned(self, stuck: bool, count: int) -> tuple[Complex, ...]:
        """K of each part and group of contacts in the modes at a few speeds together."""
        low, high = self.ends
        nodes = np.polynomial.chebyshev.chebpts2(SPANNING)
        moduli = [self.factors(float(n)) for n in low + (high - low) * (1 + nodes) / 2]
        shapes = []
        for each in dict.fromkeys(moduli):
            A = _at(self._pieces, each, stuck)
            last = min(count + MORE, len(A)) - 1
            shapes.append(sl.eigh(A, subset_by_index=[0, last])[1])
        basis = sl.orth(np.hstack(shapes), rcond=1e-10)
        return tuple(_hermitian(basis.conj().T @ each @ basis) for each in self._pieces)

    def line(self, speeds: Floats, stuck: bool, count: int) -> Floats:
        """(s, count) natural frequencies at rotor speeds (s,), rpm, Hz."""
        return np.array([self.frequencies(float(each), stuck, count) for each in speeds])

    def meetings(self, order: int, stuck: bool, count: int, speeds: Floats) -> list[_Meeting]:
        """Where an engine order meets the lowest modes, within rotor speeds (s,), ascending."""
        slope = abs(order) / 60
        above = self.line(speeds, stuck, count) - slope * speeds[:, None]
        found = []
        for j in range(above.shape[1]):

            def gap(speed: float, j: int = j) -> float:
                return float(self.frequencies(speed, stuck, count)[j]) - slope * speed

            for i in np.flatnonzero((above[:-1, j] > 0) != (above[1:, j] > 0)):
                low, high = float(speeds[i]), float(speeds[i + 1])
                met = float(brentq(gap, low, high, xtol=1e-7 * high, rtol=1e-12))
                found.append(_Meeting(j, met, slope * met))
        return found


def _at(pieces: tuple[Complex, ...], moduli: tuple[float, float], stuck: bool) -> Complex:
    """Stiffness with these moduli of vane and casing, the interlock stuck or free."""
    blade, shell, hooked, locked = pieces
    return np.asarray(moduli[0] * blade + moduli[1] * shell + hooked + (locked if stuck else 0))


def _unit(K: Complex, lower: Complex) -> Complex:
    """L⁻¹ K L⁻ᴴ."""
    half = sl.solve_triangular(lower, K, lower=True)
    return _hermitian(sl.solve_triangular(lower, half.conj().T, lower=True))


def _hermitian(A: Complex) -> Complex:
    return np.asarray((A + A.conj().T) / 2)


def grid(low: float, high: float, bends: Sequence[float]) -> Floats:
    """Speeds from low to high, rpm, even, with those between where temperatures bend."""
    even = np.linspace(low, high, FEWEST + 1)
    within = [each for each in bends if low < each < high]
    return np.unique(np.concatenate([even, within]))


HIGHEST = 1e6
"""Speed beyond which no crossing is looked for, rpm."""


def with_temperature_speeds(cases: Sequence[Case], stages: Stages) -> list[Case]:
    """The cases, each with the speed of its temperatures determined."""
    if isinstance(cases[0].problem, Scene) or not any(_needs_speed(case.study) for case in cases):
        return list(cases)

    def known(case: Case) -> Case:
        if not _needs_speed(case.study):
            return case
        speed = {"temperature.speed": _crossing(case.study, stages)}
        return replace(case, problem=with_values(case.study, speed))

    return [known(case) for case in cases]


def _needs_speed(study: Study) -> bool:
    """Whether a study's temperatures depend on a speed that is not known yet."""
    return study.temperature.varies and study.temperature.speed is None


def factors(study: Study, over: Callable[[Study, str], float]) -> Factors:
    """Moduli of vane and casing against speed, rpm, over those of `modulus` or `reference`."""

    def at(speed: float) -> tuple[float, float]:
        vane, casing = (modulus(study, part, speed) / over(study, part) for part in PARTS)
        return vane, casing

    return at


def bends(study: Study) -> list[float]:
    """Speeds at which a modulus has a bend, rpm."""
    heat = study.temperature
    found: list[float] = []
    for part in PARTS:
        if not isinstance(known := getattr(heat, part), tuple):
            continue
        speeds, degrees = np.array(known).T
        found += speeds.tolist()
        for hot, _ in getattr(study.material, part).moduli:
            for i in np.flatnonzero((degrees[:-1] < hot) != (degrees[1:] < hot)):
                share = (hot - degrees[i]) / (degrees[i + 1] - degrees[i])
                found.append(float(speeds[i] + share * (speeds[i + 1] - speeds[i])))
    return found


def _crossing(study: Study, stages: Stages) -> float:
    """Rotor speed at which the study's engine order meets its mode of interest, rpm."""
    structure, k = StudyStructure(study, at_reference=True), diameter_of(study, 1)
    order = study.excitation.engine_order
    parts = {part: stages.get(structure.component(part, k)) for part in PARTS}
    excess = structure.excess(k)
    taken = None if excess is None else stages.get(excess)
    system = stages.get(structure.uncorrected or structure.bare.at(k))
    low, high = study.temperature.speeds
    low, high = max(low, 1.0), min(high, HIGHEST)
    scale = factors(study, reference)
    over_speed = ModesOverSpeed(system, parts, k, scale, (low, high), taken)
    mode = limits(system, study.response.mode).free_mode + 1
    found = over_speed.meetings(order, False, mode, grid(low, high, bends(study)))
    met = [each for each in found if each.mode == mode - 1]
    if not met:
        raise InputError(_missed(study, over_speed, (low, high), mode))
    return float(f"{met[0].speed:.9g}")  # so that rounding of the last bits changes no hash


def _missed(
    study: Study, over_speed: ModesOverSpeed, speeds: tuple[float, float], mode: int
) -> str:
    order = abs(study.excitation.engine_order)
    at_end = over_speed.frequencies(speeds[1], False, mode)[-1]
    part = next(
        part
        for part in PARTS
        if isinstance(known := getattr(study.temperature, part), tuple)
        and (speeds[1] in ends(known) or speeds[0] in ends(known))
    )
    return (
        f"temperature.{part}: engine order {order} meets free mode {mode} nowhere from "
        f"{speeds[0]:g} to {speeds[1]:g} rpm (it has {at_end:.5g} Hz there, "
        f"{60 * at_end / order:.5g} rpm): give temperatures up to that, or temperature.speed"
    )
