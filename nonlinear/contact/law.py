"""The contact law over one period of given relative displacements, and its exact derivative.

With all contacts stuck and closed their force would be λ = K_c u. What a contact does instead is

    λ = K_c (u - w),      w_n = min(v, 0),      w_t = place of the friction slider,

so w, a displacement, is all that is nonlinear: it vanishes for a contact that sticks and never
slid, and it is homogeneous of degree one in u. Orthogonal friction has two sliders, one in each
tangential direction, that share v; isotropic friction has one in the tangential plane. On paths of
two dimensions, independent directions dissipate less while slip is small, each waiting for its own
share of the path to reach μ n/kt, and up to 4/π (circle) or √2 (oblique line) times as much when it
is large, where together they pull with more than μ n
(tests/verification/nonlinear/test_plane_friction.py).

Under constant load the normal spring neither loses contact nor moves the bound of friction: a
contact that is closed at rest has w_n = 0 and slides at μ kn v^(0); one that is open at rest stays
open, w = u.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.isotropic.located_law import isotropic_located_law
from vanelock.nonlinear.contact.isotropic.sampled_law import isotropic_sampled_law
from vanelock.nonlinear.contact.normal import ALWAYS, CLOSED
from vanelock.nonlinear.contact.orthogonal.located_law import located_law
from vanelock.nonlinear.contact.orthogonal.sampled_law import sampled_law
from vanelock.nonlinear.contact.sampling import FRICTIONS
from vanelock.nonlinear.fourier.trigonometric import TURN, Floats, basis, grid
from vanelock.rom.system.system import Contacts

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
        Whether events are located and integrals exact, or both follow samples.
    isotropic : bool
        Whether friction is bounded in the tangential plane, or in each direction by itself.
    constant_load : bool
        Whether friction is bounded by the mean normal force, the normal spring linear.
    """

    alpha: Floats
    stiffness: Floats
    table: Floats
    located: bool
    isotropic: bool = False
    constant_load: bool = False

    def __call__(self, u: Floats) -> "Deviation":
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2)."""
        c, _, m = u.shape
        w = np.zeros((c, 3, m))
        jacobian = np.zeros((c, 3, m, 3, m))
        opening, slips, energy = np.zeros(c, np.int64), np.zeros(c, np.bool_), np.zeros(c)
        seen = np.ascontiguousarray(u)
        if self.constant_load:
            seen = seen.copy()
            seen[:, 0, 1:] = 0.0
        kernel = located_law if self.located else sampled_law
        if self.isotropic:
            kernel = isotropic_located_law if self.located else isotropic_sampled_law
        kernel(seen, self.alpha, self.stiffness, self.table, w, jacobian, opening, slips, energy)
        if self.constant_load:
            jacobian[:, :, :, 0, 1:] = 0.0  # the mean alone bounds friction
            free = opening == ALWAYS
            w[free, 0] = u[free, 0]
            jacobian[free, 0, :, 0] = np.eye(m)
        closed = np.where(slips, SLIP, STUCK)
        state = np.where(opening == CLOSED, closed, np.where(opening == ALWAYS, OPEN, SLIP_OPEN))
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
        Friction work ∫ μ n |dw| in a period, of both directions or of the path in the plane, J.
    """

    w: Floats
    jacobian: Floats
    state: NDArray[np.int64]
    dissipation: Floats


def contact_law(
    contacts: Contacts,
    harmonics: int,
    samples: int | None = None,
    friction: str = "orthogonal",
    constant_load: bool = False,
) -> Law:
    """The law of all contacts for displacements of `harmonics` harmonics.

    Parameters
    ----------
    contacts : Contacts
    harmonics : int
        H; 0 for a static state.
    samples : int, optional
        Sample the period at this many instants instead of locating events: the coefficients are
        then off by 1e-5 to 1e-2, most where contacts open.
    friction : {"orthogonal", "isotropic"}
        |t1| <= μ n and |t2| <= μ n, each by itself; or |t| <= μ n in the tangential plane.
    constant_load : bool
        Friction bounded by the mean normal force for good, the normal spring linear.

    Raises
    ------
    InputError
        If friction is unknown, or isotropic where a contact is stiffer in one direction.
    """
    if friction not in FRICTIONS:
        raise InputError(f"friction: given {friction!r}: allowed: {', '.join(FRICTIONS)}")
    isotropic = friction == "isotropic"
    if isotropic:
        _check_isotropic(contacts)
    if samples is None:
        table = grid(harmonics)
    else:
        table = basis(harmonics, TURN * np.arange(samples) / samples)
    return Law(contacts.alpha, contacts.stiffness, table, samples is None, isotropic, constant_load)


def _check_isotropic(contacts: Contacts) -> None:
    """Refuse contacts whose two tangential springs differ."""
    uneven = np.abs(contacts.kt[:, 0] - contacts.kt[:, 1]) > 1e-9 * contacts.kt.max(axis=1)
    if np.any(uneven):
        i = int(np.argmax(uneven))
        shown = ", ".join(f"{k:g}" for k in contacts.kt[i])
        raise InputError(
            f"friction: given 'isotropic': contact {i} has kt ({shown}) N/m: "
            "needs the same stiffness in both tangential directions"
        )
