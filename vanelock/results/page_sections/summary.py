"""The first section of a run's page: the answers, and what to be careful about."""

from dataclasses import replace

import numpy as np

from vanelock.common.tables import Table
from vanelock.input.cases.names import fixed, words
from vanelock.input.cases.values import ring_of
from vanelock.input.schema.study import Study
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.warnings import by_text, without_effect
from vanelock.report import Answer, Answers, Section, Text
from vanelock.report.blocks import Block
from vanelock.results.case_table import case_row, case_table
from vanelock.results.page_sections.curves import response_plot
from vanelock.results.page_sections.fatigue import assumed, case_flag
from vanelock.results.page_sections.wear import shares
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.accuracy.amplitude_errors import amplitude_error
from vanelock.stages.accuracy.evidence import amplitude_errors_of
from vanelock.stages.accuracy.neglected import neglected_harmonics_step
from vanelock.stages.response.summary import Summary

HCF = "HCF safety factor"
MOST_FAILED = 5
"""Failed cases that the summary names."""
SAME = 1e-3
"""Relative width of bounds below which they are one."""
APART = ("harmonics", "mu", "x", "converged", "seconds")
"""Columns of the cases that other sections have."""


def summary(run: RunResult) -> Section:
    """Answers, warnings and a line for each case."""
    blocks: list[Block] = [Answers(tuple(_answers_of(run))), response_plot(run)]
    warned = warnings(run)
    if warned:
        blocks.append(Text("**Be careful.** " + "\n\n".join(warned)))
    return Section("Summary", [*blocks, cases(run)], id="summary")


def _answers_of(run: RunResult) -> list[Answer]:
    """The run's answers, most wanted first."""
    most = run.largest
    if most is None or most.peak is None:
        return [Answer("Largest peak", "none", "no point of any case converged", "bad")]
    many = len(run.known) > 1
    case = f"{words(most.case)}, " if many else ""
    between = _between(run, most)
    found = [
        Answer(
            "Largest peak" if many else "Peak",
            f"{1e6 * most.peak.amplitude:.3g} µm",
            f"{between}{case}{run.monitor.name}, half the peak-to-peak"
            + (f"; {_of_linear(most)}" if _of_linear(most) else "")
            + ("" if most.peak.at_edge else _error(run, most)),
            "warn" if most.peak.at_edge or between else "",
        ),
        Answer("Frequency", f"{most.peak.frequency:.2f} Hz", _speed(run, most)),
    ]
    for analysis in run.analyses:
        found += analysis.answers(run.cases[most.case])
    if run.main is not None:
        found += _of_case(run, run.main)
    return [*found, *best_friction(run)]


def _between(run: RunResult, most: Summary) -> str:
    """How far static friction may move the peak."""
    main = run.main
    if most.lowest is None or most.highest is None or main is None:
        return ""
    low, high = 1e6 * most.lowest.amplitude, 1e6 * most.highest.amplitude
    if high <= (1 + SAME) * low:
        return ""
    sticks = main.top.undetermined[0].any(axis=1)
    joints = " and ".join(dict.fromkeys(np.array(main.places.joint)[sticks].tolist()))
    return (
        f"**between {low:.3g} and {high:.3g} µm**, as static friction in {joints} is not "
        "determined. "
    )


def _of_linear(most: Summary) -> str:
    over = (
        f"{value:.2f} of the linear peak with contacts {which}"
        for which, value in (("free", most.of_free), ("stuck", most.of_stuck))
        if np.isfinite(value)
    )
    return "; ".join(over)


def _error(run: RunResult, most: Summary) -> str:
    """What the peak's estimated error is, or what mesh and harmonics leave in doubt."""
    if most.case not in run.errors:
        doubt, planned = _doubt(run, most), run.cases[most.case].planned
        get = run.stages.get
        if doubt and (own := amplitude_errors_of(planned)) is not None:
            doubt = amplitude_error(get(own), doubt)
        missed = get(neglected_harmonics_step(planned)).amplitude
        shown = {"the mesh": doubt, "neglected harmonics": np.nan_to_num(missed)}
        texts = [f"{100 * size:.2g} % by {name}" for name, size in shown.items() if size]
        return f"; ±{' and '.join(texts)}" if texts else ""
    errors = run.errors[most.case][0]
    text = f"; estimated error {100 * errors.total[0]:.2g} %, asked for {100 * errors.accuracy:g} %"
    apart = [each for each in errors.sources if each not in errors.counted]
    return text + "".join(
        f", and {100 * each.amplitude:.2g} % of the {each.name}, which is given" for each in apart
    )


