"""States at rest that undetermined static friction allows.

Contacts that stick may hold any friction within Coulomb's limit; which one, a model at rest does
not say. Where sliders were assembled at w, m, a structure at rest has the contact displacements

    u = ũ + R̂₀ w,      normal force n = kn (v - w_n),      friction t = kt (u_t - w_t),

with w_n = 0 in a closed contact and n = 0 in an open one. All states at rest are those with

    n >= 0,      w_n <= 0,      |t - (1 - s) r μ n| <= s μ n:

r is the share of Coulomb's limit that is used where all sliders were assembled at zero, s the share
by which it may be another; of each direction by itself, or of isotropic friction as a vector. As
long as no contact opens or closes they form a polytope, or a convex set with discs for sides, on
which the joint's load Σ n is linear: its ends are found by cone programming (an interior-point
method: Goulart and Chen, "Clarabel", 2024). Contacts with n = w_n = 0 that hold an end back then
open or close, and the programme goes on from there, never back: no state with the same contacts
open lies beyond an end, others may. Of few contacts these are searched by branch and bound: where
it is left open which a contact is, n >= 0 and w_n <= 0 may both be slack, and the programme is a
bound. The state at each end is solved by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from vanelock.common.arrays import Booleans, Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.forced_response.frequency_response import static_response
from vanelock.nonlinear.forced_response.linear_response import closed_contacts
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.response import Response
from vanelock.rom.system.system import System

Joints: TypeAlias = str | Sequence[str] | Booleans

_BETTER = 1e-4  # how much further, relatively, an end must lie to count as further
_NOTHING = 1e-9
"""Of a programme's objective and multipliers, relative to the largest; of what sliders change."""
_EXACT, _NEARLY = 1e-10, 1e-7
"""To which programmes are solved, and to which they may be where rounding allows no more."""
_FEW, _PROGRAMMES = 24, 300
"""Contacts up to which open and closed ones are branched on, by so many programmes at most."""


@dataclass(frozen=True)
class _Least:
    """Where a linear objective of w is least, (3c,) in units of `RestStates.scale`.

    `status` is the programme's, by Clarabel's names; `pressing` (c,) are contacts that hold it
    back: closed ones with n = 0, open ones with w_n = 0.
    """

    point: Floats
    status: str
    pressing: Booleans

    @property
    def solved(self) -> bool:
        """Whether there is such a place."""
        return self.status in ("Solved", "AlmostSolved")

    @property
    def endless(self) -> bool:
        """Whether the objective falls without end."""
        return self.status in ("DualInfeasible", "AlmostDualInfeasible")

    @property
    def impossible(self) -> bool:
        """Whether there is no state at all."""
        return self.status in ("PrimalInfeasible", "AlmostPrimalInfeasible")


