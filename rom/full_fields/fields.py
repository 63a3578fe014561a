"""What a recovered displacement gives in any sector of the annulus: strain, stress, functionals.

Sector j moves as sector 0 turned by 2πj/N about the engine axis and later by the phase j φ,
φ = 2π ND/N: u_j = R_z(2πj/N) u_0 e^{-ijφ}, and so do strain and stress. A functional that is
attached to the part, such as a strain gauge, turns with it and takes the phase alone.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock import fem
from vanelock.common.arrays import Array, Complex
from vanelock.common.cyclic import phase_factor, turn

if TYPE_CHECKING:
    from vanelock.rom.full_fields.recover import Recovery


def in_sector(displacement: Array, nodal_diameter: int, sectors: int, sector: int) -> Complex:
    """Displacement (nodes, 3) or (nodes, 3, k) of a sector, from that of sector 0."""
    phase = phase_factor(nodal_diameter * sector, sectors)
    return np.asarray(np.einsum("ij,nj...->ni...", turn(sectors, sector) * phase, displacement))


def strain(
    recovery: "Recovery", coordinates: Complex, nodal_diameter: int, sector: int = 0
) -> Complex:
    """Strain at the nodes of a sector, (nodes, 6) or (nodes, 6, k); see `fem.strain`.

    On the faces that neighbouring sectors share, the neighbour's elements count as well.
    """
    found = _strain(recovery, coordinates, nodal_diameter)
    return _turned(found, recovery, nodal_diameter, sector, shear=2.0)


def stress(
    recovery: "Recovery",
    coordinates: Complex,
    nodal_diameter: int,
    sector: int = 0,
    growth: ArrayLike | None = None,
) -> Complex:
    """Stress at the nodes of a sector, Pa, shaped as `strain`; see `fem.stress`."""
    elastic = _strain(recovery, coordinates, nodal_diameter, growth)
    found = fem.hooke(recovery.model.material, elastic)
    return _turned(found, recovery, nodal_diameter, sector, shear=1.0)


def rows(recovery: "Recovery", functional: Any, nodal_diameter: int, sector: int = 0) -> Complex:
    """Rows (g, n) in reduced coordinates of functionals (g, 3·nodes) of the displacements.

    One solve a functional, instead of one a point of a response: `rows @ coordinates`.
    """
    free = fem.free_rows(recovery.model, functional)
    phase = phase_factor(nodal_diameter * sector, recovery.model.part.sectors)
    return np.asarray(phase * recovery.adjoint(free, nodal_diameter))


def _strain(
    recovery: "Recovery",
    coordinates: Complex,
    nodal_diameter: int,
    growth: ArrayLike | None = None,
) -> Complex:
    part = recovery.model.part
    u = recovery.displacement(coordinates, nodal_diameter)
    total, volume = fem.strain_sums(part, u, growth)
    if recovery.component.cyclic:
        # right[i] of this sector is left[i] of the next, where the field is turned and delayed.
        left, right = part.nodes("left"), part.nodes("right")
        off_axis = left != right
        left, right = left[off_axis], right[off_axis]
        phase = phase_factor(nodal_diameter, part.sectors)
        ahead, behind = turn(part.sectors), turn(part.sectors, -1)
        at_left = total[left] + fem.turned(total[right], behind, shear=2.0) / phase
        total[right] = fem.turned(at_left, ahead, shear=2.0) * phase
        total[left] = at_left
        volume[left] = volume[right] = volume[left] + volume[right]
    return np.asarray(total / volume.reshape(-1, *(1,) * (total.ndim - 1)))


def _turned(
    tensors: Complex,
    recovery: "Recovery",
    nodal_diameter: int,
    sector: int,
    shear: float,
) -> Complex:
    sectors = recovery.model.part.sectors
    phase = phase_factor(nodal_diameter * sector, sectors)
    return np.asarray(phase * fem.turned(tensors, turn(sectors, sector), shear))
