"""An independent check of solved points: the balance in all coordinates, and of power.

Nothing here comes from the solver but the response: matrices of the system as given, modal damping
built from its definition, contacts marched through their three states (`_march_contacts`). With
B_h = own + next e^{-ihφ}, D_h = K - (hω)² M + ihω C and one-sided coefficients,

    r_h = D_h x^(h) + B_hᴴ λ^(h) - f^(h),
    Σ_h ½ hω Im(x^(h)ᴴ f^(h)) = Σ_h ½ (hω)² x^(h)ᴴ C x^(h) + Σ_c (1/T) ∮ t dw,

all for one sector. The friction power is that of the marched loops: taken from the balanced
coefficients instead, the sum of powers would follow from r = 0 and check nothing.

The march shares nothing with the law that the solver uses, neither the picture of a slider nor
located events. From one sample to the next

    n = max(kn v, 0),      t ← clip(t + kt Δu, -μn, μn),

where Δu counts from the instant of touching down, v being linear in between; an open contact has
n = 0 and thus t = 0. The error falls with the square of the number of samples.

Isotropic friction returns what exceeds μn to the circle along the mean of the old and the new force
(the generalised midpoint rule, Simo & Taylor 1986): with p = t + kt Δu, the new force lies where
the ray from -t through p meets it. A round goes through all samples, and rounds follow until one
begins where it ends.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg as la

from vanelock.common.arrays import Array, Floats
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.forced_response.response import Response, chosen_points
from vanelock.nonlinear.fourier import kernel
from vanelock.rom.joining.linear_modes import unheld_motions
from vanelock.rom.system.system import Contacts, Diameter, System

_ROUNDS, _REPEATS = 200, 1e-13
"""Most rounds, and of the largest force how closely one repeats the last."""
_SAMPLES = 2**17
_FINEST = 1e-4
"""Static or vibrating forces are compared with the others times this where they are smaller."""


def _march_contacts(
    contacts: Contacts,
    displacement: Array,
    samples: int,
    friction: str = "orthogonal",
    begin: Floats | None = None,
) -> tuple[Array, Floats]:
    """Forces and friction work of contacts under periodic relative displacements.

    One-sided coefficients (H + 1, c, 3) of (n, t1, t2), N, real for h = 0, and the friction work of
    a period, ∮ t dw over the steps that slip, (c,) J.
    """
    at_zero = contacts.kt * displacement[:, :, 1:].sum(axis=0).real
    start = at_zero if begin is None else begin
    force = np.zeros((len(displacement), contacts.count, 3), complex)
    work = np.zeros(contacts.count)
    isotropic, path = friction == "isotropic", np.empty((samples, 3))
    for c in range(contacts.count):
        u, t = np.ascontiguousarray(_histories(displacement[:, c], samples)), start[c].astype(float)
        bound = contacts.mu[c] * contacts.kn[c] * max(u[0, 0], 0.0)
        if isotropic:
            t *= min(1.0, bound / max(math.hypot(*t), np.finfo(float).tiny))
        else:
            t = t.clip(-bound, bound)
        for _ in range(_ROUNDS):
            begun = t.copy()
            work[c] = _round(u, contacts.kn[c], contacts.kt[c], contacts.mu[c], isotropic, t, path)
            if np.abs(t - begun).max() <= _REPEATS * np.abs(path[:, 1:]).max():
                break
        force[:, c] = _coefficients(path, len(displacement) - 1)
    return force, work


def _histories(q: Array, samples: int) -> Floats:
    """(samples, ...) values over a period of one-sided coefficients (H + 1, ...)."""
    spectrum = q * (samples / 2)
    spectrum[0] = q[0].real * samples
    return np.asarray(np.fft.irfft(spectrum, n=samples, axis=0))


def _coefficients(history: Floats, harmonics: int) -> Array:
    """One-sided coefficients (H + 1, ...) of values over a period (samples, ...)."""
    q: Array = np.fft.rfft(history, axis=0)[: harmonics + 1] * (2 / len(history))
    q[0] /= 2
    return q


@kernel
def _round(
    u: Floats, kn: float, kt: Floats, mu: float, isotropic: bool, t: Floats, path: Floats
) -> float:
    """Friction work of one round from a force t (2,) at sample 0, which the last one replaces.

    Displacements and forces are (s, 3). A step slips where it ends at the bound, that of lift-off
    too; slips within rounding of the displacement are none.
    """
    work, count = 0.0, len(u)
    rounding = 16 * 2.3e-16 * max(np.abs(u[:, 1]).max(), np.abs(u[:, 2]).max())
    for j in range(1, count + 1):
        i = j if j < count else 0
        v, before = u[i, 0], u[i - 1, 0]
        n = kn * max(v, 0.0)
        bound = mu * n
        share = v / (v - before) if before < 0.0 < v else 1.0
        x = kt[0] * share * (u[i, 1] - u[i - 1, 1])
        y = kt[1] * share * (u[i, 2] - u[i - 1, 2])
        px, py = t[0] + x, t[1] + y
        if not isotropic:
            px, py = min(max(px, -bound), bound), min(max(py, -bound), bound)
            slips_x, slips_y = abs(px) >= bound, abs(py) >= bound
        else:
            slips_x = slips_y = math.hypot(px, py) > bound
            if slips_x:
                # |s (p + t) - t| = bound: the larger root is where the ray leaves the circle.
                ax, ay = px + t[0], py + t[1]
                square = max(ax * ax + ay * ay, 1e-300)
                half = (ax * t[0] + ay * t[1]) / square
                inside = half * half - (t[0] * t[0] + t[1] * t[1] - bound * bound) / square
                s = half + math.sqrt(max(inside, 0.0))
                px, py = s * ax - t[0], s * ay - t[1]
                size = math.hypot(px, py)
                shrink = bound / size if size > 0.0 else 0.0
                px, py = shrink * px, shrink * py
        slid = (x - (px - t[0])) / kt[0]
        if slips_x and abs(slid) > rounding:
            work += 0.5 * (px + t[0]) * slid
        slid = (y - (py - t[1])) / kt[1]
        if slips_y and abs(slid) > rounding:
            work += 0.5 * (py + t[1]) * slid
        t[0], t[1] = px, py
        path[i, 0], path[i, 1], path[i, 2] = n, px, py
    return work


@dataclass(frozen=True)
class Audit(Product):
    """Figures of each checked point; those of power are for one sector.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    residual : (p,) float
        Largest entry of r_h over `scale`: of the static balance over the first, of the harmonics
        h >= 1 over the second.
    scale : (p, 2) float
        Largest entry of f, B^H λ or D x in the static balance, and in all others; none below 1e-4
        of the other.
    residual_error : (p,) float
        How far off `residual` itself may be: the change from half the samples to all of them, or
        a quarter of that from a quarter to half of them if larger (the error falls to a quarter),
        and rounding.
    force_difference : (p,) float
        Largest difference between the contact forces in the response and the marched ones, over
        the largest marched one.
    excitation_power : (p,) float
        Power of the excitation, W.
    viscous_power : (p,) float
        Power of the damping, W.
    friction_power : (p, c) float
        Power of friction in each contact, W.
    imbalance : (p,) float
        Difference of the powers over the largest of them.
    imbalance_error : (p,) float
        How far off `imbalance` itself may be, likewise.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    residual: Floats
    scale: Floats = field(metadata={"unit": "N"})
    residual_error: Floats
    force_difference: Floats
    excitation_power: Floats = field(metadata={"unit": "W"})
    viscous_power: Floats = field(metadata={"unit": "W"})
    friction_power: Floats = field(metadata={"unit": "W"})
    imbalance: Floats
    imbalance_error: Floats


