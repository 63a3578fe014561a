"""The contact law over one period of given relative displacements, and its exact derivative.

With all contacts stuck and closed their force would be λ = K_c u. What a contact does instead is

    λ = K_c (u - w),      w_n = min(v, 0),      w_t = place of the friction slider,

so w, a displacement, is all that is nonlinear: it vanishes for a contact that sticks and never
slid, and it is homogeneous of degree one in u. Orthogonal friction has two sliders, one in each
tangential direction, that share v; isotropic friction has one in the tangential plane. On paths of
two dimensions, independent directions dissipate less while slip is small, each waiting for its own
share of the path to reach μ n/kt, and up to 4/π (circle) or √2 (oblique line) times as much when it
is large, where together they pull with more than μ n
(tests/verification/nonlinear/laws/test_plane_friction.py).

Under constant load the normal spring neither loses contact nor moves the bound of friction: a
contact that is closed at rest has w_n = 0 and slides at μ kn v^(0); one that is open at rest stays
open, w = u.

An element with a law of its own, f(u, u̇), is brought into the same form by a linear spring in its
place, w = u - f/k. So is a contact whose springs are (1 + κ) K_c, those of the structure that it is
solved in K_c: w = W(u) - κ (u - W(u)).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.contact.element_force import periodic_force
from vanelock.nonlinear.contact.isotropic_law import isotropic_located_law
from vanelock.nonlinear.contact.normal import ALWAYS, CLOSED
from vanelock.nonlinear.contact.orthogonal_law import located_law, sampled_law
from vanelock.nonlinear.contact.sampling import FRICTIONS
from vanelock.nonlinear.fourier import grid, to_complex
from vanelock.rom.system.element import Element
from vanelock.rom.system.system import Contacts

STUCK, SLIP, OPEN, SLIP_OPEN, ELEMENT = 0, 1, 2, 3, 4
_ROUNDING = 1e-12
_COUNTS = 1e-3
"""Of the force of an element's spring in its place: what its own is resolved to at least."""


@dataclass(frozen=True)
class Law:
    """Contact elements ready to be evaluated.

    `alpha` (c, 2): μ kn/kt of each tangential direction; `stiffness` (c, 3): (kn, kt1, kt2), N/m;
    `table` (s, 2H + 1): φ on a uniform grid: brackets of the events, or the samples; `located`:
    whether events are located and integrals exact, or both follow samples; `isotropic`: whether
    friction is bounded in the tangential plane, or in each direction by itself; `constant_load`:
    whether friction is bounded by the mean normal force, the normal spring linear; `elements`:
    those that follow laws of their own, by number; `stiffer` (c, 3): κ of each spring, where
    `stiffness` is not that of the structure; `bonded` (c,): those that neither open nor slip:
    springs κ K_c.
    """

    alpha: Floats
    stiffness: Floats
    table: Floats
    located: bool
    isotropic: bool = False
    constant_load: bool = False
    elements: Mapping[int, Element] = field(default_factory=dict)
    stiffer: Floats | None = None
    bonded: Booleans | None = None

    def __call__(self, u: Floats, omega: float = 0.0) -> "Deviation":
        """Evaluate at the relative displacements (c, 3, 2H + 1), m, of (v, u1, u2).

        The circular frequency, rad/s, is what elements take velocities from.
        """
        m = u.shape[2]
        seen = np.ascontiguousarray(u)
        if self.constant_load:
            seen = seen.copy()
            seen[:, 0, 1:] = 0.0
        if self.elements:  # what the kernels see of them is at rest
            seen = np.where(self._is_element[:, None, None], 0.0, seen)
        if self.bonded is not None:  # of them, that they are pressed together
            seen = np.where(self.bonded[:, None, None], 0.0, seen)
            seen[self.bonded, 0, 0] = 1.0
        one_by_one = located_law if self.located else sampled_law
        law = isotropic_located_law if self.isotropic else one_by_one
        made = law(seen, self.alpha, self.stiffness, self.table)
        w, jacobian, opening, slips, energy = made
        if self.constant_load:
            jacobian[:, :, :, 0, 1:] = 0.0  # the mean alone bounds friction
            free = opening == ALWAYS
            w[free, 0] = u[free, 0]
            jacobian[free, 0, :, 0] = np.eye(m)
        closed = np.where(slips, SLIP, STUCK)
        state = np.where(opening == CLOSED, closed, np.where(opening == ALWAYS, OPEN, SLIP_OPEN))
        if self.stiffer is not None:
            w -= self.stiffer[:, :, None] * (u - w)
            jacobian *= 1 + self.stiffer[:, :, None, None, None]
            for i in range(3):
                for k in range(m):
                    jacobian[:, i, k, i, k] -= self.stiffer[:, i]
        deviation = Deviation(w, jacobian, state, energy)
        return self._with_elements(deviation, u, omega) if self.elements else deviation

    @property
    def _is_element(self) -> Booleans:
        """(c,) which are elements."""
        found = np.zeros(len(self.alpha), bool)
        found[list(self.elements)] = True
        return found

    def _with_elements(self, deviation: "Deviation", u: Floats, omega: float) -> "Deviation":
        """The deviation of contacts and elements."""
        w, jacobian, by_omega = deviation.w, deviation.jacobian, np.zeros_like(u)
        samples = None if self.located else len(self.table)
        for i, element in self.elements.items():
            d = len(element.places)
            k = self.stiffness[i, :d]
            counts = _COUNTS * float((k * np.abs(u[i, :d]).max(axis=1)).max())
            force, by_u, by_rate = periodic_force(element, u[i, :d], omega, samples, counts)
            w[i], jacobian[i] = 0.0, 0.0
            w[i, :d] = u[i, :d] - force / k[:, None]
            jacobian[i, :d, :, :d] = -by_u / k[:, None, None, None]
            for j in range(d):
                jacobian[i, j, :, j] += np.eye(u.shape[2])
            by_omega[i, :d] = -by_rate / k[:, None]
            deviation.dissipation[i] = _work(to_complex(u[i, :d]), to_complex(force))
        state = np.where(self._is_element, ELEMENT, deviation.state)
        return replace(deviation, state=state, by_omega=by_omega)


