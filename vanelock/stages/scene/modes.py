"""The linear limits of a scene: its modes with all contacts open and all stuck.

The mode of interest is counted with the contacts stuck, where nothing is loose, and followed to the
open structure by the modal assurance criterion.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.input.band import asked_for, refuse_beyond
from vanelock.input.schema.scene import Scene
from vanelock.rom import System, linear_modes, mac
from vanelock.stages.response.limits import RIGID, fine

SHOWN = 6
"""Frequencies in the table."""
ADVICE = 'write band = "{:g} Hz" for the reduced components, instead of modes or a cutoff if any'
"""What to write where a response leaves the band."""
LOWEST = 1e-6
"""Hz; no structure vibrates below."""
LIKE = 0.3
"""Least modal assurance criterion of a partner whose frequency bounds the default range."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SceneModes(Product):
    """Natural frequencies at the nodal diameter of the first harmonic.

    Attributes
    ----------
    nodal_diameter, sectors : int
        ND of the first harmonic, and N.
    free, stuck : (m,) float
        With all contacts open and closed, Hz.
    free_mode, stuck_mode : int
        Place of the mode of interest among them, from 0.
    mac : float
        Modal assurance criterion between the two.
    band : float or None
        Frequency up to which the reduced components answer, Hz.
    """

    nodal_diameter: int
    sectors: int
    free: Floats = field(metadata={"unit": "Hz"})
    stuck: Floats = field(metadata={"unit": "Hz"})
    free_mode: int
    stuck_mode: int
    mac: float
    band: float | None = field(default=None, metadata={"unit": "Hz"})

    def held(self, which: str, frequencies: Floats) -> bool:
        """Whether the mode of interest, "free" or "stuck", lies among frequencies, Hz."""
        free = which == "free"
        own = self.free[self.free_mode] if free else self.stuck[self.stuck_mode]
        return bool(frequencies.min() <= own <= frequencies.max())


def modes(system: System, mode: int) -> SceneModes:
    """Modes of both limits, and the mode of interest in both.

    Raises
    ------
    InputError
        If the system has not so many modes.
    """
    k = system.nodal_diameter(1)
    size = len(system.at(k).K)
    if mode > size:
        raise InputError(f"response.mode = {mode}: the reduced model has {size} modes")
    count = min(size, max(SHOWN, mode + 6))
    none = np.zeros(system.contacts.count, bool)
    free, free_shapes = linear_modes(system, k, count, closed=none)
    stuck, stuck_shapes = linear_modes(system, k, count)
    if mode > len(stuck):
        raise InputError(f"response.mode = {mode}: only {len(stuck)} modes have a mass")
    likeness = mac(stuck_shapes[:, [mode - 1]], free_shapes, system.at(k).M)[0]
    partner = int(likeness.argmax())
    alike = float(likeness[partner])
    return SceneModes(k, system.sectors, free, stuck, partner, mode - 1, alike, system.band)


def frequencies(scene: Scene, found: SceneModes) -> Floats | tuple[float, float]:
    """Excitation frequencies, Hz; a tuple is a range.

    Where the scene names neither: around the mode of interest, open to stuck.

    Raises
    ------
    InputError
        If the mode of interest is a rigid-body motion or as slow, or a frequency beyond the band.
    """
    response = scene.response
    for key, highest in asked_for(response).items():
        refuse_beyond(key, highest, found.band, ADVICE)
    if response.frequencies is not None:
        return np.array(response.frequencies)
    stuck = float(found.stuck[found.stuck_mode])
    if response.range is not None:
        low, high = response.range
    elif stuck <= RIGID * found.stuck.max():
        raise InputError(
            f"response.mode = {found.stuck_mode + 1}: a rigid-body motion, 0 Hz, even with all "
            "contacts stuck: choose another mode, or clamp what moves"
        )
    elif stuck < LOWEST:
        raise InputError(
            f"response.mode = {found.stuck_mode + 1}: lies at {stuck:.2g} Hz: are stiffness and "
            "mass swapped, or in other units?"
        )
    else:
        free = float(found.free[found.free_mode])
        free = free if found.mac > LIKE and free > 0.3 * stuck else 0.8 * stuck
        low, high = sorted([free, stuck])
        margin = max(0.25 * (high - low), 0.05 * low)
        low, high = low - margin, high + margin
        refuse_beyond(f"response.mode = {found.stuck_mode + 1}", high, found.band, ADVICE)
    return (low, high) if response.points is None else np.linspace(low, high, response.points)


def dense(
    wanted: Floats | tuple[float, float], own: Floats, damping: float, points: int = 201
) -> Floats:
    """Frequencies at which a linear response is a true curve, Hz, fine around its `own` modes."""
    listed = np.linspace(*wanted, points) if isinstance(wanted, tuple) else np.asarray(wanted)
    low, high = listed.min(), listed.max()
    parts = [listed, np.linspace(low, high, points)]
    parts += [fine(f, damping, 61) for f in own[own > 0]]
    found = np.unique(np.concatenate(parts))
    return np.asarray(found[(found >= max(low, LOWEST)) & (found <= high)])
