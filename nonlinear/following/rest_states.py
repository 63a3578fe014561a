"""States at rest that undetermined static friction allows.

Contacts that stick may hold any friction within Coulomb's limit; which one, a model at rest does
not say. Where sliders were assembled at w, m, a structure at rest has the contact displacements

    u = ũ + R̂₀ w,      normal force n = kn (v - w_n),      friction t = kt (u_t - w_t),

with w_n = 0 in a closed contact and n = 0 in an open one. All states at rest are those with

    n >= 0,      w_n <= 0,      |t - (1 - s) r μ n| <= s μ n:

r is the share of Coulomb's limit that is used where all sliders were assembled at zero, s the share
by which it may be another; of each direction by itself, or of isotropic friction as a vector. As
long as no contact opens or closes they form a polytope, or a convex set with discs for sides, on
which the joint's load Σ n is linear: its ends are found by linear programming, discs by tangents
that are added where a programme's solution lies beyond (Kelley 1960). Contacts with n = w_n = 0
that hold an end back then open or close, and the programme goes on from there, never back: no state
with the same contacts open lies beyond an end, others may. The state at each is solved by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.forced_response.frequency_response import static_response
from vanelock.nonlinear.forced_response.linear_response import closed_contacts
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response
from vanelock.rom.system.system import System

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]
Joints: TypeAlias = str | Sequence[str] | Bools

BETTER = 1e-4
"""How much further, relatively, an end must lie to count as further."""
SOLVED, INFEASIBLE, UNBOUNDED = 0, 2, 3
NOTHING = 1e-9
"""Of a programme's objective, multipliers and friction, relative to the largest."""
WAYS = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
"""Directions that bound friction; where it is isotropic, tangents of its discs are added."""
FEASIBLE = 1e-10
"""By how much a programme's solution may violate a bound, in units of `RestStates.scale`."""
TANGENTS = 40
"""Most times that they are."""


