"""What to know of whatever was asked for beyond the responses of a case, in words."""

from collections.abc import Sequence

import numpy as np

from vanelock.nonlinear.following.wear.wear_history import DONE, PRELOAD
from vanelock.stages.assessment.bounds import HIGH, LOW, NOMINAL, BoundedPeak
from vanelock.stages.assessment.damped_modes import FollowedMode
from vanelock.stages.assessment.unlike import UnlikeRings
from vanelock.stages.assessment.wear import WornCase
from vanelock.stages.response.summary import Peak, Summary

APART = 0.01
"""Relative difference of a peak from that of the curve from which it is worth a line."""
AUDIT = 1e-6
"""Residual of an independent check from which it is worth a line."""


def bounds(found: BoundedPeak | None, peak: Peak) -> list[str]:
    """What keeps bounds over static friction from being taken as they are, beside a peak."""
    if found is None:
        return []
    if found.found is None:
        return [f"no bounds of the peak over static friction: {found.reason}"]
    ends = [end for i, end in ((LOW, "least"), (HIGH, "largest")) if not found.found.converged[i]]
    lines = [f"the {end} peak over static friction DID NOT CONVERGE" for end in ends]
    if (worst := float(found.residual.max())) > AUDIT:
        lines.append(f"peaks over static friction miss an independent check by {worst:.1e}")
    nominal = found.peak(NOMINAL)
    if nominal is not None and abs(nominal.amplitude - peak.amplitude) > APART * peak.amplitude:
        here, there = (
            f"{1e6 * each.amplitude:.4g} um at {each.frequency:.6g} Hz" for each in (nominal, peak)
        )
        lines.append(
            "the bounds over static friction are of ANOTHER PEAK than the curve's: as assembled "
            f"theirs is {here}, the curve's {there}"
        )
    return lines


def wave(found: Summary) -> list[str]:
    """Whether the ring leaves the wave at the peak."""
    verdict, peak = found.wave, found.peak
    if verdict is None or peak is None or verdict.verdict == "stable":
        return []
    beside = [f"{f:.4g}" for f in verdict.frequencies if abs(f - peak.frequency) > 1e-3 * f]
    gauge = f"; a gauge shows {', '.join(beside)} Hz beside {peak.frequency:.4g} Hz"
    if verdict.verdict == "unstable":
        return [
            "the periodic wave at the peak is UNSTABLE, the ring does not settle on it: a "
            f"disturbance of nodal diameter {verdict.diameter} grows by a factor "
            f"{verdict.growth:.3g} per cycle{gauge if beside else ''}{verdict.followed}"
        ]
    growth = f", growth {verdict.growth:.3g} per cycle" if verdict.growth > 0 else ""
    return [
        f"the stability of the periodic wave at the peak is UNDECIDED: {verdict.reason}{growth}"
    ]


def damped_modes(found: Sequence[FollowedMode]) -> list[str]:
    """Which damped modes were not followed to gross slip, and which waves grow from rest."""
    lines = []
    for each in found:
        called = f"mode {each.number} of nodal diameter {each.nodal_diameter}"
        if each.mode is None:
            lines.append(f"{called} was NOT FOLLOWED: {each.reason}")
        elif each.mode.ended:
            lines.append(f"{called} was not followed to gross slip: {each.mode.ended}")
        if each.driven is not None and each.driven.linear_damping < 0:
            ratio = 100 * each.driven.linear_damping
            lines.append(f"{called} FLUTTERS: with the air its damping ratio is {ratio:.2g} %")
    return lines


def wear(found: WornCase | None) -> list[str]:
    """What keeps wear over cycles from being taken as it is."""
    if found is None:
        return []
    if (history := found.history) is None:
        return [f"no wear over cycles: {found.reason}"]
    lines = []
    if history.status == PRELOAD:
        lines.append(f"wear opens a joint at rest after {history.cycles_to_loss:.3g} cycles")
    elif history.status != DONE:
        at = f"{history.cycles[-1]:.3g} cycles"
        lines.append(f"wear is known up to {at} only: no vibration was found beyond")
    if history.jump.any():
        at = ", ".join(f"{each:.3g}" for each in history.cycles[history.jump][:3])
        lines.append(f"the vibration JUMPS while joints wear, at {at} cycles")
    for i in np.flatnonzero(np.isfinite(history.higher_amplitude)):
        higher, followed = 1e6 * history.higher_amplitude[i], 1e6 * history.amplitude[i]
        lines.append(
            f"after {history.cycles[i]:.3g} cycles of wear ANOTHER PEAK is higher, {higher:.4g} um "
            f"at {history.higher_frequency[i]:.6g} Hz, than the one that was followed, "
            f"{followed:.4g} um"
        )
    return lines


def unlike(found: UnlikeRings | None, peak: Peak) -> list[str]:
    """What keeps rings of unlike segments from being taken as they are, beside a peak."""
    if found is None:
        return []
    rings, lines = len(found.largest), list[str]()
    if lost := int(found.lost.sum()):
        lines.append(
            f"{lost} of {found.points.sum()} points of rings of unlike segments DID NOT CONVERGE: "
            "a segment may vibrate more than is shown"
        )
    if edge := int(found.at_edge.sum()):
        lines.append(
            f"{edge} of {rings} rings of unlike segments vibrate most at the end of the frequency "
            "range: a peak may lie beyond"
        )
    alike = float(found.alike[0])
    if not abs(alike - peak.amplitude) <= APART * peak.amplitude:
        lines.append(
            f"rings of unlike segments are compared with {1e6 * alike:.4g} um of alike ones in "
            f"their range, while the peak of the curve is {1e6 * peak.amplitude:.4g} um"
        )
    return lines
