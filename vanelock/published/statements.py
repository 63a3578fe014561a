"""What the published study states, figure by figure, and whether this run agrees.

A statement agrees where every number behind it says so, partly where some do. Why it does not is
decided by numbers of the same run.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vanelock.common.cyclic import folded
from vanelock.input.schema.published import Campaign
from vanelock.published.evidence import SAME, Evidence, known, share, slight
from vanelock.published.maps.plane import Method
from vanelock.published.sheets import case_of, case_words

Agrees = Literal["yes", "partly", "no"]

ROUND_OFF = 1e-6
"""Relative difference of responses that are called coincident."""
SLIGHT, NONE = 0.1, 0.01
"""Relative change of a peak that is slight, and that is none."""
SMALL = 0.1
"""Share of the friction work that is small."""


@dataclass(frozen=True)
class Statement:
    """A statement of the published study beside what was found.

    Attributes
    ----------
    figure : str
    says : str
        In the words of the study, shortened.
    found : str
        Numbers of this run.
    agrees : {"yes", "partly", "no"}
    why : str
        What the difference comes from, where there is one.
    cases : tuple of str
        Coupled cases whose peaks it is judged by.
    waves : str
        Whether the waves of these are stable, where stability is asked for.
    """

    figure: str
    says: str
    found: str
    agrees: Agrees
    why: str = ""
    cases: tuple[str, ...] = ()
    waves: str = ""


def agrees(*holds: bool) -> Agrees:
    """Whether all, some or none hold."""
    return "yes" if all(holds) else "partly" if any(holds) else "no"


def statements(found: Evidence) -> tuple[Statement, ...]:
    """All statements, in the order of the figures."""
    stated = (state(found) for state in STATEMENTS)
    return tuple(replace(each, waves=waves_of(found, each.cases)) for each in stated)


def waves_of(e: Evidence, cases: Sequence[str]) -> str:
    """How many of some cases' waves are stable, in words."""
    found = [e.summaries[name].wave for name in cases]
    verdicts = [wave.verdict for wave in found if wave is not None]
    counts = {word: verdicts.count(word) for word in ("stable", "unstable", "undecided")}
    present = {word: count for word, count in counts.items() if count}
    if len(present) == 1:
        return next(iter(present))
    return ", ".join(f"{count} {word}" for word, count in present.items())


def campbell(e: Evidence) -> Statement:
    """Figure 4."""
    order = abs(e.engine_order)
    rpm = [60 * f / order for f in (e.limits.free_frequency, e.limits.stuck_frequency)]
    k, N = e.limits.nodal_diameter, e.limits.sectors
    at = 60 * e.frequency("reference") / order
    return Statement(
        "4",
        f"mode {e.limits.free_mode + 1} of nodal diameter {folded(k, N)} is excited by EO {order}",
        f"crosses EO {order} at {rpm[0]:.0f} rpm free and {rpm[1]:.0f} rpm stuck; "
        f"response with friction peaks at {at:.0f} rpm",
        agrees(folded(k, N) == folded(order, N), min(rpm) <= 1.001 * at <= 1.001**2 * max(rpm)),
        cases=("reference",),
    )


def hysteresis(e: Evidence) -> Statement:
    """Figure 8."""
    texts = [f"{loop.title} {1e6 * loop.energy:.3g} µJ" for loop in e.conditions]
    worst = max(abs(loop.energy / loop.marched - 1) for loop in e.conditions)
    opens = [loop.opened > 0 for loop in e.conditions]
    return Statement(
        "8",
        "three shapes of loops: in phase, with partial lift-off, out of phase",
        f"{', '.join(texts)} a cycle; open {100 * e.conditions[1].opened:.0f} % of the period with "
        f"lift-off; energies within {worst:.0e} of the element marched step by step",
        agrees(opens == [False, True, False], worst < 1e-4),
    )


def hooks_alone(e: Evidence) -> Statement:
    """Figure 10."""
    d = e.hooks
    return Statement(
        "10",
        "hooks alone: nonlinear response coincides with the linear free one, no slip",
        f"differs by {d.vibration:.0e} of the peak; {d.slipping} hook contacts slip",
        agrees(d.vibration < ROUND_OFF, d.slipping == 0),
    )


def stiffer(e: Evidence) -> Statement:
    """Figure 11, the frequency."""
    return Statement(
        "11",
        "all joints stuck: resonance higher than with the interlock free",
        f"{e.limits.free_frequency:.2f} to {e.limits.stuck_frequency:.2f} Hz, "
        f"{100 * e.limits.rise:+.1f} %",
        agrees(e.limits.rise > 0),
    )


