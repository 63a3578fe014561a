"""The contact law over one period of given relative displacements, and its exact derivative.

With all contacts stuck and closed their force would be λ = K_c u. What a contact does instead is

    λ = K_c (u - w),      w_n = min(v, 0),      w_t = place of the friction slider,

so w, a displacement, is all that is nonlinear: it vanishes for a contact that sticks and never
slid, and it is homogeneous of degree one in u. Two tangential sliders share v.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.nonlinear.compiled import kernel
from vanelock.nonlinear.sampled import sampled_contact
from vanelock.nonlinear.slider import (
    BEGIN,
    END,
    FACTOR,
    FREE,
    HELD,
    HIGH,
    KIND,
    LOW,
    PLACE,
    SOURCE,
    WIDTH,
    slider_path,
)
from vanelock.nonlinear.trigonometric import (
    TURN,
    Floats,
    add_integrals,
    basis,
    basis_at,
    derivative,
    gram,
    grid,
    roots,
    value,
)
from vanelock.rom.system import Contacts

STUCK, SLIP, OPEN, SLIP_OPEN = 0, 1, 2, 3


@dataclass(frozen=True)
class Law:
    """Contact elements ready to be evaluated.

    Attributes
    ----------
    alpha : (c, 2) float
        μ kn/kt of each tangential direction.
    stiffness : (c, 3) float
        (kn, kt1, kt2), N/m.
    table : (s, 2H + 1) float
        φ on a uniform grid: brackets of the events, or the samples.
    located : bool
        Whether events are located and integrals exact, or both follow plain samples.
    """

    alpha: Floats
    stiffness: Floats
    table: Floats
    located: bool

    def __call__(self, u: Floats) -> "Deviation":
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        c, _, m = u.shape
        w = np.zeros((c, 3, m))
        jacobian = np.zeros((c, 3, m, 3, m))
        state = np.zeros(c, np.int64)
        energy = np.zeros(c)
        kernel = _located if self.located else _sampled
        kernel(
            np.ascontiguousarray(u), self.alpha, self.stiffness, self.table,
            w, jacobian, state, energy,
        )  # fmt: skip
        return Deviation(w, jacobian, state, energy)


@dataclass(frozen=True)
class Deviation:
    """How contacts deviate from the stuck state.

    Attributes
    ----------
    w : (c, 3, 2H + 1) float
        Coefficients of w, m.
    jacobian : (c, 3, 2H + 1, 3, 2H + 1) float
        dw/du of each contact.
    state : (c,) int
        STUCK, SLIP, OPEN or SLIP_OPEN.
    dissipation : (c,) float
        Friction work ∫ μ n |dw| of both directions in a period, J.
    """

    w: Floats
    jacobian: Floats
    state: NDArray[np.int64]
    dissipation: Floats


def contact_law(contacts: Contacts, harmonics: int, samples: int | None = None) -> Law:
    """The law of all contacts for displacements of `harmonics` harmonics.

    Parameters
    ----------
    contacts : Contacts
    harmonics : int
        H; 0 for a static state.
    samples : int, optional
        Sample the period at this many instants instead of locating events: the coefficients are
        then off by 1e-5 to 1e-2, most where contacts open.
    """
    if samples is None:
        table = grid(harmonics)
    else:
        table = basis(harmonics, TURN * np.arange(samples) / samples)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    return Law(alpha, contacts.stiffness, table, samples is None)


@kernel
def _scale(matrix: Floats) -> None:
    """Integrals over a period to Fourier coefficients: 1/2π of the first row, 1/π of the others."""
    for j in range(matrix.shape[0]):
        for k in range(matrix.shape[1]):
            matrix[j, k] /= TURN if j == 0 else 0.5 * TURN


@kernel
def _add_product(matrix: Floats, vector: Floats, out: Floats) -> None:
    """Out += matrix · vector."""
    for j in range(out.size):
        for k in range(vector.size):
            out[j] += matrix[j, k] * vector[k]


@kernel
def _place(block: Floats, contact: int, row: int, column: int, jacobian: Floats) -> None:
    """Put dw_row/du_column of one contact into the Jacobian of all."""
    for j in range(block.shape[0]):
        for k in range(block.shape[1]):
            jacobian[contact, row, j, column, k] = block[j, k]


@kernel
def _add_normal(v: Floats, contact: Floats, count: int, w: Floats, jacobian: Floats) -> int:
    """min(v, 0) and its derivative; returns 0 closed, 1 open for a part of the period, 2 open."""
    m = v.size
    if count == 0:
        if v[0] > 0.0:  # the mean has the sign; a single value may be a zero that v only touches
            return 0
        for k in range(m):
            w[k] = v[k]
            jacobian[k, k] = 1.0
        return 2
    moments = np.zeros(m, np.complex128)
    first = 0 if value(v, 0.0) >= 0.0 else 1
    for i in range(first, count, 2):
        last = contact[i + 1] if i + 1 < count else contact[0] + TURN
        add_integrals(contact[i], last, moments)
    gram(moments, jacobian)
    _scale(jacobian)
    _add_product(jacobian, v, w)
    return 1


@kernel
def _add_slider(
    v: Floats, u: Floats, alpha: float, path: Floats, w: Floats, along: Floats, across: Floats
) -> tuple[bool, float]:
    """Coefficients of a slider path, its derivatives to u and to v; whether it slips; ∫ αv |dw|."""
    m = u.size
    moments = np.zeros((3, m), np.complex128)  # of the angles on the lower and upper bound, and off
    held = np.empty((m + 1) // 2, np.complex128)
    integral, phi = np.empty(m), np.empty(m)
    slips, opens = False, False
    for i in range(path.shape[0]):
        kind, begin, end = int(path[i, KIND]), path[i, BEGIN], path[i, END]
        if kind == HELD:
            if np.isnan(path[i, SOURCE]):
                continue
            held[:] = 0.0
            add_integrals(begin, end, held)
            integral[0] = held[0].real
            for h in range(1, held.size):
                integral[2 * h - 1], integral[2 * h] = held[h].real, -held[h].imag
            basis_at(path[i, SOURCE], phi)
            for j in range(m):
                w[j] += path[i, PLACE] * integral[j]
                for k in range(m):
                    along[j, k] += integral[j] * phi[k]
                    across[j, k] += integral[j] * path[i, FACTOR] * phi[k]
        else:
            add_integrals(begin, end, moments[0 if kind == LOW else 1 if kind == HIGH else 2])
            slips = slips or kind != FREE
            opens = opens or kind == FREE
    work = 0.0
    share, moving = np.empty((m, m)), np.empty(m)
    for g in range(3):
        if (not slips and g < 2) or (not opens and g == 2):
            continue
        gram(moments[g], share)
        factor = -alpha if g == 0 else alpha if g == 1 else 0.0
        for k in range(m):
            moving[k] = u[k] + factor * v[k]
        rate = derivative(moving)
        for j in range(m):
            for k in range(m):
                w[j] += share[j, k] * moving[k]
                along[j, k] += share[j, k]
                across[j, k] += factor * share[j, k]
                work -= factor * v[j] * share[j, k] * rate[k]
    for j in range(m):
        w[j] /= TURN if j == 0 else 0.5 * TURN
    _scale(along)
    _scale(across)
    return slips, work


@kernel
def _state(opening: int, slips: bool) -> int:
    """State of a contact that is closed (0), open for a part of the period (1) or open (2)."""
    if opening == 0:
        return SLIP if slips else STUCK
    return SLIP_OPEN if opening == 1 else OPEN


@kernel
def _located(
    u: Floats,
    alpha: Floats,
    stiffness: Floats,
    table: Floats,
    w: Floats,
    jacobian: Floats,
    state: NDArray[np.int64],
    energy: Floats,
) -> None:
    """The law with located events, contact by contact."""
    m = u.shape[2]
    contact = np.empty(2 * m + 2)
    path = np.empty((6 * contact.size + 2, WIDTH))
    along, across = np.empty((m, m)), np.empty((m, m))
    for c in range(u.shape[0]):
        v = u[c, 0]
        count = roots(v, table, contact)
        along[:] = 0.0
        opening = _add_normal(v, contact, count, w[c, 0], along)
        if opening > 0:
            _place(along, c, 0, 0, jacobian)
        slips = False
        for d in range(1, 3):
            a = alpha[c, d - 1]
            size = slider_path(v, u[c, d], a, contact, count, table, path)
            if size == 1 and path[0, KIND] == HELD and np.isnan(path[0, SOURCE]):
                continue  # sticks where it was assembled
            along[:] = 0.0
            across[:] = 0.0
            slip, work = _add_slider(v, u[c, d], a, path[:size], w[c, d], along, across)
            _place(along, c, d, d, jacobian)
            _place(across, c, d, 0, jacobian)
            slips = slips or slip or (a == 0.0 and m > 1)
            energy[c] += stiffness[c, d] * work
        state[c] = _state(opening, slips)


@kernel
def _sampled(
    u: Floats,
    alpha: Floats,
    stiffness: Floats,
    table: Floats,
    w: Floats,
    jacobian: Floats,
    state: NDArray[np.int64],
    energy: Floats,
) -> None:
    """The law on plain samples, contact by contact."""
    for c in range(u.shape[0]):
        opening, slips, work = sampled_contact(
            u[c], alpha[c], stiffness[c], table, w[c], jacobian[c]
        )
        energy[c] = work
        state[c] = _state(opening, slips)
