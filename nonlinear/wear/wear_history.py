"""Wear over cycles: the interference that contacts lose, and how the vibration changes with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans, Floats, Integers, as_array
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.forced_response.options import Options
from vanelock.nonlinear.forced_response.parameter_response import Parameter, joined
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import one_thread
from vanelock.nonlinear.peaks.peak_tracking import named_component
from vanelock.nonlinear.wear.step import (
    Dwell,
    Law,
    Rest,
    Vibration,
    Vibrations,
    WearStep,
    archard,
    preload,
    stepped,
    vibrations,
)
from vanelock.rom.system.system import System

_Progress: TypeAlias = Callable[[float, float, float, float], None]

_STEP = 0.05  # largest relative change of an interference in a step, by default
_COARSEST = 0.5
DONE, PRELOAD, _LOST = "cycles done", "preload lost", "solution lost"
_ROUND_OFF = 1e-9  # of a dwell's cycles: what is not worth a step
_HIGHER = 1e-3  # of the amplitude of the peak that is followed, by which another is higher


@dataclass(frozen=True)
class WearHistory(Product):
    """Vibration and interference at s numbers of cycles.

    Attributes
    ----------
    output : str
        Name of the output node whose amplitude it is.
    direction : int
        Its direction, 0, 1 or 2.
    joints : tuple of str
        The j joints, in the order of `rest_load`.
    cycles : (s,) float
        Periods of the excitation so far. Where one dwell follows another that is unlike, the last
        state of the one and the first of the other have the same.
    dwell : (s,) int
        Which dwell each state is of, counted from 0.
    frequency : (s,) float
        Of the excitation, Hz.
    amplitude : (s,) float
        Half the peak-to-peak of the output, m.
    jump : (s,) bool
        Whether the vibration changed at once on the way from the state before: the peak was lost
        and the highest one of the range goes on, which may be the same, or rates changed by more
        than a quarter within the shortest step.
    rest_load : (s, j) float
        Sum of the normal forces of each joint's contacts in a sector at rest, N.
    interference : (s, c) float
        v0 of each contact, m.
    rate : (s, c) float
        Depth that each contact loses in a cycle, of both surfaces together, m.
    status : str
        Why it ends: "cycles done"; "preload lost", a joint that was closed at rest is open there;
        "solution lost", no vibration was found beyond the last state.
    cycles_to_loss : float
        Cycles after which the first joint is open at rest; nan where none was met.
    solved : int
        Vibrations that were looked for.
    force : (s,) float
        Factor of the excitation.
    response : Response
        The whole vibration of each state; `system_at` gives the systems that they are of.
    higher_amplitude, higher_frequency : (s,) float
        At the last state of a dwell at a peak: the highest peak of its range where that is not the
        one that was followed, m and Hz; nan elsewhere.
    """

    output: str
    direction: int
    joints: tuple[str, ...]
    cycles: Floats
    dwell: Integers
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    jump: Booleans
    rest_load: Floats = field(metadata={"unit": "N"})
    interference: Floats = field(metadata={"unit": "m"})
    rate: Floats = field(metadata={"unit": "m"})
    status: str
    cycles_to_loss: float
    solved: int
    force: Floats
    response: Response
    higher_amplitude: Floats = field(metadata={"unit": "m"})
    higher_frequency: Floats = field(metadata={"unit": "Hz"})

    @property
    def worn(self) -> Floats:
        """(s, c) depth that each contact has lost, of both surfaces together, m."""
        return np.asarray(self.interference[0] - self.interference)

    @property
    def seconds(self) -> Floats:
        """(s,) how long the cycles so far take, s."""
        period = 1 / self.frequency
        return np.append(0.0, np.cumsum(np.diff(self.cycles) * (period[1:] + period[:-1]) / 2))

    def system_at(self, system: System, state: int) -> System:
        """The system as worn, under the excitation of that state's dwell."""
        worn = replace(system.contacts, v0=self.interference[state])
        none = np.zeros(worn.count, bool)
        loaded = Parameter("force", none, True).system(system, float(self.force[state]))
        return replace(loaded, contacts=worn)


