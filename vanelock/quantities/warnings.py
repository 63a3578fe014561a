"""What to know of a case before its numbers are used: lines for terminal, page and results.

Studies and scenes take them from the same functions, each from the products that show it; where a
sweep jumps, and what the sweep in the other direction reached, is among them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from vanelock.common.arrays import Floats
from vanelock.input.cases.names import words
from vanelock.input.schema.response import ResponseKeys
from vanelock.nonlinear import OPEN, SLIP, SLIP_OPEN, STUCK, Response, StaticBounds
from vanelock.nonlinear.forced_response.response import half_peak_to_peak
from vanelock.stages.response.limits import Limits
from vanelock.stages.response.summary import AGREE, Peak, Summary, Sweep

ALIKE = 0.8
"""Least modal assurance criterion between the mode of interest free and stuck."""
OPEN_SHARE = 0.1
"""Of a joint's contacts that the limits hold closed, how many may be open at rest."""
RANGE = 0.01
"""Of a joint's load at rest, relative to that load, from which it is worth a line."""
NONE = 1e-3
"""Of a joint's load at rest, what is written as none."""
REDUCTION = 0.01
"""Estimated relative error of a natural frequency by reductions, above which it is reported."""
HARMONICS = 0.1
"""Motion of the contacts by harmonics beyond the band, over that by the first."""
SPEEDS = (0.05, 5e4)
"""Frequency of the mode of interest times the part's size, m/s: waves in solids travel at up to
12,000 m/s, and thin walls vibrate at some ten thousandths of that over their length."""
TENTH = 0.1
"""Of a part's least extent, what its displacements must stay below to be small."""
NAMED = 8
"""Cases that a line names."""
SAME = 1e-9
"""Relative difference of peaks below which cases are the same."""
ASIDE = (
    ("campbell.", "stability.", "mistuning."),
    (".fatigue_limit", ".tensile_strength", ".wear_coefficient"),
)
"""How keys begin and end that have their effect elsewhere than in peaks and their bounds."""


FREE = (
    "rigid-body motions are held by nothing: they vibrate without stiffness, are left out at rest, "
    "and response.mode does not count them"
)
"""What is to be known of a structure that moves freely, behind their number."""
RELIEVED = 1e-6
"""Of the static load, what inertia bears from which it is worth a line."""
LOOSE = (
    "at rest a part is held by no closed contact: where it lies, and so its response, is "
    "NOT DETERMINED"
)
"""What is to be known where nothing presses a loose part."""


def of_case(summary: Summary) -> list[str]:
    """All that is to be known of a case, a line each."""
    return [*_doubts(summary), *summary.warnings]


def _doubts(summary: Summary) -> list[str]:
    """Why the peak of a case may not be the largest."""
    lines = []
    if summary.peak is None:
        lines.append("no point converged")
    lines += _lost(summary)
    if summary.peak is not None and summary.peak.at_edge:
        lines.append(
            "the largest point is at the end of the frequency range; a peak may lie beyond"
        )
    return lines


def _lost(summary: Summary) -> list[str]:
    """How many points of a case did not converge, if any."""
    if summary.converged == summary.points:
        return []
    return [
        f"{summary.points - summary.converged} of {summary.points} points DID NOT CONVERGE "
        f"(largest residual {summary.worst:.1e}); they are left out"
    ]


def by_text(cases: Mapping[str, Summary], shown: Callable[[str], str] = words) -> list[str]:
    """Sentences on the cases of a run: each line once, with its cases, named as `shown`."""
    named: dict[str, list[str]] = {}
    for name, found in cases.items():
        for line in of_case(found):
            named.setdefault(line, []).append(shown(name))
    sentences = []
    for line, names in named.items():
        who = "; ".join(names[:NAMED])
        if len(names) > NAMED:
            who += f" and {len(names) - NAMED} more"
        if len(names) == len(cases) > 1:
            who = "all cases"
        sentences.append(f"{who}: {line}.")
    return sentences


def alike(mac: float) -> list[str]:
    """Whether the mode of interest is the same with contacts free and stuck."""
    if mac >= ALIKE:
        return []
    return [
        f"the mode of interest free and the one stuck are alike by MAC {mac:.2f} only: they may be "
        "different modes, and a place between the two means nothing"
    ]


