"""What moves the peak of a case: amplitude and frequency by each of its keys, to first order."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Array, Floats
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.nonlinear import AmplitudeGradient, HarmonicModes, PeakGradient, Response
from vanelock.nonlinear.peaks.amplitude_gradient import modal_stiffness
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import Monitor, as_solved
from vanelock.stages.response.summary import Peak

Moduli: TypeAlias = dict[str, dict[int, Array]]
"""What a part's modulus adds to the stiffness, by key and nodal diameter."""

EXCITATION = "excitation"
"""The key of a factor on all that excites."""
_NARROW = 1e-3
"""Half-width of a peak, of its frequency, where its curve does not show it."""


@dataclass(frozen=True)
class Sensitivities(Product):
    """By how many per cent a peak moves where one of n keys grows by one per cent.

    Attributes
    ----------
    keys : tuple of str
        Of the study or the scene.
    amplitude : (n,) float
        Of the monitored displacement.
    frequency : (n,) float
        NaN where it is not known.
    at : (2,) float
        The peak: its frequency, Hz, and amplitude, m; NaN without one.
    reason : str
        Why nothing is known.
    """

    keys: tuple[str, ...] = ()
    amplitude: Floats = field(default_factory=lambda: np.zeros(0))
    frequency: Floats = field(default_factory=lambda: np.zeros(0))
    at: Floats = field(default_factory=lambda: np.full(2, np.nan))
    reason: str = ""


def sensitivities_step(planned: Planned, peak: Peak, watched: Monitor) -> Step[Sensitivities]:
    """What moves the peak of a case, `solved`."""

    def compute(get: Callable[[Step[Any]], Any]) -> Sensitivities:
        system: System = get(planned.system)
        modes: HarmonicModes = get(planned.modes)
        response = get(planned.response)
        top = as_solved(response, peak.point)
        output = system.output_names[watched.node], watched.component
        width = _half_width(response, watched, peak.point)
        if peak.at_edge:
            return Sensitivities(reason="the largest amplitude lies at the end of the range")
        try:
            found = nonlinear.peak_gradient_of(system, top, 0, output, width, modes.diameters)
        except InputError as error:
            return Sensitivities(reason=str(error).partition(": ")[2] or str(error))
        if found.peak.sharp:
            return Sensitivities(
                reason="the peak is sharp: it lies where a contact's state changes"
            )
        return _relative(found, planned, _moduli(planned, top, get))

    inputs = {"point": peak.point, "node": watched.node, "component": watched.component}
    needs = (planned.response, planned.system)
    code = "sensitivities", "nonlinear", inputs, Sensitivities, needs, compute
    return step(*code, pulls=True, of=planned.case.name)


def _half_width(response: Response, watched: Monitor, point: int) -> float:
    """About the half-width of a peak, Hz, by the parabola through its neighbours."""
    size, order = watched.amplitude(response), np.argsort(response.frequency, kind="stable")
    at = int(np.flatnonzero(order == point)[0])
    beside = order[max(at - 1, 0) : at + 2]
    if len(beside) == 3 and np.isfinite(size[beside]).all():
        f = response.frequency[beside] - response.frequency[point]
        if len(set(f.tolist())) == 3:
            bend = 2 * np.polyfit(f, size[beside] / size[point], 2)[0]
            if bend < 0:
                return float((-bend) ** -0.5)
    return _NARROW * float(response.frequency[point])


def _relative(peak_gradient: PeakGradient, planned: Planned, moduli: Moduli) -> Sensitivities:
    """Per cent per per cent of every key that is not zero."""
    prepared = peak_gradient.at_peak.structure
    modal = {key: modal_stiffness(prepared, each) for key, each in moduli.items()}
    joints = "joints" if planned.meshes else "contacts"
    by_amplitude = {
        key: value
        for key, value in effects(peak_gradient.at_peak, joints, modal).items()
        if value or key == EXCITATION
    }
    frequency = np.full(len(by_amplitude), np.nan)
    if peak_gradient.beside:

        def each(gradient: AmplitudeGradient) -> Floats:
            known = effects(gradient, joints, modal)
            return np.array([known[key] for key in by_amplitude])

        frequency = peak_gradient.of_frequency(each) / peak_gradient.frequency
    return Sensitivities(
        keys=tuple(by_amplitude),
        amplitude=np.array(list(by_amplitude.values())) / peak_gradient.amplitude,
        frequency=frequency,
        at=np.array([peak_gradient.frequency, peak_gradient.amplitude]),
    )


def effects(
    gradient: AmplitudeGradient, joints: str, modal: Mapping[str, Mapping[int, Array]]
) -> dict[str, float]:
    """By key p its effect p dA/dp on an amplitude, m."""
    ratio = gradient.structure.system.damping_ratio or 0.0
    return {
        EXCITATION: gradient.by_force(),
        "loads at rest": gradient.by_rest_force(),
        "damping.ratio": ratio * gradient.by_damping(),
        **dict(_of_joints(gradient, joints)),
        **{key: gradient.by_modal_stiffness(each) for key, each in modal.items()},
    }


def _of_joints(gradient: AmplitudeGradient, joints: str) -> Iterator[tuple[str, float]]:
    """Effects of the keys of each joint."""
    contacts = gradient.structure.system.contacts
    stiffness = contacts.stiffness * gradient.by_contact_stiffness()
    by_contact = {
        "mu": gradient.by_friction(),
        "interference": contacts.v0 * gradient.by_interference(),
        "kn": stiffness[:, 0],
        "kt": stiffness[:, 1:].sum(axis=1),
    }
    for joint in dict.fromkeys(contacts.joints) or ("",):
        mask = contacts.of(joint) if joint else np.ones(contacts.count, bool)
        for name, values in by_contact.items():
            yield ".".join(filter(None, (joints, joint, name))), float(values[mask].sum())


def _moduli(planned: Planned, top: Response, get: Callable[[Step[Any]], Any]) -> Moduli:
    """Those of a study's parts, what their meshes add taken off where the study has it so."""
    structure = planned.structure
    if not isinstance(structure, StudyStructure):
        return {}
    N = planned.case.study.ring.sectors
    used = {folded(int(k), N) for k in top.harmonic_diameters}
    return by_moduli(structure, get, get(planned.system), used)


def by_moduli(
    structure: StudyStructure,
    get: Callable[[Step[Any]], Any],
    system: System,
    diameters: Iterable[int],
    moduli: Sequence[float] = (1.0, 1.0),
) -> Moduli:
    """What the moduli of vane and casing add to a system's stiffness, p dK/dp.

    `moduli` are those in the system over those of the parts.
    """
    found: Moduli = {f"material.{part}.E": {} for part in PARTS}
    for k in diameters:
        one, excess = system.at(k), structure.excess(k)
        for i, part in enumerate(PARTS):
            K = one.joined(part, get(structure.component(part, k)).at(k).K)
            less = 0.0 if excess is None else get(excess).diameters[k].stiffness[i]
            found[f"material.{part}.E"][k] = moduli[i] * (K - less)
    return found
