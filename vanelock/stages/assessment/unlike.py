"""The steps that compute rings whose segments are not alike, one each, and all in numbers."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.input.schema.assessment.unlike import JointUnlikeKeys, UnlikeKeys
from vanelock.nonlinear import HarmonicModes, Options, Response, SectorModes, Unlike
from vanelock.pipeline.step import Step, step
from vanelock.rom import Component, System
from vanelock.rom.joining.vane_and_casing import joined_dofs
from vanelock.stages.assessment.bounds import Count
from vanelock.stages.parts.components import casing_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits, frequencies
from vanelock.stages.response.monitor import Monitor, monitor
from vanelock.stages.response.responses import frequency_keys
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import peak_of

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class UnlikeRing(Product):
    """The monitored displacement of every segment of one ring.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    amplitude : (p, N) float
        Half the peak-to-peak, m.
    converged : (p,) bool
    alike : float
        Largest amplitude over the frequencies, were all segments alike, m; NaN if none converged.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    converged: NDArray[np.bool_]
    alike: float = field(metadata={"unit": "m"})

    @property
    def known(self) -> Floats:
        """(p, N) amplitudes; -1 where a point did not converge, so that no maximum is there."""
        return np.where(self.converged[:, None], self.amplitude, -1.0)


@dataclass(frozen=True)
class UnlikeRings(Product):
    """R rings of N unlike segments in numbers, and the curves of the worst one.

    Attributes
    ----------
    amplitude : (R, N) float
        Largest amplitude of each segment over the frequencies, m; NaN if no point converged.
    frequency : (R, N) float
        Where it has it, Hz.
    alike : (R,) float
        The same of alike segments, m.
    points, lost : (R,) int
        Frequencies, and how many of them did not converge.
    at_edge : (R,) bool
        Whether the largest of all segments is at an end of the range.
    worst : UnlikeRing
        That with the largest amplitude.
    """

    amplitude: Floats = field(metadata={"unit": "m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    alike: Floats = field(metadata={"unit": "m"})
    points: NDArray[np.int64]
    lost: NDArray[np.int64]
    at_edge: NDArray[np.bool_]
    worst: UnlikeRing

    @property
    def amplification(self) -> Floats:
        """(R, N) amplitudes over that of alike segments."""
        return self.amplitude / self.alike[:, None]

    @property
    def largest(self) -> Floats:
        """(R,) amplification of the worst segment of each ring; NaN where nothing converged."""
        return np.asarray(self.amplification.max(axis=1))

    @property
    def place(self) -> tuple[int, int] | None:
        """Ring and segment of the largest amplitude; None if nothing converged."""
        if np.isnan(self.amplitude).all():
            return None
        ring, segment = np.unravel_index(np.nanargmax(self.amplitude), self.amplitude.shape)
        return int(ring), int(segment)


def unlike_step(
    planned: Planned, first: Planned, whole: Step[System], count: Count
) -> tuple[Step[UnlikeRings], tuple[Step[UnlikeRing], ...]]:
    """All rings of a case in numbers, and each by itself."""
    keys = planned.case.given.unlike
    assert keys is not None
    rings = tuple(_ring_step(planned, first, whole, keys, i) for i in range(keys.count))

    def compute(get: Callable[[Step[Any]], Any]) -> UnlikeRings:
        found: list[UnlikeRing] = []
        for ring in rings:
            found.append(get(ring))
            count(len(found), len(rings), float(found[-1].known.max()))
        return _summed(found)

    name = planned.case.name
    made = step(
        "unlike", "nonlinear", {}, UnlikeRings, rings, compute, kept=False, pulls=True, of=name
    )
    return made, rings


def _ring_step(
    planned: Planned, first: Planned, whole: Step[System], keys: JointUnlikeKeys, number: int
) -> Step[UnlikeRing]:
    """One ring of a case, the `number`th one drawn."""
    given, free = planned.case.given, first.linear.responses["free"]
    limits, adaptive = planned.linear.limits, planned.chosen_mesh is not None
    inputs = {
        "deviations": keys.given,
        "modes": keys.modes if isinstance(keys, UnlikeKeys) else None,
        "seed": [keys.seed, number],
        "range": keys.range,
        "monitor": given.outputs.monitor,
        **frequency_keys(given),
        "response": given.response.model_dump(include={"harmonics", "friction", "direction"}),
    }
    needs: tuple[Step[Any], ...] = (whole, limits, first.linear.system, free, planned.modes)
    needs += (planned.response,) if adaptive else ()
    own = None
    if isinstance(keys, UnlikeKeys) and keys.frequency is not None:
        own = modes_step(planned, whole, keys.modes)
    needs += (_shared_step(planned, whole, own), *(() if own is None else (own,)))

    def compute(
        system: System,
        limits: Limits,
        base: System,
        free: Response,
        stuck: HarmonicModes,
        *others: Any,
    ) -> UnlikeRing:
        watched = monitor(given.outputs.monitor, base, free)
        options = Options(
            harmonics=peak_harmonics(others[0], watched) if adaptive else given.response.harmonics,
            friction=given.response.friction,
            direction="down" if given.response.direction == "down" else "up",
        )
        modes: SectorModes | None = None if own is None else others[-1]
        shared: HarmonicModes = others[-1 if own is None else -2]
        unlike = drawn(system, keys, number, modes)
        hertz = frequencies(given, limits)
        if keys.range is not None:
            hertz = keys.range[0], keys.range[1]
        found = nonlinear.ring_response(
            system, hertz, unlike, options, modes=stuck.diameters, shared=shared.diameters
        )
        return UnlikeRing(
            found.frequency,
            found.amplitude[:, :, watched.node, watched.component],
            found.converged,
            float(found.alike[watched.node, watched.component]),
        )

    name = f"{number + 1} of {planned.case.name}"
    return step("unlike ring", "nonlinear", inputs, UnlikeRing, needs, compute, quick=True, of=name)


def peak_harmonics(response: Response, watched: Monitor) -> int:
    """Number of harmonics of the peak, where an accuracy chooses them."""
    peak = peak_of(response, watched.amplitude(response))
    return int((response if peak is None else as_solved(response, peak.point)).harmonics)


def drawn(
    system: System, keys: JointUnlikeKeys, number: int, modes: SectorModes | None = None
) -> Unlike:
    """By how much the segments of a ring differ, the `number`th one drawn, from 0."""
    asked: dict[str, dict[str, Any]] = {
        joint: {name: value for name, value in each if value is not None}
        for joint, each in keys.joints.items()
    }
    if isinstance(keys, UnlikeKeys) and keys.frequency is not None:
        asked["modes"] = {"frequency": keys.frequency}
    seed = int(np.random.SeedSequence([keys.seed, number]).generate_state(1)[0])
    return Unlike.scatter(system, asked, seed, modes)


def modes_step(planned: Planned, whole: Step[System], count: int) -> Step[SectorModes]:
    """Modes of a vane alone, free, as they are seen in the ring's coordinates."""
    study = planned.case.study
    vane, every = planned.rom["vane"], range(study.ring.sectors // 2 + 1)
    adaptive = planned.chosen_mesh is not None
    casings = tuple(
        planned.rom["casing"] if k in planned.held and not adaptive else casing_step(study, k)
        for k in every
    )

    def compute(system: System, vane: Component, *casings: Component) -> SectorModes:
        part = {}
        for k, casing in zip(every, casings, strict=True):
            part[k] = np.zeros((vane.size, len(system.at(k).K)))
            part[k][np.arange(vane.size), joined_dofs(vane, casing)] = 1.0
        block = vane.at(0)
        return SectorModes.of_part(system, block.K.real, block.M.real, part, count)

    needs: tuple[Step[Any], ...] = (whole, vane, *casings)
    return step("vane modes", "rom", {"count": count}, SectorModes, needs, compute, False, True)


def _shared_step(
    planned: Planned, whole: Step[System], own: Step[SectorModes] | None
) -> Step[HarmonicModes]:
    """Stuck modes of all nodal diameters, which all rings share."""

    def compute(system: System, stuck: HarmonicModes, *others: SectorModes) -> HarmonicModes:
        return nonlinear.ring_modes(system, *(others or (None,)), known=stuck.diameters)

    needs: tuple[Step[Any], ...] = (whole, planned.modes, *(() if own is None else (own,)))
    return step("ring modes", "nonlinear", {}, HarmonicModes, needs, compute, False, True)


def _summed(rings: list[UnlikeRing]) -> UnlikeRings:
    """Rings in numbers."""
    known = [ring.known for ring in rings]
    amplitude = np.array([each.max(axis=0) for each in known])
    at = np.array([each.argmax(axis=0) for each in known])
    largest = [int(each.max(axis=1).argmax()) for each in known]
    return UnlikeRings(
        amplitude=np.where(amplitude < 0, np.nan, amplitude),
        frequency=np.array([ring.frequency[i] for ring, i in zip(rings, at, strict=True)]),
        alike=np.array([ring.alike for ring in rings]),
        points=np.array([len(ring.frequency) for ring in rings]),
        lost=np.array([np.count_nonzero(~ring.converged) for ring in rings]),
        at_edge=np.array(
            [i in (0, len(r.frequency) - 1) for i, r in zip(largest, rings, strict=True)]
        ),
        worst=rings[int(np.argmax(amplitude.max(axis=1)))],
    )