def _doubt(run: RunResult, most: Summary) -> float:
    """Of the frequencies of interest, what the meshes leave in doubt; 0 where it is not known."""
    limits = run.stages.get(run.cases[most.case].planned.linear.limits)
    return DOUBT * float(np.nan_to_num([limits.free_lowered, limits.stuck_lowered]).max())


def _speed(run: RunResult, most: Summary) -> str:
    assert most.peak is not None
    (sectors, order), texts = ring_of(run.cases[most.case].planned.case.given), []
    doubt = 0.0 if most.case in run.errors else _doubt(run, most)
    if doubt and not most.peak.at_edge:
        texts.append(f"±{100 * doubt:.2g} % by the mesh")
    if sectors > 1 and order:
        speed = 60 * most.peak.frequency / abs(order)
        texts.append(f"{speed:,.0f} rpm at engine order {abs(order)}")
    if 0 <= most.position <= 1:
        texts.append(f"{100 * most.position:.0f} % of the shift from free to stuck")
    return "; ".join(texts)


def _of_case(run: RunResult, main: CaseAnswers) -> list[Answer]:
    b = main.balance
    joints = ", ".join(f"{name} {100 * s:.0f} %" for name, s in shares(main).items() if s > 0)
    found = [
        _damping(main),
        Answer(
            "Share of friction",
            f"{100 * b.friction_share:.0f} %",
            f"of the energy dissipated in a cycle: {joints}" if joints else "no contact slips",
        ),
    ]
    if main.margins is None:
        return found
    m = main.margins.governing
    locations = main.margins.locations[m.part]
    least = min(each.stress.governing.reserve for each in (main, *_last_states(main)))
    flag = case_flag(main, least, m.part)
    r, angle, z = locations.coordinates(m.node) if m.node is not None else (0, 0, 0)
    place = f"r {1e3 * r:.1f} mm, {angle:+.2f}°, z {1e3 * z:.1f} mm"
    return [
        *found,
        Answer(
            "Critical stress",
            f"{1e-6 * m.amplitude:.3g} MPa",
            f"alternating, mean {1e-6 * m.mean:.2g} MPa: {m.part}, {m.where} ({place})",
        ),
        _withheld(HCF)
        if main.peak.at_edge
        else Answer(HCF, f"n = {m.reserve:.3g}", _reserve(run, main), flag),
    ]


def _withheld(title: str) -> Answer:
    """In place of an answer that a range without its peak cannot give."""
    note = "the largest point is at the end of the frequency range, and a peak may lie beyond"
    return Answer(title, "withheld", f"{note}: widen response.range", "warn")


def _structure(main: CaseAnswers) -> str:
    ratio = main.planned.case.given.damping.ratio
    return (
        "structure by its matrix, or 0.3 %"
        if ratio is None
        else f"structure alone {100 * ratio:.2g} %"
    )


def _damping(main: CaseAnswers) -> Answer:
    note = _structure(main)
    if main.peak.at_edge:
        note += "; the largest point is no resonance, so this is no more than its order"
    elif np.isfinite(main.bandwidth):
        note += f"; by the half-power bandwidth {100 * main.bandwidth:.2g} %"
    value = f"{100 * main.balance.damping_ratio:.2g} %"
    return Answer("Equivalent damping", value, note, "warn" if main.peak.at_edge else "")


def _last_states(main: CaseAnswers) -> list[CaseAnswers]:
    """The last of the states that each analysis leads to."""
    return [states[-1] for states in main.states.values() if states]


