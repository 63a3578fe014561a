"""States at rest that undetermined static friction allows.

Contacts that stick may hold any friction within Coulomb's limit; which one, a model at rest does
not say. Where sliders were assembled at w, m, a structure at rest has the contact displacements

    u = ũ + R̂₀ w,      normal force n = kn (v - w_n),      friction t = kt (u_t - w_t),

with w_n = 0 in a closed contact and n = 0 in an open one. All states at rest are those with

    n >= 0,      w_n <= 0,      |t - (1 - s) r μ n| <= s μ n:

r is the share of Coulomb's limit that is used where all sliders were assembled at zero, s the share
by which it may be another. As long as no contact opens or closes they form a polytope, on which the
joint's load Σ n is linear: its ends are found by linear programming. Contacts with n = w_n = 0 that
hold an end back then open or close, and the programme goes on from there, never back: no state with
the same contacts open lies beyond an end, others may. The state at each is solved by itself.
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
Joints: TypeAlias = str | Sequence[str] | Bools

BETTER = 1e-4
"""How much further, relatively, an end must lie to count as further."""
SOLVED, INFEASIBLE, UNBOUNDED = 0, 2, 3
NOTHING = 1e-9
"""Of a programme's objective and multipliers, relative to its largest coefficient."""


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

    @cached_property
    def _friction(self) -> tuple[Floats, Floats]:
        """A (4c, 3c), b (4c,) of A w <= b: friction within its bounds."""
        contacts, force = self.system.contacts, self.nominal.force[0, 0].real
        start, by = (each.reshape(contacts.count, 3, -1) for each in self.stretch)
        limit = contacts.mu * force[:, 0]
        matrices, bounds = [], []
        for way in (0, 1):
            pull = force[:, 1 + way]
            used = np.divide(pull, limit, where=limit > 0, out=np.zeros_like(pull)).clip(-1, 1)
            for side in (1.0, -1.0):
                most = self.share + side * (1 - self.share) * used
                reach = (most * contacts.alpha[:, way])[:, None]
                matrices.append(side * by[:, 1 + way] - reach * by[:, 0])
                bounds.append(reach * start[:, 0] - side * start[:, 1 + way])
        return np.vstack(matrices), np.concatenate(bounds)[:, 0]

    def least(self, objective: Floats) -> "OptimizeResult":
        """The w (3c,), in units of `scale`, at which a linear objective (3c,) is least, if any."""
        from scipy.optimize import linprog  # loaded by those alone who ask

        start, by = (each[::3] for each in self.stretch)
        matrix, bound = self._friction
        closed = self.closed
        limits = np.full((len(self.linear), 2), np.inf) * [-1, 1]
        limits[::3, 1] = 0.0
        limits[::3, 0] = np.where(closed, 0.0, -np.inf)
        programme = (
            objective / (np.abs(objective).max() or 1.0),
            np.vstack([-by[closed], matrix]),
            np.concatenate([start[closed], bound]),
            by[~closed],
            -start[~closed],
            limits,
        )
        found = linprog(*programme)
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
    if options.friction != "orthogonal":
        raise InputError("friction: given 'isotropic': bounds are of orthogonal friction")
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
