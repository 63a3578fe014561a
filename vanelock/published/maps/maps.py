"""Steps behind the maps: planes of peaks, and ridges of the peak along one parameter.

The plane of the study's own slant is solved on its own model with all methods; those of other
slants need other meshes, and take medium ones and every other line of the plane.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vanelock.input.cases.values import with_values
from vanelock.input.schema.study import Study
from vanelock.nonlinear import Journal, System
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.step import Step, step
from vanelock.published.maps import optimum, plane
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Method, Plane, PlaneTask
from vanelock.published.sheets import COUPLINGS, HARMONICS
from vanelock.stages.parts.bare import linear_system_step
from vanelock.stages.parts.components import diameters, rom_step, system_step
from vanelock.stages.response.limits import Limits, frequencies
from vanelock.stages.response.responses import limits_step

Told = Callable[[int, int, float], None]
Output = tuple[int, int]

SLANT = "vane.interlock_slant"
DECADE = 10.0
"""How far ridges reach beyond the ends of the map, as a factor."""
COARSER = ("paper", "fine")
"""Named sizes in whose place other slants take "medium"."""


def methods(study: Study) -> tuple[Method, ...]:
    """Every method of the study's own plane: H = 1 thrice, and the coupled ones of higher H."""
    assert study.campaign is not None
    higher = [Method(h) for h in study.campaign.harmonics if h > 1]
    return (*(Method(1, coupling) for coupling in COUPLINGS), *higher)


def few_methods(study: Study) -> tuple[Method, ...]:
    """Those of other slants: H = 1 thrice, and the first higher H."""
    return methods(study)[: len(COUPLINGS) + 1]


def plane_step(
    name: str,
    study: Study,
    system: Step[System],
    limits: Step[Limits],
    other: str,
    chosen: Sequence[Method],
    output: Output,
    told: Told,
    workers: int = 1,
    every: int = 1,
) -> Step[Plane]:
    """A plane of peaks over friction and interference, or friction and load.

    Parameters
    ----------
    name : str
        What the progress display calls it.
    study : Study
        With a campaign.
    system, limits : Step
        The scene's system and linear limits.
    other : {"interference", "load"}
    chosen : sequence of Method
    output : (int, int)
        Output node and direction.
    told : callable
        Hears points done, points in all and the last peak, m.
    workers : int
        Processes that compute its points.
    every : int
        Take every so many lines of the plane, the last one always.
    """
    campaign = study.campaign
    assert campaign is not None
    values = campaign.map_interference if other == "interference" else campaign.map_load
    mu, value = thinned(campaign.map_mu, every), thinned(values, every)
    inputs = {
        "other": other,
        "mu": mu,
        "value": value,
        "methods": [method.name for method in chosen],
        "output": output,
        "range": study.response.range,
        "code": code_of("published.maps"),
    }

    def compute(system: System, found: Limits, journal: Journal) -> Plane:
        task = PlaneTask(system, other, mu, value, chosen, ends(study, found), output)
        return plane.plane(task, told, journal, workers)

    name, needs = f"map {name}", (system, limits)
    return step(name, "nonlinear", inputs, Plane, needs, compute, resumes=True)


def ridge_step(
    study: Study,
    system: Step[System],
    limits: Step[Limits],
    name: str,
    harmonics: int,
    output: tuple[str, int],
) -> Step[Ridge]:
    """The peak along friction or interference, a decade beyond the map at its upper end."""
    campaign = study.campaign
    assert campaign is not None
    values = campaign.map_mu if name == "mu" else campaign.map_interference
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
        near = ends(study, found)
        return optimum.ridge(system, name, reach, near, output, harmonics, journal=journal)

    told, needs = f"peak along {name}, H = {harmonics}", (system, limits)
    return step(told, "nonlinear", inputs, Ridge, needs, compute, resumes=True)


def slanted(study: Study, slant: float, band: float | None) -> tuple[Step[System], Step[Limits]]:
    """System and limits of the scene with other interlock faces, on a medium mesh or coarser.

    The `band` of the reduction, Hz, is that of the study's own vane where it has one, so that all
    slants share their casing.
    """
    highest = max(method.harmonics for method in few_methods(study))
    changes: dict[str, Any] = {SLANT: slant, HARMONICS: highest}
    if study.mesh.size in COARSER or not isinstance(study.mesh.size, str):
        changes |= {"mesh.size": "medium", "mesh.face_nodes": None}
    if band is not None and study.rom.band is None and study.rom.of("casing").get("accuracy"):
        changes["rom.band"] = band
    other = with_values(study, changes)
    wanted = diameters([other])
    rom = {part: rom_step(other, part, wanted) for part in ("vane", "casing")}
    base = linear_system_step(other, **rom)
    return system_step(other, **rom), limits_step(other.response.mode, base, tuple(rom.values()))


def ends(study: Study, limits: Limits) -> tuple[float, float]:
    """The range of frequencies in which peaks are looked for, Hz."""
    wanted = frequencies(study, limits)
    if isinstance(wanted, tuple):
        return wanted
    return float(np.min(wanted)), float(np.max(wanted))


def thinned(values: Sequence[float], every: int) -> tuple[float, ...]:
    """Every so many of the values, first and last included."""
    count = max(2, -(-len(values) // every) + (every > 1))
    places = np.unique(np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int))
    return tuple(values[i] for i in places)
