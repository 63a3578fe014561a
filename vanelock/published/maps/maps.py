"""Steps behind the maps: planes of peaks, and ridges of the peak along one parameter.

The plane of the study's own slant is solved on its own model with all methods; those of other
slants need other meshes, and take medium ones and every other line of the plane.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from vanelock.input.cases.sweep import Case
from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.nonlinear import HarmonicModes, Journal, System
from vanelock.pipeline.cache import Cache, code_of
from vanelock.pipeline.step import Step, step
from vanelock.published.maps import optimum, plane
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Method, Plane
from vanelock.published.sheets import COUPLINGS, HARMONICS
from vanelock.stages.parts.components import diameters
from vanelock.stages.response.limits import Limits, frequencies
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.responses import stuck_modes_step
from vanelock.stages.sweep.graph import CaseWork, Job

SLANT = "vane.interlock_slant"
DECADE = 10.0
"""How far ridges reach beyond the ends of the map, as a factor."""
COARSER = ("paper", "fine")
"""Named sizes in whose place other slants take "medium"."""
RIDGES = (1, 3)
"""Harmonics of the ridges, as far as the campaign has them."""


def methods(study: Study) -> tuple[Method, ...]:
    """Every method of the study's own plane: H = 1 thrice, and the coupled ones of higher H."""
    assert study.campaign is not None
    higher = [Method(h) for h in study.campaign.harmonics if h > 1]
    return (*(Method(1, coupling) for coupling in COUPLINGS), *higher)


def few_methods(study: Study) -> tuple[Method, ...]:
    """Those of other slants: H = 1 thrice, and the first higher H."""
    return methods(study)[: len(COUPLINGS) + 1]


