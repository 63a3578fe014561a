"""Stress at the nodes of a part, and what is read off it: von Mises, over a period too.

A stress is the vector (σ_xx, σ_yy, σ_zz, τ_yz, τ_zx, τ_xy). Harmonic h of a periodic one is its
complex coefficient σ_h in σ(t) = σ_0 + Re Σ σ_h e^{ihωt}.
"""

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Complex, Floats
from vanelock.fem.model import Model
from vanelock.fem.stresses.strains import hooke, strain

NODES = 4096
"""Nodes whose period is looked at together."""

_DEVIATOR = np.sqrt(np.array([[0.75], [0.25], [3.0], [3.0], [3.0]])) * [
    [1, -1, 0, 0, 0, 0],
    [1, 1, -2, 0, 0, 0],
    [0, 0, 0, 1, 0, 0],
    [0, 0, 0, 0, 1, 0],
    [0, 0, 0, 0, 0, 1],
]  # five numbers of a stress, whose Euclidean norm is its von Mises stress

_PLACES = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])  # of the components in a 3 x 3 tensor


def stress(model: Model, u: Array, growth: ArrayLike | None = None) -> Array:
    """Stress at the nodes, (nodes, 6) or (nodes, 6, k), Pa, of displacement fields; see `strain`.

    Parameters
    ----------
    model : Model
        Part and material.
    u : (nodes, 3) or (nodes, 3, k), real or complex
        Displacement fields, m.
    growth : float or (nodes,) float, optional
        Thermal strain α (T - T_ref) of the fields: σ = D (ε - α (T - T_ref)).

    Raises
    ------
    InputError
        If the field does not belong to the part.
    """
    return hooke(model.material, strain(model.part, u, growth))


def von_mises(s: Floats) -> Floats:
    """Von Mises stress of real stresses whose second axis holds the components.

    Examples
    --------
    >>> import numpy as np
    >>> von_mises(np.array([[3.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1.0]])).round(4).tolist()
    [3.0, 1.7321]
    """
    return np.asarray(np.linalg.norm(np.tensordot(_DEVIATOR, s, (1, 1)), axis=0))


def peak_von_mises(harmonics: Complex) -> Floats:
    """Largest von Mises stress over a period at each node, Pa.

    Parameters
    ----------
    harmonics : (H+1, nodes, 6) complex
        Coefficients of harmonics 0, the mean, to H.

    Returns
    -------
    (nodes,) float
        Its square is a trigonometric polynomial of degree 2H; every maximum of its samples is
        followed to the maximum of the polynomial.
    """
    nodes = harmonics.shape[1]
    peaks = np.empty(nodes)
    for start in range(0, nodes, NODES):
        block = slice(start, start + NODES)
        peaks[block] = _peaks(harmonics[:, block])
    return peaks


def deviators(harmonics: Complex, count: int) -> Floats:
    """Five numbers of a periodic stress, whose Euclidean norm is its von Mises stress, Pa.

    Parameters
    ----------
    harmonics : (H+1, nodes, 6) complex
        Coefficients of harmonics 0, the mean, to H.
    count : int
        Instants of the period, evenly spread, at least 2H + 1.

    Returns
    -------
    (count, nodes, 5) float
        Linear in the stress, so that differences are those of stresses.
    """
    halves = harmonics @ _DEVIATOR.T / 2
    halves[0] = 2 * halves[0].real
    return np.asarray(np.fft.irfft(halves, count, axis=0, norm="forward"))


def principal_amplitude(s: Complex) -> Floats:
    """Largest amplitude of the normal stress on any plane, of a harmonic stress, Pa.

    That is the largest principal stress of Re(σ e^{iωt}) at any time.

    Parameters
    ----------
    s : (nodes, 6) complex
        Coefficient of one harmonic.

    Returns
    -------
    (nodes,) float
    """
    peaks = np.empty(len(s))
    for start in range(0, len(s), NODES):
        peaks[start : start + NODES] = _principal(s[start : start + NODES, _PLACES])
    return peaks


