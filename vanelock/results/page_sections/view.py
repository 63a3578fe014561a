"""Modes and responses on a run's page, to turn and to play."""

import numpy as np

from vanelock import rom
from vanelock.input.cases.names import words
from vanelock.quantities.run_result import RunResult, Shape
from vanelock.report import Motion, Section, View, body_of
from vanelock.report.blocks import Block
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import LIMITS

MOST = 4
"""Responses shown besides the modes."""


def shapes(run: RunResult) -> Section:
    """The 3-D view of the case with the largest peak, and of others on the same meshes.

    None where the study wants no shapes.
    """
    main = run.main
    wanted = main is not None and main.margins and run.study.outputs.shapes
    blocks: list[Block] = [view(run, _same_mesh(run))] if wanted else []
    return Section("Shapes in three dimensions", blocks, id="shapes")


def _same_mesh(run: RunResult) -> list[Planned]:
    """Cases with answers on the meshes of the main one, that first."""
    main = run.main
    assert main is not None
    cases = [main.planned]
    cases += [each.planned for each in run.answers.values() if each.name != main.name]
    own = _meshes(main.planned)
    return [each for each in cases if _meshes(each) == own][:MOST]


def _meshes(each: Planned) -> list[str]:
    return [step.key for step in each.meshes.values()]


def view(run: RunResult, cases: list[Planned]) -> View:
    """Modes of the first of some cases on one mesh, and the response of each at its peak."""
    found = [body_of(part) for part in run.parts(cases[0])]
    taken = [nodes for _, nodes in found]

    def cut(fields: list[Shape]) -> tuple[Shape, ...]:
        return tuple(field[nodes] for field, nodes in zip(fields, taken, strict=True))

    motions = []
    for each in cases:
        top, peak = run.top(each), run.peak(each.case.name)
        name = "" if each.case.name == "nominal" else f", {words(each.case.name)}"
        motions.append(
            Motion(
                f"Response at the peak{name}",
                int(top.harmonic_diameters[1]),
                cut(run.harmonic(each, 1)),
                peak.frequency,
                note="First harmonic alone.",
            )
        )
    motions += [_mode(run, cases[0], which, cut) for which in _held(run, cases[0])]
    return View(
        [body for body, _ in found],
        motions,
        "Response and modes on the full ring",
        "Drag to turn, scroll to zoom. Colours show the amplitude; the motion is exaggerated.",
    )


def _held(run: RunResult, each: Planned) -> list[str]:
    limits = run.stages.get(each.linear.limits)
    return list(LIMITS if limits.opens else LIMITS[:1])


def _mode(run: RunResult, each: Planned, which: str, cut: object) -> Motion:
    """The mode of interest with the interlock free or stuck."""
    limits = run.stages.get(each.linear.limits)
    system = run.stages.get(each.linear.system)
    k = limits.nodal_diameter
    place = limits.free_mode if which == "free" else limits.stuck_mode
    frequency = limits.free_frequency if which == "free" else limits.stuck_frequency
    closed = ~system.contacts.opens if which == "free" else None
    shape = rom.linear_modes(system, k, place + 1, closed)[1][:, place]
    fields = run.fields(each, np.asarray(shape, complex), k)
    assert callable(cut)
    held = f", interlock {which}" if limits.opens else ""
    return Motion(
        f"Mode {place + 1}{held}",
        k,
        cut(fields),
        frequency,
        note="A linear mode: its height means nothing.",
        relative=True,
    )