@one_thread
def wear_history(
    system: System,
    dwells: Dwell | Sequence[Dwell],
    coefficient: ArrayLike,
    area: ArrayLike,
    options: Options = Options(),
    output: tuple[str, int] | None = None,
    step: float = _STEP,
    progress: _Progress | None = None,
) -> WearHistory:
    """Interference, vibration and preload over cycles in which contacts wear by Archard's law.

    The vibration of every cycle is taken as settled. Its peak is followed as the interference
    changes. Another that becomes higher meanwhile is found at the end of the dwell, or where the
    one that is followed is lost.

    Parameters
    ----------
    system : System
        As assembled; its friction sliders stay where they were assembled.
    dwells : Dwell or sequence of Dwell
        What happens, one after another.
    coefficient : float or (c,) array_like
        Archard's wear coefficient, of both surfaces together, m²/N; 0 for a contact that does not
        wear. Elements do not, whatever it is.
    area : float or (c,) array_like
        Of each contact, m².
    options : Options
        With one harmonic at least. Orthogonal friction wears by the slip of both directions one by
        one, up to √2 of that in their plane.
    output : (str, int), optional
        Name of the output node and direction, 0 to 2; by default those of the largest amplitude at
        the beginning.
    step : float
        Largest change of an interference in a step, relative to it, or to the contact's largest
        normal displacement where that is larger. The error falls with its square.
    progress : callable, optional
        Called after each step with (cycles done, cycles in all, Hz, amplitude, m).

    Returns
    -------
    WearHistory
        `status` says why it ends.

    Raises
    ------
    InputError
        As of `frequency_response`, or if an argument is not possible, or the first dwell has no
        vibration to begin with.
    """
    given = (dwells,) if isinstance(dwells, Dwell) else tuple(dwells)
    if not given:
        raise InputError(f"dwells: given {dwells!r}: needs a Dwell, or a list of them")
    law = archard(system.contacts, coefficient, area)
    share = as_array(step, "step")
    if share.shape != () or not 0 < share <= _COARSEST:
        raise InputError(f"step: given {step!r}: must be one number > 0 and <= {_COARSEST:g}")
    if options.harmonics == 0:
        raise InputError("harmonics: given 0: vibration needs at least 1")
    component = named_component(system.output_names, output)
    found = _History(law, float(share), given, system, options, progress)
    found.run(component)
    return found.collected()


@dataclass(frozen=True)
class _WornState:
    """What is known after so many cycles of a dwell."""

    cycles: float
    dwell: int
    vibration: Vibration
    rate: Floats
    rest: Rest
    response: Response
    jumped: bool = False
    higher: Vibration | None = None


