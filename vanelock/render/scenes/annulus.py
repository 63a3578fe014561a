"""A sector's complex shape in time and around the ring (numbers only, nothing drawn).

A travelling wave of nodal diameter ND has, in cylindrical components, x_j = x_0 e^{-i j φ} on
sector j, φ = 2π ND/N; in Cartesian ones the vectors are also turned by 2π j/N about the engine
axis z. The displacement at the phase angle α = ωt is Re(x e^{iα}).
"""

import numpy as np

from vanelock.common.arrays import Complex, Floats
from vanelock.common.cyclic import turn


def wave_name(nodal_diameter: int, sectors: int) -> str:
    """Words for a wave; the diameter N - k is k's wave travelling backward."""
    k = nodal_diameter % sectors
    if 2 * k > sectors:
        return f"nodal diameter {sectors - k}, backward wave"
    return f"nodal diameter {k}"


def sector_points(points: Floats, sector: int, sectors: int) -> Floats:
    """(n, 3) coordinates of the same nodes on sector j, m."""
    return points @ turn(sectors, sector).T


def at(shape: Complex, angle: float) -> Floats:
    """Displacement at the phase angle α = ωt in radians, Re(x e^{iα})."""
    moved: Floats = np.real(np.asarray(shape) * np.exp(1j * angle))
    return moved


def peak(shape: Complex) -> Floats:
    """(n,) largest length that each node's displacement reaches in a cycle.

    The node runs along an ellipse; this is its larger half axis, with
    max_t |Re(x e^{iωt})|² = (x·x̄ + |x·x|) / 2. Where the components move in phase it equals |x|.
    """
    shape = np.asarray(shape)
    norm = np.sum(np.abs(shape) ** 2, axis=-1)
    largest: Floats = np.sqrt((norm + np.abs(np.sum(shape**2, axis=-1))) / 2)
    return largest


def largest_instant(*shapes: Complex) -> float:
    """Phase angle α in radians at which Σ|Re(x e^{iα})|² over the nodes of all shapes peaks."""
    square = sum(complex(np.sum(np.asarray(shape) ** 2)) for shape in shapes)
    return float(-np.angle(square) / 2) if square else 0.0


def cylindrical(points: Floats, shape: Complex) -> Complex:
    """(n, 3) radial, circumferential and axial components at each node's own angle."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = np.asarray(shape).T
    return np.column_stack([c * x + s * y, -s * x + c * y, z])


def round_scale(largest: float, drawn: float) -> float:
    """Round factor (1, 2 or 5 times a power of ten) that draws `largest` as at most `drawn`."""
    if not largest > 0:
        return 1.0
    wanted = drawn / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * decade for step in (1, 2, 5) if step * decade <= wanted * (1 + 1e-9)))
