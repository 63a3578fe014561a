"""What an engineer asks of a run, case by case: margins, wear, damping, and a check of the peak."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Audit, Response
from vanelock.pipeline.cache import key_of
from vanelock.pipeline.step import Stages, Step
from vanelock.quantities.contacts.energy import EnergyBalance, balance, bandwidth_ratio
from vanelock.quantities.contacts.places import Places, places
from vanelock.quantities.contacts.wear import Wear, wear
from vanelock.quantities.curves_and_fields import RunData
from vanelock.quantities.selection import named, sampled
from vanelock.quantities.stress.cycles import Stressed, stressed_step
from vanelock.quantities.stress.fatigue import Cycle, Strength
from vanelock.quantities.stress.locations import Spots, spots
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak

MOST = 8
"""Cases that are looked into; of more, some."""
FEW = 60
"""Cases that are all told how much they are damped: each takes its system anew."""
AUDITED = 2**14
"""Samples of the period at which a peak is marched again."""


@dataclass(frozen=True)
class Margin:
    """How far a place is from the Goodman line.

    Attributes
    ----------
    what : str
        Of what this is the worst place.
    node : int or None
        Of the part; None for a gauge.
    where, doubt : str
        The place in words, and why its stress may mean nothing, "" if it does.
    amplitude, mean, mean_mises, chord : float
        As of `fatigue.Cycle`, Pa.
    strength : Strength
    """

    what: str
    node: int | None
    where: str
    doubt: str
    amplitude: float
    mean: float
    mean_mises: float
    chord: float
    strength: Strength

    @property
    def reserve(self) -> float:
        """Goodman's factor n on both stresses, by Sines."""
        return float(self.strength.reserve(self.amplitude, self.mean))

    @property
    def reserve_mises(self) -> float:
        """The same with the signed von Mises stress of the mean."""
        return float(self.strength.reserve(self.amplitude, self.mean_mises))

    @property
    def growth(self) -> float:
        """Factor by which the vibration alone may grow."""
        return float(self.strength.growth(self.amplitude, self.mean))


@dataclass(frozen=True)
class CaseAnswers:
    """Answers of one case at its peak.

    Attributes
    ----------
    name : str
    key : str
        Hash of what the stresses depend on, the response included.
    planned : Planned
        Its steps, as solved.
    top : Response
        The largest point alone.
    peak : Peak
    cycles : Stressed
        Stress of every node and gauge.
    spots : dict of str to Spots
        Places of each part's nodes.
    margins : dict of str to tuple of Margin
        By part: anywhere, clear of corners and point forces, aerofoils, gauges.
    features : dict of str to tuple of Margin
        By part: the worst clear place of each feature.
    places : Places
        The contacts.
    wear : Wear
    balance : EnergyBalance
    bandwidth : float
        Damping ratio by the half-power bandwidth; NaN where the curve does not tell.
    audit : Audit or None
        The peak checked by marching; None for what an audit does not cover.
    """

    name: str
    key: str
    planned: Planned
    top: Response
    peak: Peak
    cycles: Stressed
    spots: dict[str, Spots]
    margins: dict[str, tuple[Margin, ...]]
    features: dict[str, tuple[Margin, ...]]
    places: Places
    wear: Wear
    balance: EnergyBalance
    bandwidth: float
    audit: Audit | None

    @property
    def numbers(self) -> dict[str, tuple[float | str | list[float], str]]:
        """What the results file holds of this, each with its unit."""
        b, m = self.balance, self.governing
        gauges = [each for each in self.margins["vane"] if each.node is None]
        found: dict[str, tuple[float | str | list[float], str]] = {
            "damping_ratio": (b.damping_ratio, "1"),
            "bandwidth_ratio": (self.bandwidth, "1"),
            "input_work": (b.input, "J"),
            "friction_work": (b.friction, "J"),
            "stored_energy": (b.stored, "J"),
            "alternating_stress": (m.amplitude, "Pa"),
            "mean_stress": (m.mean, "Pa"),
            "goodman_reserve": (m.reserve, "1"),
            "vibration_may_grow": (m.growth, "1"),
            "largest_slip": (float(np.nanmax(self.wear.slip, initial=0.0)), "m"),
            "place": (m.where, ""),
        }
        if gauges:
            found["gauge_alternating_stress"] = ([each.amplitude for each in gauges], "Pa")
            found["gauge_mean_stress"] = ([each.mean for each in gauges], "Pa")
            found["gauge_goodman_reserve"] = ([each.reserve for each in gauges], "1")
        return found

    @property
    def governing(self) -> Margin:
        """The vane's worst place whose stress means something."""
        clear = [m for m in self.margins["vane"] if not m.doubt and m.node is not None]
        return min(clear or self.margins["vane"], key=lambda m: m.reserve)


def looked_into(run_data: RunData) -> list[str]:
    """Names of the cases that get answers of their own, in order.

    All if they are few; of samples those that have pictures, of other sweeps the first, the last
    and those of the extreme peaks.
    """
    peaks = run_data.shown.peak
    names = list(peaks)
    if len(names) <= MOST:
        return names
    if sampled(run_data):
        return [each.case.name for each in named(run_data)]
    height = {name: peaks[name].amplitude for name in names}
    chosen = {names[0], names[-1], max(names, key=height.__getitem__)}
    chosen.add(min(names, key=height.__getitem__))
    return [name for name in names if name in chosen]


