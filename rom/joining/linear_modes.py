"""Linear modes of a joined system, its contacts linear springs or open, and what nothing holds."""

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Booleans, Complex, Floats
from vanelock.common.errors import InputError
from vanelock.rom.fixed_interface.held import NONE, lowest
from vanelock.rom.system.system import Matrix, System

_FREE = 1e-11
"""Scaled stiffness of a motion below which nothing holds it: of bodies a hundred to a thousand
times longer than thick, round-off leaves up to 2e-12, their softest elastic motion has 3e-7."""

_STIFF = 1e6  # a spring so many times stiffer than the structure would cost digits of it in a sum


def linear_modes(
    system: System, nodal_diameter: int, count: int, closed: Booleans | None = None
) -> tuple[Floats, Complex]:
    """Lowest modes at a nodal diameter.

    Parameters
    ----------
    system : System
        The joined parts.
    nodal_diameter : int
        ND.
    count : int
        Number of modes.
    closed : (c,) bool, optional
        Contacts that act as linear springs; the others, and elements, are open. Default: all.

    Returns
    -------
    frequency : (count,) float
        Hz, ascending.
    shapes : (n, count)
        Mass-normalised.

    Where fewer coordinates have a mass, there are fewer modes.

    Raises
    ------
    InputError
        If the system has not so many coordinates, the mass is negative in some direction, or
        nothing holds a massless coordinate.
    """
    matrices = system.at(nodal_diameter)
    if not 1 <= count <= len(matrices.K):
        raise InputError(f"{count} modes of a system of {len(matrices.K)} coordinates")
    K = linear_stiffness(system, nodal_diameter, closed)
    omega2, shapes = lowest(K, matrices.M, count)
    return np.sqrt(omega2.clip(0)) / (2 * np.pi), shapes


def linear_stiffness(system: System, nodal_diameter: int, closed: Booleans | None = None) -> Matrix:
    """(n, n) stiffness at a nodal diameter, contacts as for `linear_modes`."""
    K = system.at(nodal_diameter).K
    chosen = np.ones(system.contacts.count, bool) if closed is None else np.asarray(closed, bool)
    chosen = chosen & system.contacts.springs
    B = system.contact_rows(nodal_diameter)[chosen].reshape(-1, len(K))
    stiffness = system.contacts.stiffness[chosen].ravel()
    return np.asarray(K + (B.conj().T * stiffness) @ B)


def free_motions(K: Matrix, M: Matrix) -> Matrix:
    """Motions that a stiffness leaves free, such as rigid ones of a body that nothing holds.

    They are eigenvectors of D K D, D = diag(max(K_ii, κ M_ii))^-1/2 with κ = tr K / tr M: stiffness
    condensed to a few rows of a free body may be nothing but round-off, which its mass shows.

    Parameters
    ----------
    K, M : (n, n)
        Hermitian stiffness, N/m, and mass, kg.

    Returns
    -------
    (n, r)
        Orthonormal in the mass; none where K is positive definite, or where it is indefinite.

    Raises
    ------
    InputError
        If one of them has no mass.
    """
    own, mass = K.diagonal().real, M.diagonal().real
    size = np.maximum(own, mass * own.sum() / (mass.sum() or 1.0))
    d = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    scaled = d[:, None] * K * d
    try:
        sl.cholesky(scaled - _FREE * np.eye(len(K)), check_finite=False)
    except sl.LinAlgError:
        values, turns = sl.eigh(scaled, subset_by_value=(-np.inf, _FREE))
        motions = d[:, None] * turns[:, np.abs(values) <= _FREE]
        inertia, turns = sl.eigh(motions.conj().T @ M @ motions)
        if np.any(inertia <= NONE * np.abs(M).max() * np.linalg.norm(motions) ** 2):
            raise InputError("a motion without mass is held by nothing") from None
        return np.asarray(motions @ turns / np.sqrt(inertia))
    return np.zeros((len(K), 0), K.dtype)


def unheld_motions(system: System, nodal_diameter: int, holding: Booleans | None = None) -> Matrix:
    """Motions that neither the structure nor contacts as springs hold, of `free_motions`.

    Springs stiffer than the structure count as stiff as it is: what is held does not depend on it,
    but beside far stiffer springs the structure would be taken for round-off.

    Parameters
    ----------
    system : System
        The joined parts.
    nodal_diameter : int
        ND.
    holding : (c,) bool, optional
        Contacts that count; default: all but elements.

    Returns
    -------
    (n, r)
        Orthonormal in the mass.

    Raises
    ------
    InputError
        If one of them has no mass.
    """
    K, M = system.at(nodal_diameter).K, system.at(nodal_diameter).M
    chosen = system.contacts.springs if holding is None else holding
    B = system.contact_rows(nodal_diameter)[chosen].reshape(-1, len(K))
    reach = (np.abs(B) ** 2).sum(axis=1)
    limit = K.diagonal().real.max(initial=0.0) or np.inf
    springs = np.minimum(
        system.contacts.stiffness[chosen].ravel(), limit / np.where(reach > 0, reach, 1.0)
    )
    held = K + (B.conj().T * springs) @ B
    return free_motions(held if np.any(held.imag) else held.real, M)


def apart_from_springs(K: Matrix, B: Matrix, springs: Matrix) -> tuple[Matrix, Matrix] | None:
    """Coordinates in which K + Bᴴ k B keeps the digits of K, where springs are far stiffer.

    With Q, R of the pivoted QR decomposition of Bᴴ k^½, x = Q y: the stiffest springs move the
    first of y, and none move those after the last spring, so that factors are graded.
    """
    reach = springs * (np.abs(B) ** 2).sum(axis=1)
    if not reach.max(initial=0.0) > _STIFF * K.diagonal().real.max(initial=0.0) > 0:
        return None
    weight = np.sqrt(np.where(springs > 0, springs, 1.0))
    Q, R, order = sl.qr((weight[:, None] * B).conj().T, pivoting=True)
    rounding = 4 * len(K) * np.finfo(float).eps
    R[np.abs(R) <= rounding * np.linalg.norm(R, axis=0)] = 0.0
    rows = np.zeros_like(B, R.dtype)
    rows[order] = R.conj().T
    return Q, rows / weight[:, None]


def linear_damping(system: System, nodal_diameter: int) -> Matrix:
    """(n, n) damping at a nodal diameter, the modal one Σ 2ζω_j (M V_j)(M V_j)ᴴ included."""
    matrices = system.at(nodal_diameter)
    n = len(matrices.K)
    C = np.zeros((n, n)) if matrices.C is None else matrices.C
    if system.damping_ratio:
        hertz, V = linear_modes(system, nodal_diameter, n, ~system.opens_in_damping)
        MV = matrices.M @ V
        C = C + (MV * (2 * system.damping_ratio * 2 * np.pi * hertz)) @ MV.conj().T
    return C


def mac(a: Complex, b: Complex, M: Complex) -> Floats:
    """Modal assurance criterion |aᴴMb|² / (aᴴMa · bᴴMb) of each pair of columns, (j, k)."""
    cross = np.abs(a.conj().T @ (M @ b)) ** 2
    norm_a = np.einsum("ij,ij->j", a.conj(), M @ a).real
    norm_b = np.einsum("ij,ij->j", b.conj(), M @ b).real
    return np.asarray(cross / np.outer(norm_a, norm_b))
