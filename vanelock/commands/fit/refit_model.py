"""The response of a case with other joints, load, damping or moduli, without reducing anything.

What `[fit]` may vary enters when the reduced parts of the case are scaled and joined
(`StudyStructure.rejoined`). Modes of the stuck structure are computed again only
where stiffness or damping changed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from vanelock import nonlinear
from vanelock.analyses.bounds import BoundsKeys
from vanelock.commands.converge.converge import pinned
from vanelock.common.arrays import Floats, Integers
from vanelock.common.cyclic import folded
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import with_values
from vanelock.input.measured.curve import Measured
from vanelock.input.measured.units import DISPLACEMENT
from vanelock.input.schema.study import Study
from vanelock.nonlinear import PeakBounds, Response, System, amplitude_gradient
from vanelock.nonlinear.forced_response.options import PreparedSystem
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.peaks.amplitude_gradient import (
    modal_stiffness,
    prepared_again,
    solution_at,
)
from vanelock.pipeline.progress import Listener, Notice, silent
from vanelock.pipeline.step import Stages, Step
from vanelock.quantities.sensitivities import EXCITATION, Moduli, by_moduli, effects
from vanelock.stages.campbell.frequencies import with_temperature_speeds
from vanelock.stages.parts.loads import described, modulus
from vanelock.stages.parts.outputs import Gauges
from vanelock.stages.parts.segment import StudyStructure, segment_of
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.responses import Monitor, monitor

KEPT = 8
"""Responses that are kept, for their slopes."""


@dataclass
class Rejoined:
    """A case whose joints, load, damping and moduli may be others."""

    planned: Planned
    get: Callable[[Step[Any]], Any]
    monitor: Monitor
    gauges: Gauges | None
    harmonics: int
    _stiff: tuple[Any, ...] = field(default=(), init=False)
    _modes: Mapping[int, Any] = field(default_factory=dict, init=False)
    _known: dict[Any, "_SolvedCurve"] = field(default_factory=dict, init=False)

    @property
    def study(self) -> Study:
        """The case as it is."""
        return self.planned.case.study

    @property
    def structure(self) -> StudyStructure:
        """Its reduced parts."""
        found = self.planned.structure
        assert isinstance(found, StudyStructure)
        return found

    @property
    def reduced(self) -> set[str]:
        """Keys of all that its systems are made from."""
        return {step.key for step in self.structure.reduced(self.planned.diameters)}

    def system(self, values: Mapping[str, float]) -> System:
        """The system with some keys changed."""
        changed = with_values(self.study, dict(values))
        moduli = self._moduli_over(changed)
        diameters, own = self.planned.diameters, self.structure
        segment = replace(segment_of(changed), at_rest=own.segment.at_rest)
        system = own.rejoined(self.get, diameters, segment, moduli)
        # Moduli that are tried move the band with them; the study's own is what is to hold.
        system = replace(system, band=self.get(self.planned.system).band)
        stiff = (
            system.contacts.stiffness.tobytes(),
            *changed.damping.model_dump().values(),
            *moduli,
        )
        if stiff != self._stiff:
            self._stiff, self._modes = stiff, {}
        return system

    def _moduli_over(self, changed: Study) -> tuple[float, float]:
        """Moduli of vane and casing over the study's own."""
        vane, casing = (modulus(changed, p) / modulus(self.study, p) for p in ("vane", "casing"))
        return vane, casing

    def solved(
        self,
        values: Mapping[str, float],
        hertz: Floats,
        direction: str = "up",
        load: float = 1.0,
        jumps: bool = False,
    ) -> "_SolvedCurve":
        """The response at frequencies (p,), Hz, to a multiple of the load, and what it is of."""
        asked = (tuple(sorted(values.items())), hertz.tobytes(), direction, load, jumps)
        if asked in self._known:
            return self._known[asked]
        system = self.system(values)
        if load != 1:
            system = Parameter("force", system.contacts.springs, True).system(system, load)
        modes, options = self._stuck(system), self._options(direction)
        response = nonlinear.frequency_response(
            system, hertz, options, modes=modes, find_jumps=jumps
        )
        found = _SolvedCurve(system, response, modes)
        while len(self._known) >= KEPT:
            self._known.pop(next(iter(self._known)))
        self._known[asked] = found
        return found

    def prepared(
        self, values: Mapping[str, float], near: tuple[float, float], slider: Floats | None = None
    ) -> PreparedSystem:
        """The system ready to be solved over a range, Hz, sliders (c, 2) m assembled elsewhere."""
        system = self.system(values)
        if slider is not None:
            system = replace(system, contacts=replace(system.contacts, slider=slider))
        ready: PreparedSystem = self._options("up").prepare(system, near, 1000, self._stuck(system))
        return ready

    def bounds(
        self, values: Mapping[str, float], near: tuple[float, float], keys: BoundsKeys
    ) -> PeakBounds:
        """Between which values static friction may move the peak of a range, Hz."""
        system = self.system(values)
        return nonlinear.peak_bounds(
            system,
            near,
            self._options("up"),
            (system.output_names[self.monitor.node], self.monitor.component),
            "all",
            keys.share,
            keys.starts,
            seed=self.study.seed,
            modes=self._stuck(system),
        )

    def _stuck(self, system: System) -> Mapping[int, Any]:
        """Modes with all contacts stuck, of the stiffness that was asked for last."""
        if not self._modes:
            self._modes = nonlinear.harmonic_modes(system, self.harmonics).diameters
        return self._modes

    def _options(self, direction: str) -> nonlinear.Options:
        given = self.study.response
        return nonlinear.Options(
            self.harmonics,
            coupling=given.coupling,
            samples=given.samples,
            friction=given.friction,
            direction=direction,
        )

    def _of_curve(
        self, values: Mapping[str, float], curve: Measured, hertz: Floats | None = None
    ) -> tuple["_SolvedCurve", Integers]:
        """The response where a curve was measured, or elsewhere, and its points of these."""
        distinct, places = np.unique(
            curve.frequency if hertz is None else hertz, return_inverse=True
        )
        return self.solved(values, distinct, curve.direction, curve.load), places

    def amplitudes(
        self, values: Mapping[str, float], curve: Measured, hertz: Floats | None = None
    ) -> Floats:
        """(p,) amplitudes of a measured quantity at its own frequencies, or others, Hz.

        Not a number where a point did not converge.
        """
        solved, places = self._of_curve(values, curve, hertz)
        response = solved.response
        if curve.quantity == DISPLACEMENT:
            found = self.monitor.amplitude(response)
        else:
            assert self.gauges is not None
            strain = self.gauges.read(response, solved.system)
            found = np.where(response.converged, strain.amplitude[:, curve.gauge], np.nan)
        return np.asarray(found[places])

    def slopes(self, values: Mapping[str, float], keys: Sequence[str], curve: Measured) -> Floats:
        """(p, k) θ dA/dθ of these amplitudes by some keys; NaN where it is not known."""
        solved, places = self._of_curve(values, curve)
        system, component = solved.system, (self.monitor.node, self.monitor.component)
        if curve.quantity != DISPLACEMENT:
            assert self.gauges is not None
            assert curve.gauge is not None
            system = self.gauges.watched(system, curve.gauge)
            component = (0, 0)
        ready = prepared_again(system, solved.response, solved.modes)
        modal = {}
        if any(key.endswith(".E") for key in keys):
            modal = {
                key: modal_stiffness(ready.structure, each)
                for key, each in self._moduli(values, solved).items()
            }
        found = np.full((len(solved.response.frequency), len(keys)), np.nan)
        for i in np.flatnonzero(solved.response.converged):
            solution = solution_at(ready, solved.response, int(i))
            gradient = amplitude_gradient(ready, solution, component)
            if gradient is not None:
                known = effects(gradient, "joints", modal)
                known["excitation.force"] = known[EXCITATION]
                found[i] = [known[key] for key in keys]
        return found[places]

    def _moduli(self, values: Mapping[str, float], solved: "_SolvedCurve") -> Moduli:
        moduli = self._moduli_over(with_values(self.study, dict(values)))
        sectors = self.study.ring.sectors
        wanted = {folded(int(k), sectors) for k in solved.response.harmonic_diameters}
        return by_moduli(self.structure, self.get, solved.system, sorted(wanted), moduli)

    def jumps(self, values: Mapping[str, float], curve: Measured) -> list[tuple[float, float]]:
        """Neighbouring frequencies of a curve, Hz, that no curve of solutions joins."""
        distinct = np.unique(curve.frequency)
        found = self.solved(values, distinct, curve.direction, curve.load, jumps=True).response
        pairs = [] if found.jump is None else found.jump
        return [(float(found.frequency[a]), float(found.frequency[b])) for a, b in pairs]

    def neglected(self, values: Mapping[str, float], curve: Measured) -> Floats:
        """(p,) relative errors of displacements by neglected harmonics; NaN where not known."""
        solved, places = self._of_curve(values, curve)
        output = self.monitor.node, self.monitor.component
        found = [
            nonlinear.neglected_harmonics(solved.system, solved.response, i, output)
            for i in range(len(solved.response.frequency))
        ]
        return np.array(found)[places]


class _SolvedCurve(NamedTuple):
    """A response, the system that it is of, and its modes, all contacts stuck."""

    system: System
    response: Response
    modes: Mapping[int, Any]


def rejoined(study: Study, stages: Stages, listener: Listener = silent) -> Rejoined:
    """The only case of a study, reduced: its temperatures known, an accuracy's mesh chosen."""
    (case,) = with_temperature_speeds(cases(study), stages)
    if text := described(case.study):
        listener(Notice(text))
    chosen = pinned(case, stages)
    if study.accuracy is not None:
        (case,) = cases(chosen)
    (planned,) = plan([case])
    for step in planned.structure.reduced(planned.diameters):  # before one of them is asked for
        stages.get(step)
    free = stages.get(planned.linear.responses["free"])
    watched = monitor(case.study.outputs.monitor, stages.get(planned.system), free)
    gauges = None if planned.gauges is None else stages.get(planned.gauges)
    return Rejoined(planned, stages.get, watched, gauges, case.study.response.harmonics)
