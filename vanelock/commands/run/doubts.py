"""What to know of a case before its numbers are used, from its products."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.spatial import cKDTree

from vanelock.analyses import ANALYSES
from vanelock.common.arrays import Floats
from vanelock.input.schema.study import Study
from vanelock.mesh import Part, VaneDimensions
from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, STUCK, Response, StaticBounds
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.pipeline.step import Stages
from vanelock.quantities import warnings
from vanelock.quantities.case_result import CaseResult
from vanelock.rom import Contacts
from vanelock.stages.matrices.gather import gathered
from vanelock.stages.parts.load_lines import load_lines
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.responses import on_inertia, static_bounds_step
from vanelock.stages.response.summary import Peak

MOST = 300
"""Contacts up to which the loads that static friction may hold are looked for without being asked:
dense programmes, some minutes for so many."""
_OPEN_SHARE = 0.1
"""Of a joint's contacts that the limits hold closed, how many may be open at rest."""
_RANGE = 0.01
"""Of a joint's load at rest, relative to that load, from which it is worth a line."""
_NONE = 1e-3
"""Of a joint's load at rest, what is written as none."""
_REDUCTION = 0.01
"""Estimated relative error of a natural frequency by reductions, above which it is reported."""
_HARMONICS = 0.1
"""Motion of the contacts by harmonics beyond the band, over that by the first."""
_SPEEDS = (0.05, 5e4)
"""Frequency of the mode of interest times the part's size, m/s: waves in solids travel at up to
12,000 m/s, and thin walls vibrate at some ten thousandths of that over their length."""
_TENTH = 0.1
"""Of a part's least extent, what its displacements must stay below to be small."""
_RELIEVED = 1e-6
"""Of the static load, what inertia bears from which it is worth a line."""
_LOOSE = (
    "at rest a part is held by no closed contact: where it lies, and so its response, is "
    "NOT DETERMINED"
)
"""What is to be known where nothing presses a loose part."""


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
    yield from _at_rest(static, loose)
    if on_inertia(system) >= _RELIEVED:
        yield (
            "static loads do not balance each other, and nothing holds the structure: at rest the "
            "inertia of a rigid acceleration balances them"
        )
    yield from warnings.alike(limits.mac)
    yield from _reduced(limits, float(response.frequency.max()))
    if isinstance(given, Study):
        vane = result.parts[0]
        nodes, points = vane.points, result.places.points
        small = _thin(given, vane)
    else:
        pieces = [stages.get(planned.part(name, 0)) for name in planned.structure.names]
        nodes = np.concatenate([np.empty((0, 3)), *(piece.positions for piece in pieces)])
        points, small = None, _tenth(nodes)
    yield from _implausible(limits.stuck_frequency, nodes)
    closed = contacts.always_closed or tuple(dict.fromkeys(contacts.joints))
    yield from _open_at_rest(static, contacts.joints, closed)
    if peak is not None:
        if is_first and held and not contacts.elements and "bounds" not in planned.analyses:
            bounds = None
            if contacts.count <= MOST:
                friction = given.response.friction
                bounds = stages.get(static_bounds_step(friction, *planned.preload.needs))
            yield from _static_friction(bounds, contacts.joints, response, peak)
        if isinstance(given, Study) and given.mesh.correction != "none":
            closed = contacts.always_closed
            yield from _corrected(response, peak, contacts.joints, closed)
        yield from _large(response, peak, *small, points)
        yield from _beyond_band(response, peak, limits.band)
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
    return _tenth(vane.points)


def _reduced(limits: Limits, highest: float) -> list[str]:
    """Whether the reductions miss natural frequencies up to the `highest` of the response, Hz."""
    worst = 0.0
    for hertz, errors, mode in (
        (limits.free, limits.free_error, limits.free_mode),
        (limits.stuck, limits.stuck_error, limits.stuck_mode),
    ):
        counts = (hertz <= highest) | (np.arange(len(hertz)) == mode)
        worst = max(worst, float(np.nanmax(errors[counts], initial=0.0)))
    if worst <= _REDUCTION:
        return []
    far = f"up to an estimated {100 * worst:.2g} %" if worst < 1 else "more than can be estimated"
    return [
        "too few modes are kept: the reduction raises natural frequencies of the range by "
        f"{far}; keep more, or give an accuracy instead"
    ]


def _at_rest(static: Response, loose: bool) -> list[str]:
    """Whether the state at rest is known: solved, and no part `loose`."""
    lines = [_LOOSE] if loose else []
    if not static.converged.all():
        lines.append(
            f"the state at rest DID NOT CONVERGE (residual {static.residual.max():.1e}): its "
            "forces, and all results at rest, are not to be used"
        )
    return lines


def _open_at_rest(static: Response, joints: Sequence[str], held: Iterable[str]) -> list[str]:
    """Joints `held` closed in the linear limits whose contacts are open at rest."""
    if not static.converged.all():
        return []
    lines = []
    for name in held:
        own = np.array([joint == name for joint in joints], bool)
        count, still = int(own.sum()), int((static.state[0, own] == OPEN).sum())
        if still > _OPEN_SHARE * count:
            lines.append(
                f"{still} of {count} contacts of {name} are open at rest: the linear limits, which "
                "hold them closed, and all that is compared with them mean nothing"
            )
    return lines