class _History:
    """States, one after another; of the dwell `i` so far, found by `vibrations`."""

    vibrations: Vibrations

    def __init__(
        self,
        law: Law,
        share: float,
        dwells: tuple[Dwell, ...],
        system: System,
        options: Options,
        progress: _Progress | None,
    ) -> None:
        self.law, self.share, self.dwells = law, share, dwells
        self.system, self.options = system, options
        self.joints, self.at_rest = preload(system, options)
        self.progress, self.total = progress, float(sum(each.cycles for each in dwells))
        self.states: list[_WornState] = []
        self.status, self.cycles_to_loss, self.solved, self.i = DONE, np.nan, 0, 0

    def run(self, component: tuple[int, int] | None) -> None:
        """Pass through the dwells until one ends early."""
        v0, cycles = self.system.contacts.v0, 0.0
        for i, dwell in enumerate(self.dwells):
            self.i = i
            if not i or not dwell.continues(self.dwells[i - 1]):
                self.vibrations = vibrations(self.system, dwell, self.options)
                begun = self.vibrations.first(v0, component)
                self.solved += 1
                if begun is None and not self.states:
                    where = "no peak was found in it" if dwell.at_peak else "not solved there"
                    raise InputError(f"dwells[0]: given {_shown(dwell)}: {where}")
                if begun is None:
                    self.status = _LOST
                    return
                if not self._add(cycles, begun, self.at_rest(begun.v0)):
                    return
            last = self._dwelt(dwell)
            v0, component, cycles = last.v0, last.component, self.states[-1].cycles
            if self.status != DONE:
                return

    def _dwelt(self, dwell: Dwell) -> Vibration:
        """The vibration at the end of a dwell, or where it ends early."""
        begin, passed = self.states[-1].cycles, 0.0
        while True:
            last = self.states[-1]
            left = dwell.cycles - passed
            if left <= _ROUND_OFF * dwell.cycles:
                if dwell.at_peak:
                    self.states[-1] = replace(last, higher=self._higher(last.vibration))
                return last.vibration
            worn = last.rate > 0
            cycles = last.vibration.size[worn] / last.rate[worn]
            h = self.share * float(cycles.min(initial=np.inf))
            h = left if h >= (1 - _ROUND_OFF) * left else h
            taken = stepped(last.vibration, self.law, h, self.share, self.vibrations.following)
            if taken is None:
                self._ended(last, h)
                return last.vibration
            self.solved += taken.solved
            passed = dwell.cycles if taken.cycles == left else passed + taken.cycles
            rest = self.at_rest(taken.end.v0)
            if rest.converged and (opened := self._opened(rest)).any():
                self._opens(last, taken, opened)
                return self.states[-1].vibration
            if not self._add(begin + passed, taken.end, rest, taken.jumped):
                return last.vibration

    def _add(self, cycles: float, vibration: Vibration, rest: Rest, jumped: bool = False) -> bool:
        """One more state, where it is solved at rest, too."""
        if not rest.converged:
            self.status = _LOST
            return False
        rate = self.law(vibration.solution.deviation)
        whole = self.vibrations.at(vibration.v0).response([vibration.solution])
        self.states.append(_WornState(cycles, self.i, vibration, rate, rest, whole, jumped))
        if self.progress is not None:
            self.progress(cycles, self.total, vibration.frequency, vibration.point.amplitude)
        return True

    def _higher(self, followed: Vibration) -> Vibration | None:
        """The highest peak of the range where it is higher than the one that was followed."""
        found = self.vibrations.first(followed.v0, followed.component)
        self.solved += 1
        least = (1 + _HIGHER) * followed.point.amplitude
        return found if found is not None and found.point.amplitude > least else None

    def _opened(self, rest: Rest) -> Booleans:
        """(j,) joints that are open at rest and were not at the beginning."""
        return np.asarray((self.states[0].rest.approach > 0) & (rest.approach <= 0))

    def _opens(self, last: _WornState, taken: WearStep, opened: Booleans) -> None:
        """End where the first of some joints opens within a step."""
        share = self._where(taken.interference, opened)
        self.status, self.cycles_to_loss = PRELOAD, last.cycles + share * taken.cycles
        v0 = taken.interference(share)
        found = self.vibrations.following(last.vibration, v0)
        self.solved += 1
        if found is not None:
            self._add(self.cycles_to_loss, found, self.at_rest(v0), taken.jumped)
            self.status = PRELOAD

    def _ended(self, last: _WornState, cycles: float) -> None:
        """End where no vibration is found within a step: because a joint opens, or not."""
        self.status = _LOST

        def straight(share: float) -> Floats:
            return np.asarray(last.vibration.v0 - share * cycles * last.rate)

        opened = self._opened(self.at_rest(straight(1.0)))
        if opened.any():
            self.status = PRELOAD
            self.cycles_to_loss = last.cycles + self._where(straight, opened) * cycles

    def _where(self, v0: Callable[[float], Floats], opened: Booleans) -> float:
        """Share of a step at which the first of the joints opens that are open after it."""
        from scipy.optimize import brentq  # loaded by those alone who ask: it loads CHOLMOD

        def approach(share: float) -> float:
            return float(self.at_rest(v0(share)).approach[opened].min())

        return float(brentq(approach, 0.0, 1.0, xtol=1e-10)) if approach(0.0) > 0 else 0.0

    def collected(self) -> WearHistory:
        """The states as arrays."""
        system = self.system
        node, direction = self.states[0].vibration.component
        each = [state.response for state in self.states]
        ones = [state.higher for state in self.states]
        higher = [(one.point.amplitude, one.frequency) if one else (np.nan, np.nan) for one in ones]
        higher_amplitude, higher_frequency = np.array(higher).T
        return WearHistory(
            output=system.output_names[node],
            direction=direction,
            joints=self.joints,
            cycles=np.array([each.cycles for each in self.states]),
            dwell=np.array([each.dwell for each in self.states], np.int64),
            frequency=np.array([each.vibration.frequency for each in self.states]),
            amplitude=np.array([each.vibration.point.amplitude for each in self.states]),
            jump=np.array([each.jumped for each in self.states], bool),
            rest_load=np.array([each.rest.load for each in self.states]),
            interference=np.array([each.vibration.v0 for each in self.states]),
            rate=np.array([each.rate for each in self.states]),
            status=self.status,
            cycles_to_loss=self.cycles_to_loss,
            solved=self.solved,
            force=np.array([self.dwells[each.dwell].force for each in self.states]),
            response=joined(each, system.contacts.mu)[0],
            higher_amplitude=higher_amplitude,
            higher_frequency=higher_frequency,
        )


def _shown(dwell: Dwell) -> str:
    """A dwell's frequencies in words."""
    if dwell.near is None:
        return f"{dwell.frequency:g} Hz"
    return "near = ({:g}, {:g}) Hz".format(*dwell.near)
