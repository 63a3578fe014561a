"""Between which values static friction, which a model leaves undetermined, may move a peak.

Contacts that stick for good hold any friction within Coulomb's limit; their sliders' places decide
which, and how the joints that slip are loaded. Over all places at rest (`static_bounds`) the least
and the largest peak are looked for from several starts: places at which the load of a slipping
joint is least and largest, and random ones. From the best of them on, each step is a linear
programme along the peak's own gradient, and every peak is solved: on the way to each new place,
too, since peaks do not change steadily. The bounds are found, not proved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vanelock.common.arrays import Booleans, Floats, as_whole
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.bounds.rest_states import Joints, RestStates, rest_states
from vanelock.nonlinear.bounds.slider_search import Progress, Search
from vanelock.nonlinear.forced_response.options import Options, checked_range
from vanelock.nonlinear.forced_response.parameter_response import joined
from vanelock.nonlinear.forced_response.response import Response
from vanelock.nonlinear.fourier import one_thread
from vanelock.nonlinear.peaks.peak_tracking import named_component
from vanelock.rom.system.system import System


@dataclass(frozen=True)
class StaticBounds(Product):
    """Loads of j joints at rest: the least, that with sliders assembled at zero, and the largest.

    Attributes
    ----------
    joints : tuple of str
        Their names.
    rest_load : (j, 3) float
        Sum of the normal forces of a joint's contacts in a sector, N, each of a solved state; inf
        where friction can wedge the parts at any load, NaN where the programme failed.
    slider : (j, 3, c, 2) float
        Where the sliders were assembled for them, m; zeros where there is no such state.
    converged : (j, 3) bool
        Whether each was found, and its state at rest and that with sliders at zero are solved.
    proved : (j, 3) bool
        Whether no state lies beyond, whichever contacts are open; else it is the end of states
        that contacts reach by opening or closing one after another, and others may lie beyond.
    """

    joints: tuple[str, ...]
    rest_load: Floats = field(metadata={"unit": "N"})
    slider: Floats = field(metadata={"unit": "m"})
    converged: Booleans
    proved: Booleans


@one_thread
def static_bounds(
    system: System,
    of: str | Sequence[str] | None = None,
    joints: Joints = "all",
    share: float = 1.0,
    options: Options = Options(),
    modes: Mapping[int, StuckModes] | None = None,
) -> StaticBounds:
    """Between which loads static friction may hold joints at rest, each by itself.

    Parameters
    ----------
    system : System
        Its own sliders are not looked at.
    of : str or sequence of str, optional
        The joints whose load it is; every one by default.
    joints : str, sequence of str or (c,) bool
        Those whose static friction is undetermined. The others use the share of Coulomb's limit
        that they use with all sliders assembled at zero.
    share : float
        Share of Coulomb's limit by which friction may differ from that state, 0 to 1.
    options : Options
        As of `static_response`.
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.

    Raises
    ------
    InputError
        If a joint is unknown, the share is not possible, or the structure is not held.
    """
    states = rest_states(system, joints, share, options, modes)
    names = dict.fromkeys(system.contacts.joints if of is None else np.atleast_1d(of).tolist())
    found = []
    for name in names:
        mask = system.contacts.of(name)
        if not mask.any():
            known = ", ".join(dict.fromkeys(system.contacts.joints)) or "none"
            raise InputError(f"of: given {name!r}: joints are {known}")
        found.append([_end(states, mask, sign) for sign in (1.0, 0.0, -1.0)])
    slider, load, converged, proved = (
        np.array([[end[i] for end in ends] for ends in found]) for i in range(4)
    )
    shape = (len(names), 3)
    load, converged, proved = (each.reshape(shape) for each in (load, converged, proved))
    return StaticBounds(tuple(names), load, slider, converged, proved)


def _end(states: RestStates, mask: Booleans, sign: float) -> tuple[Floats, float, bool, bool]:
    """Sliders (c, 2), m, and load, N, where it is least (1) or largest (-1); if found; if proved.

    With 0 those assembled at zero.
    """
    try:
        slider, proved = states.proved_load(mask, sign) if sign else (states.zero, True)
    except InputError:
        return states.zero, np.nan, False, False
    if slider is None:
        return states.zero, np.inf, True, True
    state = states.solved(slider) if sign else states.nominal
    load = state.force[0, 0, mask, 0].real.sum()
    known = state.converged.all() and states.nominal.converged.all()
    return slider, max(float(load), 0.0), bool(known), proved


@dataclass(frozen=True)
class PeakBounds(Product):
    """The least peak that was found, that with sliders assembled at zero, and the largest.

    Attributes
    ----------
    output : str
        Name of the output node whose peak it is.
    direction : int
        Its direction, 0, 1 or 2.
    frequency : (3,) float
        Of the peaks, Hz.
    amplitude : (3,) float
        Half the peak-to-peak of the output, m.
    slider : (3, c, 2) float
        Where the sliders were assembled, m.
    joints : tuple of str
        The joints, in the order of `rest_load` and `mean_load`.
    rest_load, mean_load : (3, j) float
        Sum of the normal forces of each joint's contacts in a sector, N, at rest and in the mean of
        the vibration.
    found_by : tuple of str
        How each was found: "assembled at zero", "load", "gradient" or "random".
    stationary : (3,) bool
        Whether a cone programme along the gradient led no further from there; of the middle one
        it is asked only where it is an end.
    converged : (3,) bool
        Whether the state at rest, the balance and the extremum condition of each are solved; a
        sharp peak has no such condition.
    drawn : (d,) float
        Peaks at random places, m.
    solved : int
        Frequencies solved.
    response : Response
        The whole state at each peak, three points; `system_at` gives the systems that they are of.
    """

    output: str
    direction: int
    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    slider: Floats = field(metadata={"unit": "m"})
    joints: tuple[str, ...]
    rest_load: Floats = field(metadata={"unit": "N"})
    mean_load: Floats = field(metadata={"unit": "N"})
    found_by: tuple[str, ...]
    stationary: Booleans
    converged: Booleans
    drawn: Floats = field(metadata={"unit": "m"})
    solved: int
    response: Response

    def system_at(self, system: System, which: int) -> System:
        """The system whose peak is the least (0), that at zero (1) or the largest (2)."""
        return replace(system, contacts=replace(system.contacts, slider=self.slider[which]))


@one_thread
def peak_bounds(
    system: System,
    near: tuple[float, float],
    options: Options = Options(),
    output: tuple[str, int] | None = None,
    joints: Joints = "all",
    share: float = 1.0,
    starts: int = 4,
    tolerance: float = 1e-2,
    seed: int = 1,
    progress: Progress | None = None,
    modes: Mapping[int, StuckModes] | None = None,
) -> PeakBounds:
    """Between which values undetermined static friction may move the highest peak of a range.

    Parameters
    ----------
    system : System
        Its own sliders are not looked at.
    near : (float, float)
        Range of frequencies in which the peak is looked for, Hz.
    options : Options
        Coupled, with located events and one harmonic at least; their direction is that in
        which sweeps pass frequencies.
    output : (str, int), optional
        Name of the output node and direction, 0 to 2; by default those of the largest amplitude.
    joints : str, sequence of str or (c,) bool
        Those whose static friction is undetermined.
    share : float
        Share of Coulomb's limit by which friction at rest may differ from that with sliders
        assembled at zero; 0: nothing but that one's peak.
    starts : int
        Random places to start from, each for both bounds.
    tolerance : float
        Relative change of a peak below which a search ends.
    seed : int
        Of the random places.
    progress : callable, optional
        Called after each peak with (peaks solved, amplitude in m).
    modes : dict of int to StuckModes, optional
        As of `frequency_response`.

    Raises
    ------
    InputError
        As of `frequency_response` and `static_bounds`, or if no peak lies in the range, or none is
        found with sliders at zero and nothing but friction damps.
    """
    for name, given in (("starts", starts), ("seed", seed)):
        if as_whole(given, name) < 0:
            raise InputError(f"{name}: given {given}: must be >= 0")
    if not tolerance > 0:
        raise InputError(f"tolerance: given {tolerance}: must be > 0")
    if options.coupling != "coupled" or options.samples is not None:
        raise InputError("options: bounds are of coupled balances with located events")
    hertz = checked_range(near, "near")
    states = rest_states(system, joints, share, options, modes)
    system = states.system
    component = named_component(system.output_names, output)
    ready = options.prepare(system, hertz, 1000, states.modes)
    search = Search(ready, states, hertz, component, progress)
    places, drawn = search.extremes(starts, tolerance, np.random.default_rng(seed))
    joints = tuple(dict.fromkeys(system.contacts.joints))
    masks = np.array([system.contacts.of(joint) for joint in joints])
    at_rest = [states.solved(place.slider) for place in places]
    rest = np.array([state.force[0, 0, :, 0].real for state in at_rest])
    known = np.array([state.converged.all() for state in (states.nominal, *at_rest)])
    responses = [search.at(place.slider).response([place.peak.solution]) for place in places]
    response = joined(responses, system.contacts.mu)[0]
    exact = np.array([place.peak.exact for place in places])
    assert search.component is not None
    node, direction = search.component
    return PeakBounds(
        output=system.output_names[node],
        direction=direction,
        frequency=response.frequency,
        amplitude=np.array([place.peak.amplitude for place in places]),
        slider=np.array([place.slider for place in places]),
        joints=joints,
        rest_load=rest.clip(0) @ masks.T,
        mean_load=response.force[:, 0, :, 0].real @ masks.T,
        found_by=tuple(place.found_by for place in places),
        stationary=np.array([place.stationary for place in places]),
        converged=exact & known[0] & known[1:] & response.converged,
        drawn=np.array(drawn),
        solved=search.solved,
        response=response,
    )