def reduced(limits: Limits, highest: float) -> list[str]:
    """Whether the reductions miss natural frequencies up to the `highest` of the response, Hz."""
    worst = 0.0
    for hertz, errors, mode in (
        (limits.free, limits.free_error, limits.free_mode),
        (limits.stuck, limits.stuck_error, limits.stuck_mode),
    ):
        counts = (hertz <= highest) | (np.arange(len(hertz)) == mode)
        worst = max(worst, float(np.nanmax(errors[counts], initial=0.0)))
    if worst <= REDUCTION:
        return []
    far = f"up to an estimated {100 * worst:.2g} %" if worst < 1 else "more than can be estimated"
    return [
        "too few modes are kept: the reduction raises natural frequencies of the range by "
        f"{far}; keep more, or give an accuracy instead"
    ]


def beside_range(keys: ResponseKeys, limits: Limits) -> list[str]:
    """Whether frequencies are given that hold no mode of interest, from free to stuck."""
    if (asked := keys.frequencies or keys.range) is None:
        return []
    low, high = sorted((limits.free_frequency, limits.stuck_frequency))
    if min(asked) <= high and low <= max(asked):
        return []
    name = "range" if keys.frequencies is None else "frequencies"
    return [
        f"response.{name}: {min(asked):.6g} to {max(asked):.6g} Hz hold no mode of interest: "
        f"mode {keys.mode} lies at {limits.free_frequency:.6g} Hz with contacts free, "
        f"{limits.stuck_frequency:.6g} Hz stuck"
    ]


def at_rest(static: Response, loose: bool) -> list[str]:
    """Whether the state at rest is known: solved, and no part `loose`."""
    lines = [LOOSE] if loose else []
    if not static.converged.all():
        lines.append(
            f"the state at rest DID NOT CONVERGE (residual {static.residual.max():.1e}): its "
            "forces, and all results at rest, are not to be used"
        )
    return lines


def relieved(share: float) -> list[str]:
    """Whether inertia bears a part of the static load, relative size `share`."""
    if share < RELIEVED:
        return []
    return [
        "static loads do not balance each other, and nothing holds the structure: at rest the "
        "inertia of a rigid acceleration balances them"
    ]


def open_at_rest(static: Response, joints: Sequence[str], held: Iterable[str]) -> list[str]:
    """Joints `held` closed in the linear limits whose contacts are open at rest."""
    if not static.converged.all():
        return []
    lines = []
    for name in held:
        own = np.array([joint == name for joint in joints], bool)
        count, still = int(own.sum()), int((static.state[0, own] == OPEN).sum())
        if still > OPEN_SHARE * count:
            lines.append(
                f"{still} of {count} contacts of {name} are open at rest: the linear limits, which "
                "hold them closed, and all that is compared with them mean nothing"
            )
    return lines


def corrected(
    response: Response, peak: Peak, joints: Sequence[str], held: Iterable[str]
) -> list[str]:
    """Joints `held` whose contacts move at the peak, where what meshes add is taken off."""
    lines = []
    for name in held:
        own = np.array([joint == name for joint in joints], bool)
        moving = int((response.state[peak.point, own] != STUCK).sum())
        if moving > OPEN_SHARE * own.sum():
            lines.append(
                f"{moving} of {own.sum()} contacts of {name} slip or open at the peak: "
                "mesh.correction is found with all of them sticking, and may not hold"
            )
    return lines