@dataclass(frozen=True)
class PeakMap:
    """A plane of peaks over friction and interference, or friction and load.

    Attributes
    ----------
    name : str
        What the progress display calls it.
    scene : CaseWork
        The case whose system it is.
    other : {"interference", "load"}
    chosen : tuple of Method
    output : (int, int)
        Output node and direction.
    every : int
        Take every so many lines of the plane, the last one always.
    """

    name: str
    scene: CaseWork
    other: str
    chosen: tuple[Method, ...]
    output: tuple[int, int]
    every: int = 1

    @property
    def lines(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Values of friction, and of the other parameter."""
        campaign = self.scene.case.study.campaign
        assert campaign is not None
        of_load = self.other == "load"
        values = campaign.map_load if of_load else campaign.map_interference
        return thinned(campaign.map_mu, self.every), thinned(values, self.every)

    def steps(self) -> list[Step[Plane]]:
        """The steps of its points, friction by friction."""
        planned, (mu, value) = self.scene.planned(), self.lines
        most = max(each.harmonics for each in self.chosen)
        needs = planned.system, planned.linear.limits, stuck_modes_step(planned.system, most)
        inputs = {
            "other": self.other,
            "methods": [method.name for method in self.chosen],
            "output": self.output,
            "range": planned.case.study.response.range,
            "code": code_of("published.maps"),
        }
        return [
            step(
                f"map {self.name}",
                "nonlinear",
                {**inputs, "mu": m, "value": v},
                Plane,
                needs,
                partial(self._point, m, v),
                quick=True,
            )
            for m in mu
            for v in value
        ]

    def _point(
        self, mu: float, value: float, system: System, found: Limits, modes: HarmonicModes
    ) -> Plane:
        system, near = plane.changed(system, mu, self.other, value), ends(self.scene.case, found)
        rows = [plane.peak(system, each, near, self.output, modes) for each in self.chosen]
        return plane.of_point(self.other, mu, value, self.chosen, rows)

    def plane(self, progress: Callable[[int, int, float], None]) -> Step[Plane]:
        """The step that joins them; `progress` hears points done, in all, and the last peak, m."""
        points = tuple(self.steps())

        def compute(get: Callable[[Step[Plane]], Plane]) -> Plane:
            found = []
            for i, each in enumerate(points):
                found.append(get(each))
                progress(i + 1, len(points), float(found[i].amplitude.flat[0]))
            return plane.joined(found, *self.lines)

        return step(f"map {self.name}", "nonlinear", {}, Plane, points, compute, pulls=True)


@dataclass(frozen=True)
class RidgeWork:
    """The peak along friction or interference, a decade beyond the map at its upper end.

    Attributes
    ----------
    scene : CaseWork
        The case whose system it is.
    name : {"mu", "interference"}
    harmonics : int
    output : (str, int)
        Output node and direction.
    """

    scene: CaseWork
    name: str
    harmonics: int
    output: tuple[str, int]

    def steps(self) -> list[Step[Ridge]]:
        """Its step."""
        planned, name, output = self.scene.planned(), self.name, self.output
        study, harmonics = planned.case.study, self.harmonics
        assert study.campaign is not None
        values = study.campaign.map_mu if name == "mu" else study.campaign.map_interference
        reach = values[0] / DECADE**0.5, values[-1] * DECADE**0.5
        inputs = {
            "name": name,
            "ends": reach,
            "harmonics": harmonics,
            "output": output,
            "range": study.response.range,
            "code": code_of("published.maps"),
        }

        def compute(system: System, found: Limits, journal: Journal) -> Ridge:
            near = ends(self.scene.case, found)
            return optimum.ridge(system, name, reach, near, output, harmonics, journal=journal)

        label, needs = (
            f"peak along {name}, H = {harmonics}",
            (planned.system, planned.linear.limits),
        )
        return [step(label, "nonlinear", inputs, Ridge, needs, compute, resumes=True)]


@dataclass(frozen=True)
class Maps:
    """All maps of a campaign.

    Attributes
    ----------
    planes : dict of str to PeakMap
        "interference" and "load", of the study's own slant.
    slants : dict of float to PeakMap
        Of other slants, deg.
    ridges : tuple of RidgeWork
    """

    planes: dict[str, PeakMap]
    slants: dict[float, PeakMap]
    ridges: tuple[RidgeWork, ...]

    def jobs(self, cache: Cache) -> list[Job]:
        """What other processes can do of those that the cache has not."""
        found = []
        for each in (*self.planes.values(), *self.slants.values()):
            whole = each.plane(lambda *_: None)
            if not cache.holds(whole.stage, whole.key):
                found += [Job(whole.name, (point,), each) for point in whole.needs]
        for ridge in self.ridges:
            (own,) = ridge.steps()
            found.append(Job(own.name, (own,), ridge))
        return found


def planned_maps(scene: CaseWork, monitor: Monitor, node: str, band: float | None) -> Maps:
    """The maps of a campaign.

    Parameters
    ----------
    scene : CaseWork
        Its reference.
    monitor : Monitor
        Whose peaks they show; its `node` by name, too.
    band : float or None
        Of the reduced vane, Hz, see `slanted`.
    """
    study, output = scene.case.study, (monitor.node, monitor.component)
    campaign = study.campaign
    assert campaign is not None
    every, few = methods(study), few_methods(study)
    own = getattr(study.vane, "interlock_slant", None)
    return Maps(
        planes={
            other: PeakMap(f"friction, {other}", scene, other, chosen, output)
            for other, chosen in (("interference", every), ("load", every[: len(COUPLINGS)]))
        },
        slants={
            slant: PeakMap(
                f"slant {slant:g}", slanted(study, slant, band), "interference", few, output, 2
            )
            for slant in campaign.slants
            if slant != own
        },
        ridges=tuple(
            RidgeWork(scene, name, h, (node, output[1]))
            for h in RIDGES
            if h in campaign.harmonics
            for name in ("mu", "interference")
        ),
    )


def slanted(study: Study, slant: float, band: float | None) -> CaseWork:
    """The scene with other interlock faces, on a medium mesh or coarser.

    The `band` of the reduction, Hz, is that of the study's own vane where it has one, so that all
    slants share their casing.
    """
    highest = max(method.harmonics for method in few_methods(study))
    changes: dict[str, Any] = {SLANT: slant, HARMONICS: highest}
    if study.mesh.size in COARSER or not isinstance(study.mesh.size, str):
        changes |= {"mesh.size": "medium", "mesh.face_nodes": None}
    if band is not None and study.rom.band is None and study.rom.of("casing").get("accuracy"):
        changes["rom.band"] = band
    case = Case(f"slant {slant:g}", {SLANT: slant}, with_values(study, changes))
    return CaseWork(case, diameters([case.study]))


def ends(case: Case, limits: Limits) -> tuple[float, float]:
    """The range of frequencies in which peaks are looked for, Hz."""
    wanted = frequencies(case.study, limits)
    if isinstance(wanted, tuple):
        return wanted
    return float(np.min(wanted)), float(np.max(wanted))


def thinned(values: Sequence[float], every: int) -> tuple[float, ...]:
    """Every so many of the values, first and last included."""
    count = max(2, -(-len(values) // every) + (every > 1))
    places = np.unique(np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int))
    return tuple(values[i] for i in places)