def audit_response(
    system: System, response: Response, points: Sequence[int] | None = None, samples: int = _SAMPLES
) -> Audit:
    """Check points of a nonlinear response by other means than those that found it.

    Parameters
    ----------
    system : System
        The one that was solved.
    response : Response
        Solved with located events; with `samples` its error shows as a residual.
    points : sequence of int, optional
        Which; all by default. A point that has not converged is checked like any other.
    samples : int
        Of the marched period, a power of two.

    Returns
    -------
    Audit
        One row for each point, in the order of `points`.

    Raises
    ------
    InputError
        If a point does not exist, the response is not one of this system, or `samples` does not
        suffice or is no power of two.
    """
    system.contacts.refuse_elements("an audit")
    if samples & (samples - 1) or samples < 64 * (response.harmonics + 1):
        needed = 64 * (response.harmonics + 1)
        raise InputError(f"samples: given {samples}: a power of two, at least {needed}")
    if response.coupling != "coupled":
        raise InputError(f"response: {response.coupling}: an audit is of coupled balances")
    chosen = chosen_points(response, points)
    sizes = {int(k): len(system.at(int(k)).K) for k in response.harmonic_diameters}
    fits = len(response.mu) == system.contacts.count and all(
        response.x[h].shape[1] == sizes[int(k)] for h, k in enumerate(response.harmonic_diameters)
    )
    if not fits:
        raise InputError("response: has other coordinates or contacts than the system")
    damping = {k: _damping_matrix(system, k) for k in sizes}
    rows = [_checked(system, response, point, damping, samples) for point in chosen]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return Audit(frequency=response.frequency[chosen], **columns)