def static_friction(
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
            if high - low > RANGE * max(here, low):
                most = f"{high:.3g} N a sector" if np.isfinite(high) else "any load"
                most += "" if bounds.proved[row].all() else ", or beyond,"
                lines.append(
                    f"{begin}: it can hold {name} at rest at {low if low > NONE * here else 0:.3g} "
                    f"N to {most} ({here:.3g} N if assembled unstressed, as here), and {what} "
                    "depends on which"
                )
    return lines


def beyond_band(response: Response, peak: Peak, band: float | None) -> list[str]:
    """Whether harmonics beyond the reduced models' band, Hz, count for something at the peak."""
    motion = np.linalg.norm(
        response.contact[peak.point].reshape(response.harmonics + 1, -1), axis=1
    )
    beyond = np.arange(response.harmonics + 1) * peak.frequency > (band or np.inf)
    if not beyond[2:].any() or not motion[1] > 0:
        return []
    share = float(np.linalg.norm(motion[2:][beyond[2:]]) / motion[1])
    if share <= HARMONICS:
        return []
    first = int(np.flatnonzero(beyond)[0])
    return [
        f"harmonics from {first} on, beyond the {band:.6g} Hz up to which the reduced models "
        f"answer, are {100 * share:.0f} % of the contacts' motion at the peak: compare with a "
        "wider band"
    ]


def large(
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


def tenth(points: Floats) -> tuple[float, str]:
    """What displacements of nodes (n, 3), m, must stay below to be small, m, and its name."""
    extent = np.ptp(points, axis=0) if len(points) else np.zeros(1)
    extent = extent[extent > 1e-3 * extent.max()]
    return TENTH * float(extent.min(initial=np.inf)), "a tenth of the least extent of all nodes"


def implausible(frequency: float, points: Floats) -> list[str]:
    """Whether a natural frequency, Hz, fits a part with nodes (n, 3), m, of any solid."""
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    speed = frequency * size
    if size == 0 or frequency == 0 or SPEEDS[0] <= speed <= SPEEDS[1]:
        return []
    return [
        f"the mode of interest has {frequency:.3g} Hz and the part a size of {size:.3g} m: no "
        "solid vibrates like that: look at the units of coordinates, moduli, densities and "
        "contact stiffness"
    ]


def without_effect(cases: Sequence[tuple[Mapping[str, float | str], Summary]]) -> list[str]:
    """Swept keys whose values change nothing: cases that differ in one alone are the same."""
    lines = []
    for key in cases[0][0] if cases else ():
        if key.startswith(ASIDE[0]) or key.endswith(ASIDE[1]):
            continue
        groups: dict[tuple[object, ...], list[Summary]] = {}
        for values, found in cases:
            others = tuple(value for name, value in values.items() if name != key)
            groups.setdefault(others, []).append(found)
        pairs = [group for group in groups.values() if len(group) > 1]
        if pairs and all(_same(group[0], each) for group in pairs for each in group[1:]):
            lines.append(f"{key} has no effect: cases that differ in it alone are the same")
    return lines


def _same(one: Summary, other: Summary) -> bool:
    if one.peak is None or other.peak is None or one.points != other.points:
        return False
    a, b = (
        [(peak.amplitude, peak.frequency) for peak in (c.peak, c.lowest, c.highest) if peak]
        for c in (one, other)
    )
    return len(a) == len(b) and bool(np.allclose(a, b, rtol=SAME, atol=0))


MOST = 4
"""Jumps of a sweep that are named, the largest ones."""


def notes(sweeps: Sequence[Sweep]) -> Iterator[str]:
    """What to know of a case's several solutions, a line each."""
    for sweep in sweeps:
        if not sweep.jumps:
            continue
        largest = sorted(sweep.jumps, key=lambda jump: -abs(np.diff(jump.amplitude)[0]))[:MOST]
        text = "; ".join(
            f"from {1e6 * jump.amplitude[0]:.4g} to {1e6 * jump.amplitude[1]:.4g} um between "
            f"{min(jump.frequency):.6g} and {max(jump.frequency):.6g} Hz"
            for jump in sorted(largest, key=lambda jump: jump.frequency)
        )
        more = len(sweep.jumps) - len(largest)
        rest = f"; and {more} smaller {'jump' if more == 1 else 'jumps'}" if more else ""
        way = f"sweeping {sweep.direction}"
        if sweep.direction == "both":
            way = "the curve of the highest solutions found"
        yield f"{way} JUMPS {text}{rest}"
    if len(sweeps) > 1:
        yield from _compared(*sweeps)
    elif sweeps and sweeps[0].jumps:
        yield (
            "higher solutions were looked for from every jump and in both directions"
            if sweeps[0].direction == "both"
            else "other solutions were not looked for, and may reach higher: "
            'response.direction = "both"'
        )


def _compared(higher: Sweep, lower: Sweep) -> Iterator[str]:
    """Which of two sweeps the peak is of, where they differ."""
    if higher.peak is None or lower.peak is None:
        yield f"no point converged sweeping {lower.direction}"
        return
    a, b = 1e6 * higher.peak.amplitude, 1e6 * lower.peak.amplitude
    if abs(a - b) > AGREE * a or higher.jumps or lower.jumps:
        yield (
            f"the peak is that of the sweep {higher.direction}; sweeping {lower.direction} "
            f"reaches {b:.4g} um at {lower.peak.frequency:.6g} Hz"
        )