def _corrected(
    response: Response, peak: Peak, joints: Sequence[str], held: Iterable[str]
) -> list[str]:
    """Joints `held` whose contacts move at the peak, where what meshes add is taken off."""
    lines = []
    for name in held:
        own = np.array([joint == name for joint in joints], bool)
        moving = int((response.state[peak.point, own] != STUCK).sum())
        if moving > _OPEN_SHARE * own.sum():
            lines.append(
                f"{moving} of {own.sum()} contacts of {name} slip or open at the peak: "
                "mesh.correction is found with all of them sticking, and may not hold"
            )
    return lines


def _static_friction(
    bounds: StaticBounds | None, joints: Sequence[str], response: Response, peak: Peak
) -> list[str]:
    """Between which loads joints that slip may be held at rest by static friction.

    That of a contact is left open in each direction in which it does not slide. It counts at
    points where contacts slip, whose friction it changes. Bounds of None were not looked for.
    """
    slips, names = np.isin(response.state, (SLIP, SLIP_OPEN)), np.array(joints)
    depends = response.undetermined.any(axis=(1, 2)) & slips.any(axis=1)
    if not depends.any():
        return []
    at_peak = bool(depends[peak.point])
    sliding = slips[peak.point] if at_peak else slips[depends].any(axis=0)
    what = "the peak" if at_peak else f"the curve at {depends.sum()} of {len(depends)} points"
    begin = "static friction of contacts that stick, wholly or in one direction, is not determined"
    lines = []
    for name in dict.fromkeys(names[sliding].tolist()):
        at = f"{begin}, and {what} depends on it: at which loads it can hold {name} at rest was not"
        if bounds is None:
            lines.append(f"{at} looked for, of {len(names)} contacts")
        elif name not in bounds.joints:
            continue
        elif not bounds.converged[row := bounds.joints.index(name)].all():
            lines.append(f"{at} found")
        else:
            low, here, high = bounds.rest_load[row].tolist()
            if high - low > _RANGE * max(here, low):
                most = f"{high:.3g} N a sector" if np.isfinite(high) else "any load"
                most += "" if bounds.proved[row].all() else ", or beyond,"
                least = low if low > _NONE * here else 0
                lines.append(
                    f"{begin}: it can hold {name} at rest at {least:.3g} N to {most} "
                    f"({here:.3g} N if assembled unstressed, as here), and {what} depends on which"
                )
    return lines


def _beyond_band(response: Response, peak: Peak, band: float | None) -> list[str]:
    """Whether harmonics beyond the reduced models' band, Hz, count for something at the peak."""
    motion = np.linalg.norm(
        response.contact[peak.point].reshape(response.harmonics + 1, -1), axis=1
    )
    beyond = np.arange(response.harmonics + 1) * peak.frequency > (band or np.inf)
    if not beyond[2:].any() or not motion[1] > 0:
        return []
    share = float(np.linalg.norm(motion[2:][beyond[2:]]) / motion[1])
    if share <= _HARMONICS:
        return []
    first = int(np.flatnonzero(beyond)[0])
    return [
        f"harmonics from {first} on, beyond the {band:.6g} Hz up to which the reduced models "
        f"answer, are {100 * share:.0f} % of the contacts' motion at the peak: compare with a "
        "wider band"
    ]


def _large(
    response: Response, peak: Peak, length: float, what: str, points: Floats | None
) -> list[str]:
    """Whether the motion at the peak is more than small displacements allow."""
    lines = []
    moved = float(np.linalg.norm(response.amplitude[peak.point], axis=-1).max(initial=0.0))
    if moved > length:
        lines.append(
            f"the amplitude at the peak, {1e3 * moved:.3g} mm, is more than {what}, "
            f"{1e3 * length:.3g} mm: displacements are taken as small, so the answer means nothing"
        )
    if points is None or len(points) < 2 or not np.isfinite(points).all():
        return lines
    spacing = cKDTree(points).query(points, k=2)[0][:, 1]
    contact = response.contact[peak.point]
    slid = 2 * np.linalg.norm([half_peak_to_peak(contact[..., d]) for d in (1, 2)], axis=0)
    if np.any(far := (slid > spacing) & (spacing > 0)):
        worst = int(np.argmax(np.where(far, slid / np.maximum(spacing, 1e-300), 0)))
        lines.append(
            f"contacts slide by up to {1e3 * slid[worst]:.3g} mm in a period at the peak, further "
            f"than to the next node, {1e3 * spacing[worst]:.3g} mm: the pairs that touch are taken "
            "as fixed, so the answer means nothing"
        )
    return lines


def _tenth(points: Floats) -> tuple[float, str]:
    """What displacements of nodes (n, 3), m, must stay below to be small, m, and its name."""
    extent = np.ptp(points, axis=0) if len(points) else np.zeros(1)
    extent = extent[extent > 1e-3 * extent.max()]
    return _TENTH * float(extent.min(initial=np.inf)), "a tenth of the least extent of all nodes"


def _implausible(frequency: float, points: Floats) -> list[str]:
    """Whether a natural frequency, Hz, fits a part with nodes (n, 3), m, of any solid."""
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    speed = frequency * size
    if size == 0 or frequency == 0 or _SPEEDS[0] <= speed <= _SPEEDS[1]:
        return []
    return [
        f"the mode of interest has {frequency:.3g} Hz and the part a size of {size:.3g} m: no "
        "solid vibrates like that: look at the units of coordinates, moduli, densities and "
        "contact stiffness"
    ]