@dataclass(frozen=True)
class RestStates:
    """States at rest by the places w of their sliders: a polytope while no contact opens or closes.

    `system` has its sliders at zero, `nominal` is its state at rest, `closed` (c,) are
    contacts that are closed, `share` (c,) their s; `linear` (3c,), m, is ũ and `receptance`
    (3c, 3c) R̂₀. Of `modes` nodal diameter 0 is there. Of contacts in `either` (c,), taken for
    closed, it is left open whether they are.
    """

    system: System
    nominal: Response
    closed: Booleans
    share: Floats
    linear: Floats
    receptance: Floats
    options: Options
    modes: Mapping[int, StuckModes]
    either: Booleans

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

    @cached_property
    def _cones(self) -> tuple[Floats, tuple[int, int, int]]:
        """Rows [b | A] of which b + A w is zero, >= 0, or in a cone of three; how many of each.

        Those that are >= 0 begin with one of each contact: its n, or where it is open its -w_n.
        """
        contacts, closed, count = self.system.contacts, self.closed[:, None], len(self.closed)
        place = np.eye(3 * count, 3 * count + 1, 1).reshape(count, 3, -1)
        stretch = np.column_stack(self.stretch).reshape(place.shape)
        limit = contacts.alpha[:, :, None] * stretch[:, :1]
        aside = stretch[:, 1:] - ((1 - self.share)[:, None] * self._used)[:, :, None] * limit
        room = self.share[:, None, None] * limit
        free = self.closed & (self.share > 0) & (contacts.mu > 0)
        zero = [stretch[~self.closed, 0], *aside[~free]]
        positive = [np.where(closed, stretch[:, 0], -place[:, 0]), -place[self.either, 0]]
        discs = np.concatenate([room[:, :1], aside], axis=1)[free]
        if not self._isotropic:
            positive += [*(room + aside)[free], *(room - aside)[free]]
            discs = discs[:0]
        rows = [np.vstack(each) for each in (zero, positive, [*discs, place[:0, 0]])]
        return np.vstack(rows), (len(rows[0]), len(rows[1]), len(discs))

    def least(self, objective: Floats) -> _Least:
        """Where a linear objective (3c,) of w is least, by an interior-point method."""
        import clarabel  # loaded by those alone who ask
        from scipy.sparse import csc_array

        rows, (zeros, positive, discs) = self._cones
        count = len(self.closed)
        settings = clarabel.DefaultSettings()
        settings.verbose = settings.equilibrate_enable = False  # the rows are displacements alike
        settings.direct_solve_method = "qdldl"
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = _EXACT
        settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = _NEARLY
        settings.reduced_tol_feas = _NEARLY
        normal = ~self.closed | self.either
        varied = np.hstack([normal[:, None], np.ones((count, 2), dtype=bool)]).ravel()
        weight = objective[varied] / (np.abs(objective).max() or 1.0)
        found = clarabel.DefaultSolver(
            csc_array((len(weight), len(weight))),
            weight,
            csc_array(-rows[:, 1:][:, varied]),
            rows[:, 0],
            [
                clarabel.ZeroConeT(zeros),
                clarabel.NonnegativeConeT(positive),
                *(clarabel.SecondOrderConeT(3) for _ in range(discs)),
            ],
            settings,
        ).solve()
        place = np.zeros(3 * count)
        place[varied] = found.x
        multiplier, slack = (np.array(each)[zeros:][:count] for each in (found.z, found.s))
        return _Least(place, str(found.status), multiplier > np.maximum(slack, _NOTHING))

    def slider(self, w: Floats) -> Floats:
        """(c, 2) places of the sliders, m, by w in units of `scale`; zero where open."""
        places = self.scale * w.reshape(-1, 3)[:, 1:]
        return np.where(self.closed[:, None], places, 0.0)

    @property
    def zero(self) -> Floats:
        """(c, 2) sliders at zero."""
        return np.zeros_like(self.system.contacts.kt)

    def most_load(self, mask: Booleans) -> Floats | None:
        """(c, 2) sliders, m, at which the load of some contacts is largest; None: has no end."""
        return self.extreme(*self._normal(mask, -1.0, *self.stretch, -np.inf))

    def proved_load(self, mask: Booleans, sign: float) -> tuple[Floats | None, bool]:
        """Sliders at which the load of some contacts is least, or with -1 largest; if proved.

        None where it has no end; proved where no state has another, whichever contacts are open.
        """
        objective, floor = self._normal(mask, sign, *self.stretch, 0.0 if sign > 0 else -np.inf)
        if self._fixed(objective):
            return self.zero, True
        if (last := self._last(objective, floor)) is None:
            return None, True
        (states, best), every = last, np.ones_like(self.closed)
        left, proved = [replace(self, closed=every, either=every)], len(every) <= _FEW
        for _ in range(_PROGRAMMES if proved else 0):
            reached = objective @ best.point
            if not left or reached <= floor + _NOTHING * np.abs(objective).max():
                return states.slider(best.point), proved
            node = left.pop()
            found, either = node.least(objective), node.either.copy()
            if found.solved:
                if not reached - objective @ found.point > _BETTER * abs(reached):
                    continue
                start, by = self.stretch
                n, off = (start + by @ found.point)[::3], -found.point[::3]
                slack = np.where(either, np.minimum(n, off), 0.0)
                branch = int(slack.argmax())
                if slack[branch] <= _NEARLY:
                    closed = np.where(either, n >= off, node.closed)
                    other = replace(self, closed=closed)
                    exact = other.least(objective)
                    proved = proved and exact.solved
                    states, best = (other, exact) if exact.solved else (states, best)
                    continue
            elif found.endless:
                if not either.any():
                    return None, True
                branch = int(either.argmax())
            else:
                proved = proved and found.impossible
                continue
            either[branch] = False
            open_there = node.closed & (np.arange(len(either)) != branch)
            left += [
                replace(node, closed=each, either=either) for each in (open_there, node.closed)
            ]
        return states.slider(best.point), False

    def widest(self, mask: Booleans) -> Floats | None:
        """(c, 2) sliders, m, at which some contacts are furthest from each other."""
        start = self.linear / self.scale
        return self.extreme(*self._normal(mask, 1.0, start, self.receptance, -np.inf))

    def _normal(
        self, mask: Booleans, sign: float, start: Floats, by: Floats, floor: float
    ) -> tuple[Floats, float]:
        """Objective and floor of sign·Σ kn (start + by w) of some contacts."""
        weight = sign * np.where(mask, self.system.contacts.kn, 0.0)
        weight /= np.abs(weight).sum()
        return weight @ by[::3], floor - float(weight @ start[::3])

    def _fixed(self, objective: Floats) -> bool:
        """Whether no slider changes it: as of a joint that alone carries what presses it."""
        moves = self.share.any() and self.system.contacts.mu.any()
        return not moves or bool(np.abs(objective).max() < _NOTHING)

    def extreme(
        self, objective: Floats, floor: float = -np.inf, closed: Booleans | None = None
    ) -> Floats | None:
        """(c, 2) sliders, m, where a linear objective (3c,) of w is least; None if it has no end.

        Contacts may open and close, as long as the objective is above `floor`; those that are
        `closed` to begin with may be given, and count if such states exist.
        """
        if self._fixed(objective):
            return self.zero
        last = self._last(objective, floor, closed)
        return None if last is None else last[0].slider(last[1].point)

    def _last(
        self, objective: Floats, floor: float, closed: Booleans | None = None
    ) -> tuple["RestStates", _Least] | None:
        """The states of contacts that open and close, and where in them `extreme` ends."""
        states = self if closed is None else replace(self, closed=closed)
        found, nothing = states.least(objective), _NOTHING * np.abs(objective).max()
        if found.impossible and closed is not None:
            states, found = self, self.least(objective)
        if found.endless:
            return None
        if not found.solved:
            raise InputError(f"bounds: the cone programme was not solved: {found.status}")
        while objective @ found.point > floor + nothing:
            other = replace(states, closed=states.closed ^ found.pressing)
            reached = other.least(objective)
            if reached.endless:
                return None
            if not reached.solved:
                break
            gain = objective @ found.point - objective @ reached.point
            if not gain > _BETTER * abs(objective @ found.point):
                break
            states, found = other, reached
        return states, found

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
    prepared = structure(system, 0, stuck=modes)
    modes = {**(modes or {}), **prepared.modes}
    nominal, balance = static_response(system, options, modes), prepared.balance(0.0)
    return RestStates(
        system=system,
        nominal=nominal,
        closed=nominal.contact[0, 0, :, 0].real > 0,
        share=np.where(closed_contacts(contacts, joints), float(share), 0.0),
        linear=balance.linear[:, :, 0].reshape(-1),
        receptance=balance.columns.all(0).real,
        options=options,
        modes=modes,
        either=np.zeros(contacts.count, bool),
    )