def answers(run_data: RunData) -> dict[str, CaseAnswers]:
    """Answers of the cases of a run that are looked into."""
    known: dict[str, Spots] = {}
    chosen = looked_into(run_data)
    return {
        each.case.name: _answers(run_data, each, known)
        for each in run_data.planned
        if each.case.name in chosen
    }


def _answers(run_data: RunData, planned: Planned, known: dict[str, Spots]) -> CaseAnswers:
    stages, name = run_data.stages, planned.case.name
    peak = run_data.shown.peak[name]
    study = planned.case.study
    response = stages.get(planned.response)
    planned = planned.solved(response)
    top, system = as_solved(response, peak.point), stages.get(planned.system)
    step = stressed_step(run_data, planned, peak.point)
    cycles = stages.get(step)
    parts = {part: stages.get(mesh_step(study, part)) for part in PARTS}
    for part in PARTS:
        key = mesh_step(study, part).key
        if key not in known:
            known[key] = spots(study, parts[part])
    at = {part: known[mesh_step(study, part).key] for part in PARTS}
    margins = {
        part: _margins(at[part], getattr(cycles, part), strength(study, part)) for part in PARTS
    }
    if cycles.gauges is not None and planned.gauges is not None:
        names = stages.get(planned.gauges).names
        gauges = (
            _margin(f"gauge {g + 1}", None, name, "", cycles.gauges, g, strength(study, "vane"))
            for g, name in enumerate(names)
        )
        margins["vane"] = (*margins["vane"], *gauges)
    contacts = places(study, parts["vane"])
    frequency, amplitude, converged = run_data.shown.curve[name]
    return CaseAnswers(
        name=name,
        key=step.key,
        planned=planned,
        top=top,
        peak=peak,
        cycles=cycles,
        spots=at,
        margins=margins,
        features={
            part: _features(at[part], getattr(cycles, part), strength(study, part))
            for part in PARTS
        },
        places=contacts,
        wear=wear(top, 0, contacts.area, contacts.coefficient),
        balance=balance(system, top),
        bandwidth=bandwidth_ratio(frequency, np.where(converged, amplitude, np.nan)),
        audit=_audited(planned, top, peak.point, stages),
    )


def balances(run_data: RunData) -> dict[str, EnergyBalance]:
    """Energies at the peak of every case, unless there are too many of them."""
    if len(run_data.planned) > FEW:
        return {}
    found = {}
    for each in run_data.planned:
        name = each.case.name
        if name in run_data.shown.peak:
            planned = each.solved(run_data.stages.get(each.response))
            found[name] = balance(run_data.stages.get(planned.system), run_data.top(each))
    return found


def strength(study: Study, part: str) -> Strength:
    """What a part of a study bears."""
    own = getattr(study.material, part)
    return Strength(own.fatigue_limit, own.tensile_strength)


def _margin(
    what: str, node: int | None, where: str, doubt: str, found: Cycle, i: int, bears: Strength
) -> Margin:
    return Margin(
        what=what,
        node=node,
        where=where,
        doubt=doubt,
        amplitude=float(found.amplitude[i]),
        mean=float(found.mean[i]),
        mean_mises=float(found.mean_mises[i]),
        chord=float(found.chord[i]),
        strength=bears,
    )


def _worst(
    what: str, at: Spots, found: Cycle, bears: Strength, chosen: NDArray[np.bool_]
) -> list[Margin]:
    """The worst of some nodes, if there are any."""
    nodes = np.flatnonzero(chosen)
    if not len(nodes):
        return []
    n = bears.reserve(found.amplitude[nodes], found.mean[nodes])
    node = int(nodes[int(np.argmin(n))])
    return [_margin(what, node, at.words(node), at.doubt(node), found, node, bears)]


def _margins(at: Spots, found: Cycle, bears: Strength) -> tuple[Margin, ...]:
    aerofoil = np.char.startswith(at.feature, "aerofoil")
    every = np.ones(len(aerofoil), bool)
    return (
        *_worst("all nodes", at, found, bears, every),
        *_worst("clear of corners and point forces", at, found, bears, at.clear),
        *_worst("aerofoils with their roots", at, found, bears, aerofoil),
        *_worst("aerofoils, clear", at, found, bears, aerofoil & at.clear),
    )


def _features(at: Spots, found: Cycle, bears: Strength) -> tuple[Margin, ...]:
    """The worst clear place of each feature, the worst first."""
    made: list[Margin] = []
    for name in dict.fromkeys(sorted(at.feature.tolist())):
        made += _worst(name, at, found, bears, at.clear & (at.feature == name))
    return tuple(sorted(made, key=lambda m: m.reserve))


def _audited(planned: Planned, top: Response, point: int, stages: Stages) -> Audit | None:
    """An independent check of the peak, where one is possible."""
    if (top.coupling, top.friction, top.samples) != ("coupled", "orthogonal", 0):
        return None

    def compute() -> Audit:
        return nonlinear.audit_response(stages.get(planned.system), top, [0], AUDITED)

    inputs = {"point": point, "samples": AUDITED}
    key = key_of("check", "nonlinear", inputs, (planned.response.key, planned.system.key))
    return stages.get(Step("check", f"check {planned.case.name}", key, Audit, (), compute))
