"""How many fixed-interface vectors a reduction keeps, as its caller says it."""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from vanelock.common.arguments import OfKind
from vanelock.common.errors import InputError
from vanelock.fem.vibration.block_lanczos import KrylovSpace, krylov_space
from vanelock.rom.fixed_interface.candidates import Candidates
from vanelock.rom.fixed_interface.held import HeldPart
from vanelock.rom.fixed_interface.massless import lowest
from vanelock.rom.fixed_interface.modes import Fixed, fixed_modes
from vanelock.rom.fixed_interface.vectors import accurate

ELASTIC = 10
"""By default the band reaches to the tenth elastic mode of the part, its masters free."""
ROUGH = 0.03  # residual of the modes that set the band
DEFAULT = 1e-4
"""Accuracy unless modes, a cut-off or another accuracy is given."""


@dataclass(frozen=True)
class Selection(OfKind):
    """One of: a number of modes, a cut-off frequency, an accuracy.

    Attributes
    ----------
    modes : int or None
        Number of the lowest fixed-interface modes.
    cutoff : float or None
        All fixed-interface modes up to this frequency, Hz.
    accuracy : float or None
        Relative error of every natural frequency in the band, see `rom.fixed_interface.vectors`.
    band : float or None
        Frequency up to which the accuracy holds, Hz; None: up to the part's tenth elastic mode.
    least : float or None
        Frequency that such a band of its own reaches at least, Hz.

    Raises
    ------
    InputError
        If more than one of them is given, or one is out of range.
    """

    modes: int | None = None
    cutoff: float | None = None
    accuracy: float | None = None
    band: float | None = None
    least: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {"modes": self.modes, "cutoff": self.cutoff, "accuracy": self.accuracy}
        reaches = {"band": self.band, "least": self.least}
        named = [f"{name} = {value:g}" for name, value in given.items() if value is not None]
        if len(named) != 1:
            raise InputError(f"{' and '.join(named) or 'nothing given'}: give one of {_one(given)}")
        if self.modes is not None and self.modes < 0:
            raise InputError(f"modes = {self.modes}: allowed are 0 and more")
        for name, value in {"cutoff": self.cutoff, **reaches}.items():
            if value is not None and not (value > 0 and math.isfinite(value)):
                raise InputError(f"{name} = {value:g} Hz: must be > 0 and finite")
        if self.accuracy is not None and not 1e-9 <= self.accuracy < 1:
            raise InputError(f"accuracy = {self.accuracy:g}: allowed are 1e-9 to 1")
        if self.band is not None and self.accuracy is None:
            raise InputError(f"band = {self.band:g} Hz: goes with accuracy only, not {named[0]}")

    def of(self, part: HeldPart) -> tuple[Candidates, float | None]:
        """What it takes of a part, and where an accuracy was asked for its band, Hz."""
        space = krylov_space(part.held.solve, part.M_ss)
        if self.accuracy is None:
            return Candidates.exactly(self.modes_in(space)), None
        band = self.band or max(own_band(part, space), self.least or 0.0)
        return accurate(part, self.accuracy, 2 * np.pi * band, space), band

    def modes_in(self, space: KrylovSpace) -> Fixed:
        """Fixed-interface modes, where these are what is wanted."""
        below = None if self.cutoff is None else 2 * np.pi * self.cutoff
        return fixed_modes(space, self.modes, below)


def _one(given: dict[str, float | None]) -> str:
    *names, last = given
    return f"{', '.join(names)} and {last}"


def own_band(part: HeldPart, space: KrylovSpace) -> float:
    """Frequency of the tenth elastic mode of a part whose masters are free, Hz, by ten modes."""
    modes = fixed_modes(space, min(ELASTIC, space.shape[1] - 1), tolerance=ROUGH)
    LB = part.inertia.gather(modes.vectors)
    K = sl.block_diag(part.K_mm, np.diag(modes.omega_squared))
    M = np.block([[part.M_mm, LB], [LB.conj().T, np.eye(LB.shape[1])]])
    last = min(len(K), ELASTIC + 6) - 1
    squared = lowest(K, M, last + 1)[0]
    elastic = squared[squared > 1e-6 * squared[-1]][:ELASTIC]
    return float(np.sqrt(elastic[-1]) / (2 * np.pi))