def _damping_matrix(system: System, nodal_diameter: int) -> Array:
    """C + Σ_j 2ζω_j (M V_j)(M V_j)ᴴ, V_j the mass-normalised modes, joints as the system says.

    Massless coordinates have no modes: those of M against the stiffness serve there.
    """
    matrices = system.at(nodal_diameter)
    n = len(matrices.K)
    C = np.zeros((n, n)) if matrices.C is None else matrices.C
    if not system.damping_ratio:
        return C
    closed = ~system.opens_in_damping
    B = system.contact_rows(nodal_diameter)[closed].reshape(-1, n)
    held = matrices.K + (B.conj().T * system.contacts.stiffness[closed].reshape(-1)) @ B
    try:
        omega2, V = la.eigh(held, matrices.M)
        weight = 2 * system.damping_ratio * np.sqrt(omega2.clip(min=0))
    except la.LinAlgError:
        inverse, V = la.eigh(matrices.M, held)
        moving = inverse > 1e-14 * inverse.max()
        V = V[:, moving] / np.sqrt(inverse[moving])
        weight = 2 * system.damping_ratio / np.sqrt(inverse[moving])
    MV = matrices.M @ V
    return np.asarray(C + (MV * weight) @ MV.conj().T)


@dataclass(frozen=True)
class _Harmonic:
    """One harmonic of one point: matrices, coordinates, excitation."""

    matrices: Diameter
    B: Array  # (3c, n)
    C: Array
    x: Array
    f: Array
    s: float  # hω

    def inner(self) -> Array:
        """D x."""
        motion: Array = self.matrices.K @ self.x - self.s**2 * (self.matrices.M @ self.x)
        return motion + 1j * self.s * (self.C @ self.x)

    def rounding(self, stiffness: Floats) -> float:
        """What rounding of the terms of the residual may come to."""
        size = np.abs(self.x)
        K, M, C = (np.abs(matrix) for matrix in (self.matrices.K, self.matrices.M, self.C))
        terms = K @ size + self.s**2 * (M @ size) + self.s * (C @ size)
        B = np.abs(self.B)
        terms += B.T @ (stiffness * (B @ size))
        return float(np.finfo(float).eps * len(size) * terms.max(initial=0.0))


def _harmonics(
    system: System, response: Response, point: int, damping: dict[int, Array]
) -> list[_Harmonic]:
    omega = 2 * np.pi * float(response.frequency[point])
    found = []
    for h, k in enumerate(response.harmonic_diameters):
        matrices, x = system.at(int(k)), response.x[h][point]
        force = system.force.get(h)
        f = np.zeros(len(x), complex) if force is None else force.at(omega)
        B = system.contact_rows(int(k)).reshape(-1, len(x))
        if h == 0:  # what nothing holds is balanced by its inertia
            R = unheld_motions(system, int(k))
            f = f - matrices.M @ (R @ (R.conj().T @ f))
        found.append(_Harmonic(matrices, B, damping[int(k)], x, f, h * omega))
    return found