def turned(s: Array, rotation: Floats, shear: float = 1.0) -> Array:
    """Components of tensors (..., 6, ...) along axis 1 after a rotation of the body.

    Parameters
    ----------
    s : (nodes, 6) or (nodes, 6, k)
        Stresses, or strains with `shear` = 2.
    rotation : (3, 3) float
    shear : float
        What the off-diagonal components are multiplied by in the vector.
    """
    factor = np.array([1, 1, 1, shear, shear, shear])
    factor = factor.reshape(6, *(1,) * (s.ndim - 2))
    tensor = (s / factor)[:, _PLACES]
    new = np.einsum("ia,nab...,jb->nij...", rotation, tensor, rotation)
    first, second = [0, 1, 2, 1, 2, 0], [0, 1, 2, 2, 0, 1]
    return np.asarray(new[:, first, second] * factor)


def _peaks(harmonics: Complex) -> Floats:
    degree = len(harmonics) - 1
    count = 16 * degree + 1
    step = 2 * np.pi / count
    samples = np.sum(deviators(harmonics, count) ** 2, axis=2)
    best = samples.max(axis=0)
    rise = (samples >= np.roll(samples, 1, axis=0)) & (samples >= np.roll(samples, -1, axis=0))
    at, node = np.nonzero(rise)
    order = np.arange(2 * degree + 1)
    polynomial = np.fft.rfft(samples, axis=0)[: len(order)] / count
    polynomial[1:] *= 2
    c = polynomial[:, node]
    angle = at * step
    for _ in range(6):  # Newton's method, no further than the neighbouring samples
        wave = c * np.exp(1j * order[:, None] * angle)
        slope = -(order @ wave.imag)
        bend = -(order**2 @ wave.real)
        move = np.divide(-slope, bend, out=np.zeros_like(slope), where=bend < 0)
        angle = np.clip(angle + move, (at - 1) * step, (at + 1) * step)
    refined = np.sum((c * np.exp(1j * order[:, None] * angle)).real, axis=0)
    np.maximum.at(best, node, refined)
    return np.asarray(np.sqrt(best.clip(0)))


def _principal(tensor: Complex) -> Floats:
    """Largest |n·σn| over unit vectors n of complex symmetric tensors (nodes, 3, 3).

    That is the largest eigenvalue λ of Re(σ e^{iθ}) over all phases θ. Every maximum over sampled
    phases is followed by Newton's method, with λ' and λ'' from perturbation of the eigenvalue, or
    where that would lead to a minimum by the best phase for the current eigenvector.
    """
    phases = np.exp(2j * np.pi * np.arange(16) / 16)
    samples = np.stack([np.linalg.eigvalsh((tensor * phase).real)[:, -1] for phase in phases])
    best = np.asarray(samples.max(axis=0))
    rise = (samples >= np.roll(samples, 1, axis=0)) & (samples >= np.roll(samples, -1, axis=0))
    at, node = np.nonzero(rise)
    angle, chosen = 2 * np.pi * at / 16, tensor[node]
    for _ in range(8):
        wave = chosen * np.exp(1j * angle)[:, None, None]
        values, vectors = np.linalg.eigh(wave.real)
        n = vectors[:, :, -1]
        np.maximum.at(best, node, values[:, -1])
        slope = -np.einsum("ni,nij,njk->nk", n, wave.imag, vectors)  # of Re(σ e^{iθ}) by θ
        gap = np.maximum(values[:, -1:] - values[:, :-1], 1e-300)
        bend = 2 * np.sum(slope[:, :-1] ** 2 / gap, axis=1) - values[:, -1]
        towards = np.arctan2(slope[:, -1], values[:, -1])
        angle = angle + np.divide(-slope[:, -1], bend, out=towards, where=bend < 0)
    return best