def _work(q: Complex, f: Complex) -> float:
    """Work of forces (H + 1, d) on displacements in a period, J; none where rounding leaves it."""
    each = np.arange(len(q))[:, None] * f * q.conj()
    work = float(each.imag.sum())
    return np.pi * work if abs(work) > _ROUNDING * np.abs(each).sum() else 0.0


@dataclass(frozen=True)
class Deviation:
    """How contacts deviate from the stuck state.

    `w` (c, 3, 2H + 1): coefficients of w, m; `jacobian` (c, 3, 2H + 1, 3, 2H + 1): dw/du of each
    contact; `state` (c,): STUCK, SLIP, OPEN or SLIP_OPEN; ELEMENT for what follows a law of its
    own; `dissipation` (c,): friction work ∫ μ n |dw| in a period, of both directions or of the path
    in the plane, J; of an element, its work; `by_omega` (c, 3, 2H + 1): dw/dω, u held, where
    elements know velocities, m s.
    """

    w: Floats
    jacobian: Floats
    state: Integers
    dissipation: Floats
    by_omega: Floats | None = None


def contact_law(
    contacts: Contacts,
    harmonics: int,
    samples: int | None = None,
    friction: str = "orthogonal",
    constant_load: bool = False,
) -> Law:
    """The law of all contacts for displacements of `harmonics` harmonics."""
    check_friction(contacts, friction)
    isotropic, located = friction == "isotropic", samples is None
    alpha, stiffness, elements = contacts.alpha, contacts.stiffness, contacts.elements
    table = grid(harmonics, samples)
    return Law(alpha, stiffness, table, located, isotropic, constant_load, elements)


def check_friction(contacts: Contacts, friction: str) -> None:
    """Refuse unknown friction, and isotropic friction where two tangential springs differ."""
    if friction not in FRICTIONS:
        raise InputError(f"friction: given {friction!r}: allowed: {', '.join(FRICTIONS)}")
    if friction != "isotropic":
        return
    uneven = np.abs(contacts.kt[:, 0] - contacts.kt[:, 1]) > 1e-9 * contacts.kt.max(axis=1)
    uneven &= contacts.springs
    if np.any(uneven):
        i = int(np.argmax(uneven))
        shown = ", ".join(f"{k:g}" for k in contacts.kt[i])
        raise InputError(
            f"friction: given 'isotropic': contact {i} has kt ({shown}) N/m: "
            "needs the same stiffness in both tangential directions"
        )