def _checked(
    system: System, response: Response, point: int, damping: dict[int, Array], samples: int
) -> dict[str, Any]:
    """One row of the audit."""
    contacts = system.contacts
    harmonics = _harmonics(system, response, point, damping)
    moved = np.array([each.B @ each.x for each in harmonics], complex)
    moved = moved.reshape(len(harmonics), contacts.count, 3)
    moved[0] += contacts.offset
    # Where the response's sliders rest is what it leaves open; elsewhere a beginning is forgotten.
    begin = None
    if response.friction == "isotropic":
        begin = response.force[point, :, :, 1:].sum(axis=0).real
    (force, work), *coarse = (
        _march_contacts(contacts, moved, samples // part, response.friction, begin)
        for part in (1, 2, 4)
    )
    stiffness = contacts.stiffness.reshape(-1)
    rounded = stiffness * np.abs(moved).sum(axis=0).reshape(-1)  # springs on which forces are taken
    residual, scale, error = _balance(harmonics, stiffness, rounded, force, coarse)
    largest = np.abs(force).max(initial=0.0)
    apart = np.abs(force - response.force[point]).max(initial=0.0)
    hertz = float(response.frequency[point])
    excitation = sum(0.5 * each.s * np.vdot(each.x, each.f).imag for each in harmonics)
    viscous = sum(0.5 * each.s**2 * np.vdot(each.x, each.C @ each.x).real for each in harmonics)
    friction = work * hertz
    total = friction.sum()
    power = max(abs(excitation), abs(viscous), abs(total))
    half, quarter = (each.sum() * hertz for _, each in coarse)
    doubt = max(abs(total - half), 0.25 * abs(half - quarter)) + sum(
        each.s * np.linalg.norm(each.x) * each.rounding(stiffness) for each in harmonics
    )
    return {
        "residual": residual,
        "scale": scale,
        "residual_error": error,
        "force_difference": apart / largest if largest > 0 else 0.0,
        "excitation_power": excitation,
        "viscous_power": viscous,
        "friction_power": friction,
        "imbalance": abs(excitation - viscous - total) / power if power > 0 else 0.0,
        "imbalance_error": doubt / power if power > 0 else 0.0,
    }


def _balance(
    harmonics: list[_Harmonic],
    stiffness: Floats,
    rounded: Floats,
    fine: Array,
    coarse: list[tuple[Array, Floats]],
) -> tuple[float, Floats, float]:
    """Largest relative residual, its scales, and how far off it may be."""
    size, gap, doubt = np.zeros((3, len(harmonics)))
    for h, each in enumerate(harmonics):
        inner = each.inner()
        pull = each.B.conj().T @ fine[h].reshape(-1)
        half, quarter = (force[h] for force, _ in coarse)
        changes = np.array([fine[h] - half, 0.25 * (half - quarter)]).reshape(2, -1)
        change = each.B.conj().T @ changes.T
        size[h] = max(np.abs(term).max(initial=0.0) for term in (inner, pull, each.f))
        gap[h] = np.abs(inner + pull - each.f).max(initial=0.0)
        lost = np.finfo(float).eps * (np.abs(each.B).T @ rounded).max(initial=0.0)
        doubt[h] = np.abs(change).max(initial=0.0) + lost + each.rounding(stiffness)
    moving = size[1:].max(initial=0.0)
    scale = np.maximum([size[0], moving], _FINEST * np.array([moving, size[0]]))
    by_harmonic = np.where(scale > 0, scale, 1.0)[np.minimum(np.arange(len(harmonics)), 1)]
    return float((gap / by_harmonic).max()), scale, float((doubt / by_harmonic).max())