def coincident(e: Evidence) -> Statement:
    """Figure 11, coupled and uncoupled."""
    worst = max(d.vibration for d in e.stuck.values())
    means = ", ".join(f"{d.mean:.0e} ({name})" for name, d in e.stuck.items())
    slipping = max(d.slipping for d in e.stuck.values())
    relaxed = any(d.mean > SAME for d in e.stuck.values())
    return Statement(
        "11",
        "all stuck, small load: coupled and uncoupled responses coincide",
        f"at {e.small:g} of the load: harmonics h >= 1 differ by {worst:.0e}, mean contact forces "
        f"by {means}; {slipping} contacts slip",
        agrees(worst < ROUND_OFF, slipping == 0),
        "contacts that slid when assembled rest at the bound of friction, and vibration relaxes "
        "their mean force: harmonic 0 alone differs"
        if relaxed
        else "",
    )


def friction(e: Evidence) -> Statement:
    """Figure 12."""
    return _falling(e, "12", "mu", [case_of(e.plan, mu=mu) for mu in _campaign(e).mu])


def interference(e: Evidence) -> Statement:
    """Figure 14."""
    campaign = _campaign(e)
    names = [
        case_of(e.plan, mu=campaign.mu[-1], interference=value) for value in campaign.interference
    ]
    return _falling(e, "14", "interference", names)


def harmonics(e: Evidence) -> Statement:
    """Figure 13."""
    orders = _campaign(e).harmonics
    names = [case_of(e.plan, harmonics=h) for h in orders]
    size = [e.amplitude(name) for name in names]
    first, last = size[1] / size[0] - 1, size[-1] / size[-2] - 1
    plane = e.planes["interference"]
    steps = [slight(plane, orders[0], orders[1], SLIGHT)]
    steps += [slight(plane, a, b, NONE) for a, b in itertools.pairwise(orders[1:])]
    holds = np.logical_and.reduce(steps)
    return Statement(
        "13",
        "slight increase of the peak from one to three harmonics, none from three to five",
        f"{first:+.1%} from H = {orders[0]} to {orders[1]}, {last:+.2%} from {orders[-2]} to "
        f"{orders[-1]}; within {SLIGHT:.0%} and {NONE:.0%} on {share(plane, holds):.0%} of the map",
        agrees(0 <= first < SLIGHT, abs(last) < NONE),
        ""
        if holds[known(plane)].all()
        else "where contacts lift off for part of the period, near the optimum friction, "
        "one harmonic does not carry the impact",
        tuple(names),
    )


def costs_harmonics(e: Evidence) -> Statement:
    """Calculation time against harmonics."""
    plane, orders = e.planes["interference"], _campaign(e).harmonics
    spent = [_seconds(e, Method(h)) for h in orders]
    texts = [f"H = {h}: {s / spent[0]:.1f}" for h, s in zip(orders, spent, strict=True)]
    return Statement(
        "13, text",
        "calculation time increases fast with the number of harmonics",
        f"{'; '.join(texts)} times that of one harmonic, {1e3 * spent[0]:.0f} ms a response of "
        f"{plane.points[..., 0].mean():.0f} frequencies",
        agrees(spent[-1] > len(spent) * spent[0]),
    )


def costs_coupling(e: Evidence) -> Statement:
    """Calculation time of the coupled method."""
    coupled, other = _seconds(e, Method(1)), _seconds(e, Method(1, "uncoupled"))
    return Statement(
        "text",
        "the coupled method takes more calculation time",
        f"{coupled / other:.2f} times the uncoupled one's at H = 1",
        agrees(coupled > 1.1 * other),
        ""
        if coupled > 1.1 * other
        else "coupling adds one real unknown to the two of each contact direction, and what does "
        "not depend on the state is prepared once for both",
    )


def hooks_share(e: Evidence) -> Statement:
    """The hooks' part of the damping."""
    names = [case_of(e.plan, mu=mu) for mu in _campaign(e).mu]
    shares = [1 - e.summaries[name].friction_share for name in names]
    worst = max((x for x in shares if x == x), default=0.0)
    return Statement(
        "10, text",
        "hooks contribute little to the damping, the interlock most of it",
        f"hooks take at most {worst:.1%} of the friction work at the peaks"
        if worst > 0
        else "no hook contact slips at any of the peaks",
        agrees(worst < SMALL),
        cases=tuple(names),
    )


def below_stuck(e: Evidence) -> Statement:
    """Figures 12 and 14: below the response of full stick."""
    names = [name for sheet in ("friction", "interference") for name in e.plan.sheets[sheet].cases]
    coupled = [n for n in names if e.plan.study(n).response.coupling == "coupled"]
    ratios = [e.summaries[name].of_stuck for name in coupled]
    return Statement(
        "12, 14",
        "responses with friction are lower than the fully stuck one",
        f"{min(ratios):.3g} to {max(ratios):.3g} of it",
        agrees(*(ratio < 1 for ratio in ratios)),
        cases=tuple(coupled),
    )