def _reserve(run: RunResult, main: CaseAnswers) -> str:
    m, least = main.stress.governing, main.stress.least_growth
    where = "" if least is m else f", least {least.growth:.3g} ({least.part}, {least.where})"
    text = (
        f"{m.part}; Goodman, {'ASSUMED ' if assumed(main, m.part) else ''}fatigue limit "
        f"{1e-6 * m.strength.limit:g} MPa; vibratory stress margin {m.growth:.3g}{where}; "
        f"{_of_wave(main)}. Clear of sharp corners and point forces"
    )
    worst = main.stress.worst[m.part][0]
    if worst.doubt:
        text += f", where the mesh has n = {worst.reserve:.3g}"
    for analysis in run.analyses:
        if states := main.states.get(analysis.key):
            reserve, peak = states[-1].stress.governing.reserve, 1e6 * states[-1].peak.amplitude
            text = f"**n = {reserve:.3g} at {peak:.3g} µm**, {analysis.state}. {text}"
    return text


def _of_wave(main: CaseAnswers) -> str:
    """What is known of the wave that stresses are of."""
    if main.wave is None:
        return "stability of the wave not checked"
    return f"the wave is {main.wave.verdict}"


def best_friction(run: RunResult) -> list[Answer]:
    """The optimum friction, where that of one joint is swept and nothing else."""
    found, swept = run.known, {key for each in run.known for key in each.values}
    if len(found) < 2 or len(swept) != 1 or not (key := swept.pop()).endswith(".mu"):
        return []
    if any(each.peak.at_edge for each in found if each.peak):
        return [_withheld("Optimum friction")]
    height = [each.peak.amplitude for each in found if each.peak]
    best = int(np.argmin(height))
    mu = [float(each.values[key]) for each in found]
    at_end = mu[best] in (min(mu), max(mu))
    note = f"lowest peak of the cases, {1e6 * height[best]:.3g} µm"
    if at_end:
        note += "; at the end of the values swept, so the best may lie beyond"
    return [Answer("Optimum friction", f"μ = {mu[best]:g}", note, "warn" if at_end else "")]


def warnings(run: RunResult) -> list[str]:
    """What keeps the answers from being taken as they are, a line each."""
    cases = {each.case: each for each in run.summaries}
    lines = [*_failed(run), *by_text(cases)]
    lines += [f"{line}." for line in without_effect([(c.values, c) for c in cases.values()])]
    for name, (errors, _) in run.errors.items():
        case = "" if name == "nominal" else f"{words(name)}: "
        lines += [f"{case}{line.removeprefix('WARNING: ')}." for line in errors.warnings]
    main = run.main
    if main and main.margins:
        lines += [
            f"The worst node of the {part}, n = {worst.reserve:.3g} ({worst.where}), lies "
            f"{worst.doubt}: its stress depends on the mesh, not on the part."
            for part, (worst, *_) in main.margins.worst.items()
            if worst.doubt and worst.reserve < main.margins.governing.reserve
        ]
    given = run.given
    mesh = given.mesh if isinstance(given, Study) and not run.errors else None
    if mesh and (mesh.size, mesh.correction) == ("coarse", "none"):
        lines.append("The mesh is coarse: frequencies are several per cent too high.")
    return lines


def _failed(run: RunResult) -> list[str]:
    """Cases that could not be computed."""
    names = list(run.failed)
    if not names:
        return []
    shown = "; ".join(f"{words(name)} ({run.failed[name].reason})" for name in names[:MOST_FAILED])
    more = f"; and {len(names) - MOST_FAILED} more" if len(names) > MOST_FAILED else ""
    every = len(names) + len(run.summaries)
    return [f"{len(names)} of {every} cases FAILED and are left out: {shown}{more}."]


def cases(run: RunResult) -> Table:
    """A line for each case, its stress as well where it is known."""
    lines = [
        case_row(each, run.answers.get(each.case), run.balances.get(each.case))
        for each in run.summaries
    ]
    found = case_table(lines, run.monitor.name).without(*APART)
    rows = [(fixed(words(str(name))), *rest) for name, *rest in found.rows]
    return replace(found, title=f"All cases at their largest {run.monitor.name}", rows=rows)