@dataclass(frozen=True)
class RestStates:
    """States at rest by the places w of their sliders: a polytope while no contact opens or closes.

    Attributes
    ----------
    system : System
        Its sliders are zero.
    nominal : Response
        Its state at rest.
    closed : (c,) bool
        Contacts that are closed.
    share : (c,) float
        s of each contact.
    linear : (3c,) float
        ũ, m.
    receptance : (3c, 3c) float
        R̂₀.
    options : Options
        As of `static_response`.
    modes : dict of int to StuckModes
        Those that are known, of nodal diameter 0 among them.
    """

    system: System
    nominal: Response
    closed: Bools
    share: Floats
    linear: Floats
    receptance: Floats
    options: Options
    modes: Mapping[int, StuckModes]

    @cached_property
    def scale(self) -> float:
        """A displacement of the structure, m."""
        return float(np.abs(self.linear).max()) or 1.0

    @cached_property
    def stretch(self) -> tuple[Floats, Floats]:
        """(3c,) and (3c, 3c): u - w = a + A w of all springs, in units of `scale`."""
        return self.linear / self.scale, self.receptance - np.eye(len(self.linear))

    @property
    def _isotropic(self) -> bool:
        return self.options.friction == "isotropic"

    @cached_property
    def _used(self) -> Floats:
        """(c, 2) r, along the friction, of each contact."""
        force = self.nominal.force[0, 0].real
        friction, limit = force[:, 1:], (self.system.contacts.mu * force[:, 0])[:, None]
        used = np.divide(friction, limit, where=limit > 0, out=np.zeros_like(friction))
        size = np.hypot(*used.T)[:, None] if self._isotropic else np.abs(used)
        return np.asarray(used / np.maximum(size, 1.0))

    def _bounded(self, contact: Indices, way: Floats) -> tuple[Floats, Floats]:
        """A (k, 3c), b (k,) of A w <= b: friction of contacts (k,) within its bounds by (k, 2)."""
        start, by = (each.reshape(len(self.closed), 3, -1)[contact] for each in self.stretch)
        share, alpha = self.share[contact], self.system.contacts.alpha[contact]
        most = share + (1 - share) * (way * self._used[contact]).sum(axis=1)
        reach = (most * (way**2 * alpha).sum(axis=1))[:, None]
        matrix = (way[:, :, None] * by[:, 1:]).sum(axis=1) - reach * by[:, 0]
        bound = reach * start[:, 0] - (way[:, :, None] * start[:, 1:]).sum(axis=1)
        return np.asarray(matrix), np.asarray(bound[:, 0])

    def _beyond(self, w: Floats, assembled: float) -> tuple[Indices, Floats]:
        """Contacts (k,) whose friction lies outside its disc, and the ways (k, 2) in which."""
        start, by = self.stretch
        stretch = (assembled * start + by @ w).reshape(-1, 3)
        reach = self.system.contacts.alpha[:, 0] * stretch[:, 0]
        aside = stretch[:, 1:] - ((1 - self.share) * reach)[:, None] * self._used
        size = np.hypot(*aside.T)
        beyond = np.flatnonzero(size - self.share * reach > NOTHING * np.abs(stretch).max())
        return beyond, aside[beyond] / size[beyond, None]

    def least(self, objective: Floats) -> "OptimizeResult":
        """The w (3c,), in units of `scale`, at which a linear objective (3c,) is least, if any.

        Isotropic friction is bounded by tangents of its discs, more of them where they leave room.
        """
        count = len(self.closed)
        rows = self._bounded(np.tile(np.arange(count), len(WAYS)), np.repeat(WAYS, count, axis=0))
        found = self._programme(objective, *rows)
        for _ in range(TANGENTS if self._isotropic else 0):
            endless = found.status == UNBOUNDED
            reached = self._programme(objective, *rows, ray=True) if endless else found
            if reached.status != SOLVED:
                break
            contact, way = self._beyond(reached.x, 0.0 if endless else 1.0)
            if not len(contact):
                break
            tangents = self._bounded(contact, way)
            rows = np.vstack([rows[0], tangents[0]]), np.append(rows[1], tangents[1])
            found = self._programme(objective, *rows)
        return found

    def _programme(
        self, objective: Floats, matrix: Floats, bound: Floats, ray: bool = False
    ) -> "OptimizeResult":
        """The least w with friction A w <= b; or a way, |w| <= 1, on which it falls without end."""
        from scipy.optimize import linprog  # loaded by those alone who ask

        start, by = (each[::3] for each in self.stretch)
        held, closed = (0.0 if ray else 1.0), self.closed
        limits = np.full((len(self.linear), 2), 1.0 if ray else np.inf) * [-1, 1]
        limits[::3, 1] = 0.0
        limits[closed.nonzero()[0] * 3, 0] = 0.0
        programme = (
            objective / (np.abs(objective).max() or 1.0),
            np.vstack([-by[closed], matrix]),
            held * np.concatenate([start[closed], bound]),
            by[~closed],
            -held * start[~closed],
            limits,
        )
        found = linprog(*programme, options={"primal_feasibility_tolerance": FEASIBLE})
        if found.status not in (SOLVED, INFEASIBLE, UNBOUNDED):  # where the simplex method is lost
            found = linprog(*programme, method="highs-ipm")
        return found

    def slider(self, w: Floats) -> Floats:
        """(c, 2) places of the sliders, m, by w in units of `scale`; zero where open."""
        places = self.scale * w.reshape(-1, 3)[:, 1:]
        return np.where(self.closed[:, None], places, 0.0)

    @property
    def zero(self) -> Floats:
        """(c, 2) sliders at zero."""
        return np.zeros_like(self.system.contacts.kt)

    def least_load(self, mask: Bools, sign: float = 1.0) -> Floats | None:
        """(c, 2) sliders, m, at which the load of some contacts is least, or with -1 largest.

        None where it has no end.
        """
        start, by = self.stretch
        return self._normal(mask, sign, start, by, 0.0 if sign > 0 else -np.inf)

    def widest(self, mask: Bools) -> Floats | None:
        """(c, 2) sliders, m, at which some contacts are furthest from each other."""
        return self._normal(mask, 1.0, self.linear / self.scale, self.receptance, -np.inf)

    def _normal(
        self, mask: Bools, sign: float, start: Floats, by: Floats, floor: float
    ) -> Floats | None:
        """Sliders at which sign·Σ kn (start + by w) of some contacts is least."""
        weight = sign * np.where(mask, self.system.contacts.kn, 0.0)
        weight /= np.abs(weight).sum()
        return self.extreme(weight @ by[::3], floor - float(weight @ start[::3]))

    def extreme(
        self, objective: Floats, floor: float = -np.inf, closed: Bools | None = None
    ) -> Floats | None:
        """(c, 2) sliders, m, where a linear objective (3c,) of w is least; None if it has no end.

        Contacts may open and close, as long as the objective is above `floor`; those that are
        `closed` to begin with may be given, and count if such states exist.

        Raises
        ------
        InputError
            If the programme has no solution.
        """
        if not self.share.any() or not self.system.contacts.mu.any():
            return self.zero
        states = self if closed is None else replace(self, closed=closed)
        found, nothing = states.least(objective), NOTHING * np.abs(objective).max()
        if found.status == INFEASIBLE and closed is not None:
            states, found = self, self.least(objective)
        if found.status == UNBOUNDED:
            return None
        if found.status != SOLVED:
            raise InputError(f"bounds: the linear programme was not solved: {found.message}")
        while objective @ found.x > floor + nothing:
            pressing = np.zeros(len(self.closed))
            pressing[states.closed] = -found.ineqlin.marginals[: states.closed.sum()]
            pressing[~states.closed] = -found.upper.marginals[::3][~states.closed]
            other = replace(states, closed=states.closed ^ (pressing > NOTHING))
            reached = other.least(objective)
            if reached.status == UNBOUNDED:
                return None
            if reached.status != SOLVED:
                break
            gain = objective @ found.x - objective @ reached.x
            if not gain > BETTER * abs(objective @ found.x):
                break
            states, found = other, reached
        return states.slider(found.x)

    def closed_at(self, slider: Floats) -> Bools:
        """(c,) contacts that are closed at rest with sliders assembled at (c, 2), m."""
        return _closed(self.solved(slider))

    def solved(self, slider: Floats) -> Response:
        """The state at rest with sliders assembled at (c, 2), m."""
        contacts = replace(self.system.contacts, slider=slider)
        return static_response(replace(self.system, contacts=contacts), self.options, self.modes)


def rest_states(
    system: System,
    joints: Joints,
    share: float,
    options: Options,
    modes: Mapping[int, StuckModes] | None,
) -> RestStates:
    """States at rest of a system whose static friction is undetermined; see `static_bounds`."""
    if not 0 <= share <= 1:
        raise InputError(f"share: given {share}: needs 0 to 1")
    system.contacts.refuse_elements("a bound over static friction")
    contacts = replace(system.contacts, slider=np.zeros_like(system.contacts.kt))
    system = replace(system, contacts=contacts)
    prepared = structure(system, 0, known=modes)
    modes = {**(modes or {}), **prepared.modes}
    nominal, balance = static_response(system, options, modes), prepared.balance(0.0)
    return RestStates(
        system=system,
        nominal=nominal,
        closed=_closed(nominal),
        share=np.where(closed_contacts(contacts, joints), float(share), 0.0),
        linear=balance.linear[:, :, 0].reshape(-1),
        receptance=balance.columns.all(0).real,
        options=options,
        modes=modes,
    )


def _closed(state: Response) -> Bools:
    """(c,) contacts that are closed."""
    return np.asarray(state.contact[0, 0, :, 0].real > 0)