def uncoupled_friction(e: Evidence) -> Statement:
    """Figure 15, the normal force varying."""
    return _against(e, "15", "friction", "uncoupled")


def constant_friction(e: Evidence) -> Statement:
    """Figure 15, friction bounded by the load at rest."""
    return _against(e, "15", "friction", "constant-load")


def uncoupled_interference(e: Evidence) -> Statement:
    """Figure 16, the normal force varying."""
    return _against(e, "16", "interference", "uncoupled")


def constant_interference(e: Evidence) -> Statement:
    """Figure 16, friction bounded by the load at rest."""
    return _against(e, "16", "interference", "constant-load")


def conservative(e: Evidence) -> Statement:
    """The conclusion."""
    plane = e.planes["interference"]
    coupled = plane.of(Method(1))[0]
    safe = [
        share(plane, plane.of(Method(1, other))[0] < coupled)
        for other in ("uncoupled", "constant-load")
    ]
    return Statement(
        "15, 16, text",
        "the coupled method is the more conservative one",
        f"its peak is the higher one on {safe[0]:.0%} of the map (uncoupled) and {safe[1]:.0%} "
        "(constant-load)",
        agrees(*(x > 0.999 for x in safe)) if min(safe) > 0.999 else agrees(safe[0] > 0.5, False),
        ""
        if min(safe) > 0.999
        else "beyond the friction and interference that damp best the "
        "order turns round; friction bounded by the load at rest misses what lift-off adds to the "
        "mean load",
    )


STATEMENTS: tuple[Callable[[Evidence], Statement], ...] = (
    campbell,
    hysteresis,
    hooks_alone,
    hooks_share,
    stiffer,
    coincident,
    below_stuck,
    friction,
    harmonics,
    costs_harmonics,
    interference,
    uncoupled_friction,
    constant_friction,
    uncoupled_interference,
    constant_interference,
    conservative,
    costs_coupling,
)


def _campaign(e: Evidence) -> Campaign:
    campaign = e.plan.base.campaign
    assert campaign is not None
    return campaign


def _seconds(e: Evidence, method: Method) -> float:
    """Median processor time of a response, s."""
    plane = e.planes["interference"]
    return float(np.median(plane.seconds[:, :, plane.methods.index(method.name)]))


def _falling(e: Evidence, figure: str, name: str, cases: Sequence[str]) -> Statement:
    size = [e.amplitude(case) for case in cases]
    ratio = [a / e.linear["free"].amplitude for a in size]
    holds = [b < a for a, b in itertools.pairwise(size)]
    words = {"mu": "friction coefficient", "interference": "interlock interference"}[name]
    why = ""
    if not all(holds):
        why = f"beyond the optimum {words} the contacts stick more and dissipate less"
    return Statement(
        figure,
        f"the peak falls as the {words} grows",
        f"{', '.join(f'{x:.3f}' for x in ratio)} of the linear free peak",
        agrees(*holds),
        why,
        tuple(cases),
    )


def _by_mean_load(e: Evidence, case: str) -> str:
    """Why friction bounded by the load at rest peaks higher, at a coupled case."""
    rest, top = e.mean_load(case)
    text = (
        f"contacts lift off, so their mean load grows from {rest:.3g} N at rest to {top:.3g} N a "
        f"pair at the coupled peak ({case_words(case)}), and friction with it; held at rest it "
        "dissipates less"
    )
    again = e.at_mean.get(case, float("nan")) / e.amplitude(case)
    if np.isfinite(again):
        text += (
            f". With the interference that gives that mean at rest the peak is {again:.2f} times "
            "the coupled one"
        )
    return text


def _against(e: Evidence, figure: str, sheet: str, coupling: str) -> Statement:
    """Peaks by another coupling against the coupled ones of a sheet."""
    names = list(e.plan.sheets[sheet].cases)
    coupled = [n for n in names if e.plan.study(n).response.coupling == "coupled"]
    others = [n for n in names if e.plan.study(n).response.coupling == coupling]
    shift = [e.frequency(b) - e.frequency(a) for a, b in zip(coupled, others, strict=True)]
    ratio = [e.amplitude(b) / e.amplitude(a) for a, b in zip(coupled, others, strict=True)]
    why = ""
    if any(r >= 1 for r in ratio):
        worst = coupled[int(np.nanargmax(ratio))]
        why = (
            _by_mean_load(e, worst)
            if coupling == "constant-load"
            else "beyond the optimum friction the order turns round, see the map"
        )
    return Statement(
        figure,
        f"{coupling} peaks lie at higher frequency and lower amplitude than coupled ones",
        f"shifted by {', '.join(f'{x:+.2f}' for x in shift)} Hz, amplitudes times "
        f"{', '.join(f'{x:.2f}' for x in ratio)}",
        agrees(*(x > 0 for x in shift), *(x < 1 for x in ratio)),
        why,
        tuple(coupled),
    )
