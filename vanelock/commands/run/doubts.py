"""What to know of a case before its numbers are used, from its products."""

from collections.abc import Iterator

import numpy as np

from vanelock.analyses import ANALYSES
from vanelock.input.schema.study import Study
from vanelock.mesh import Part, VaneDimensions
from vanelock.pipeline.step import Stages
from vanelock.quantities import warnings
from vanelock.quantities.case_result import CaseResult
from vanelock.rom import Contacts
from vanelock.stages.matrices.gather import gathered
from vanelock.stages.parts.loads import load_lines
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import on_inertia, static_bounds_step

MOST = 300
"""Contacts up to which the loads that static friction may hold are looked for without being asked:
dense programmes, some minutes for so many."""


def doubts(planned: Planned, result: CaseResult, stages: Stages, is_first: bool) -> Iterator[str]:
    """Lines on a case.

    `is_first` says whether no other case of the run has had a peak: static friction is looked at in
    one.
    """
    given, system, peak = result.problem, result.system, result.peak
    limits, response, static = result.limits, result.response, result.static
    loose = result.summary.loose
    contacts = system.contacts
    held = static.converged.all() and not loose
    yield from warnings.at_rest(static, loose)
    yield from warnings.relieved(on_inertia(system))
    yield from warnings.alike(limits.mac)
    yield from warnings.reduced(limits, float(response.frequency.max()))
    if isinstance(given, Study):
        vane = result.parts[0]
        nodes, points = vane.points, result.places.points
        small = _thin(given, vane)
    else:
        pieces = [stages.get(planned.part(name, 0)) for name in planned.structure.names]
        nodes = np.concatenate([np.empty((0, 3)), *(piece.positions for piece in pieces)])
        points, small = None, warnings.tenth(nodes)
    yield from warnings.implausible(limits.stuck_frequency, nodes)
    closed = contacts.always_closed or tuple(dict.fromkeys(contacts.joints))
    yield from warnings.open_at_rest(static, contacts.joints, closed)
    if peak is not None:
        if is_first and held and not contacts.elements and "bounds" not in planned.analyses:
            bounds = None
            if contacts.count <= MOST:
                friction = given.response.friction
                bounds = stages.get(static_bounds_step(friction, *planned.preload.needs))
            yield from warnings.static_friction(bounds, contacts.joints, response, peak)
        if isinstance(given, Study) and given.mesh.correction != "none":
            closed = contacts.always_closed
            yield from warnings.corrected(response, peak, contacts.joints, closed)
        yield from warnings.large(response, peak, *small, points)
        yield from warnings.beyond_band(response, peak, limits.band)
    for analysis in ANALYSES:
        if products := result.found(analysis.key):
            yield from analysis.warnings(result, products)


def load_lines_of(planned: Planned, stages: Stages) -> Iterator[str]:
    """What excites a case, a line each."""
    given, loaded, lists = planned.case.problem, None, None
    if isinstance(given, Study):
        loaded = len(stages.get(planned.meshes["casing"]).node_sets["force"])
    elif given.system is None:
        lists = gathered(given)
    yield from load_lines(given, loaded, lists)


def opening(contacts: Contacts) -> str:
    """The contacts that the limit "free" opens, in words."""
    if not contacts.always_closed:
        return "all contacts" if contacts.count else ""
    joints = dict.fromkeys(np.array(contacts.joints)[contacts.opens].tolist())
    return f"the contacts of {' and '.join(joints)}" if joints else ""


def _thin(study: Study, vane: Part) -> tuple[float, str]:
    """The length, m, that displacements of the vane must stay below to be small, and its name."""
    if isinstance(study.vane, VaneDimensions):
        return study.vane.thickness, "the aerofoils' thickness"
    return warnings.tenth(vane.points)
