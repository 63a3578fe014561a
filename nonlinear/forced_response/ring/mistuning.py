"""By how much the sectors of a ring differ."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike

from vanelock.common.arguments import OfKind, of_kind
from vanelock.common.arrays import Complex, Floats, hold_arrays
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.rom.system.system import System

_FREE = 1e-12  # of a part's largest ω²: what modes that nothing holds are below
_RELATIVE = ("mu", "kn", "kt", "frequency")
_BEHIND = {"interference": (), "slider": (2,), "mu": (), "kn": (), "kt": (2,), "frequency": ()}
"""Dimensions of the deviations behind sectors and contacts, or modes."""


@dataclass(frozen=True)
class SectorModes(Product):
    """Modes of a part that every sector has, alone, whose frequencies may differ by sector.

    A sector whose mode r vibrates at (1 + δ) times its frequency is stiffer by
    ΔK = g_rᵀ k_r ((1 + δ)² - 1) g_r, g_r the row that gives the mode's amplitude in a motion of the
    sector: sψᵀM, m, for a mode ψ with ψᵀMψ = 1 and the largest displacement s; k_r = ω_r²/s².

    Attributes
    ----------
    rows : dict of int to (r, n_k)
        g by nodal diameter, 0 to N/2, in its coordinates.
    stiffness : (r,) float
        k, N/m.
    """

    rows: dict[int, Complex]
    stiffness: Floats

    def __post_init__(self) -> None:
        hold_arrays(self, {"stiffness": 1})

    @classmethod
    @of_kind
    def of_part(
        cls, system: System, K: Floats, M: Floats, part: Floats | Mapping[int, Floats], count: int
    ) -> Self:
        """The lowest elastic modes of a part by itself, held as its stiffness says.

        Parameters
        ----------
        system : System
            With the nodal diameters 0 to N/2.
        K, M : (m, m) float
            Of the part, the same at all nodal diameters; K with whatever holds the part.
        part : (m, n) float, or dict of int to (m, n_k) float
            The part's coordinates in those of the system, such as `rom.split` of the identity;
            by nodal diameter where these differ.
        count : int
            r; modes that no stiffness holds are left out.

        Raises
        ------
        InputError
            If the part has not so many modes, or sizes do not fit.
        """
        every = range(system.sectors // 2 + 1)
        places = dict(part) if isinstance(part, Mapping) else dict.fromkeys(every, part)
        for k in every:
            given = places[k].shape if k in places else ()
            if K.shape != M.shape or K.shape != 2 * given[:1]:
                raise InputError(
                    f"modes: K {K.shape}, M {M.shape} and part {given} of nodal diameter {k} do "
                    "not fit"
                )
        squared, shapes = la.eigh(K, M)
        elastic = np.flatnonzero(squared > _FREE * squared[-1])[:count]
        if len(elastic) < count or count < 1:
            raise InputError(f"modes: given {count}: the part has {len(elastic)}")
        shapes = shapes[:, elastic]
        largest = np.abs(shapes).max(axis=0)
        seen = (largest * (M @ shapes)).T
        rows = {k: (seen @ places[k]).astype(complex) for k in every}
        return cls(rows, squared[elastic] / largest**2)


@dataclass(frozen=True)
class Mistuning(OfKind, Product):
    """Deviations of each sector of a ring from the tuned system.

    What is not given does not differ. Contacts are those of one sector, c; sectors are counted in
    the direction in which sector j of a wave of engine order EO > 0 follows by 2π j EO/N.

    Attributes
    ----------
    sectors : int
        N.
    interference : (N, c) float
        More than the system's, m.
    slider : (N, c, 2) float
        More than the system's, m.
    mu, kn : (N, c) float
        Relative: 0.01 is one hundredth more.
    kt : (N, c, 2) float
        Relative.
    frequency : (N, r) float
        Relative, of each of `modes`.
    modes : SectorModes, optional
        What `frequency` is of.
    """

    sectors: int
    interference: Floats = field(default_factory=lambda: np.zeros((0, 0)), metadata={"unit": "m"})
    slider: Floats = field(default_factory=lambda: np.zeros((0, 0, 2)), metadata={"unit": "m"})
    mu: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    kn: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    kt: Floats = field(default_factory=lambda: np.zeros((0, 0, 2)))
    frequency: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    modes: SectorModes | None = None

    def __post_init__(self) -> None:
        hold_arrays(self, {name: 2 + len(behind) for name, behind in _BEHIND.items()})
        super().__post_init__()

    @classmethod
    @of_kind
    def scatter(
        cls,
        system: System,
        deviation: Mapping[str, Mapping[str, float | ArrayLike]],
        seed: int = 0,
        modes: SectorModes | None = None,
    ) -> Self:
        """A ring drawn at random: one normal deviation for each sector, joint and quantity.

        Where deviations of the sectors themselves are given in the place of a standard deviation,
        they are taken.

        Parameters
        ----------
        system : System
        deviation : dict of str to dict
            Standard deviations relative to the system's value, by joint and quantity:
            {"contact": {"interference": 0.01, "mu": 0.05}}; quantities are interference, mu, kn,
            kt, and slider: places of sliders relative to the reach μ kn v₀/kt of static friction
            under interference alone, each direction drawn by itself. {"modes": {"frequency": 0.01}}
            is of all `modes`, each drawn by itself. Or (N,) deviations by sector; of sliders, or
            modes by themselves, (N, 2) and (N, r).
        seed : int
            Of the generator of random numbers.
        modes : SectorModes, optional

        Raises
        ------
        InputError
            If a joint or a quantity is unknown, or a deviation is not a number >= 0 and not one
            number a sector.
        """
        contacts, N, rng = system.contacts, system.sectors, np.random.default_rng(seed)
        known = sorted({*contacts.joints, *(["modes"] if modes is not None else [])})
        reach = contacts.alpha * np.maximum(contacts.v0, 0.0)[:, None]
        scales = {"interference": contacts.v0[:, None], "slider": reach}
        drawn = {name: np.zeros((N, contacts.count, 1)) for name in ("interference", "mu", "kn")}
        drawn |= {name: np.zeros((N, contacts.count, 2)) for name in ("kt", "slider")}
        frequency = np.zeros((N, 0 if modes is None else len(modes.stiffness)))
        for joint, given in sorted(deviation.items()):
            if joint not in known:
                raise InputError(f"mistuning: given {joint!r}: known are {', '.join(known)}")
            allowed = ("frequency",) if joint == "modes" else sorted(drawn)
            for name, size in sorted(given.items()):
                where = f"mistuning: {joint}.{name}"
                if name not in allowed:
                    raise InputError(f"{where}: allowed: {', '.join(allowed)}")
                wide = frequency.shape[1] if joint == "modes" else 2 if name == "slider" else 1
                share = _shares(where, size, (N, wide), rng)
                if joint == "modes":
                    frequency = share
                    continue
                own = contacts.of(joint)[:, None]
                drawn[name] += np.where(own, scales.get(name, 1.0) * share[:, None], 0.0)
        flat = {name: drawn[name][:, :, 0] for name in ("interference", "mu", "kn")}
        pairs = {name: drawn[name] for name in ("kt", "slider")}
        return cls(N, **flat, **pairs, frequency=frequency, modes=modes)

    def of(self, system: System) -> Self:
        """The same with all arrays of the sizes that a system has.

        Raises
        ------
        InputError
            If shapes do not fit the system, or a contact would have no stiffness or friction below
            zero.
        """
        N, c = system.sectors, system.contacts.count
        r = 0 if self.modes is None else len(self.modes.stiffness)
        if self.sectors != N:
            raise InputError(f"mistuning: of {self.sectors} sectors: the system has {N}")
        whole: dict[str, Any] = {}
        for name, behind in _BEHIND.items():
            given, shape = getattr(self, name), (N, r if name == "frequency" else c, *behind)
            whole[name] = given if given.size else np.zeros(shape)
            if whole[name].shape != shape:
                raise InputError(f"mistuning.{name}: given shape {given.shape}: needs {shape}")
            if not np.all(np.isfinite(given)):
                raise InputError(f"mistuning.{name}: holds values that are not finite")
            above = ">=" if name == "mu" else ">"
            if name in _RELATIVE and np.any(given < -1 if name == "mu" else given <= -1):
                least = f"{given.min():g}"
                raise InputError(f"mistuning.{name}: given {least}: relative, must be {above} -1")
        for name in ("slider", "mu", "kn", "kt"):
            if np.any(whole[name][:, ~system.contacts.springs]):
                raise InputError(f"mistuning.{name}: elements follow laws of their own")
        return replace(self, **whole)

    def share(self, part: float) -> Self:
        """All deviations times a number."""
        return replace(self, **{name: part * getattr(self, name) for name in _BEHIND})


def _shares(
    where: str, deviations: float | ArrayLike, shape: tuple[int, int], rng: np.random.Generator
) -> Floats:
    """Deviations of all sectors: drawn with a standard deviation, or as given."""
    size = np.asarray(deviations, float)
    if size.ndim == 0:
        if not (np.isfinite(size) and size >= 0):
            raise InputError(f"{where}: given {size}: must be >= 0")
        return np.asarray(size * rng.standard_normal(shape))
    if size.shape not in (shape[:1], shape):
        raise InputError(f"{where}: given shape {size.shape}: needs {shape[:1]}, one a sector")
    return np.broadcast_to(size.reshape(shape[0], -1), shape).copy()
