"""Modes and responses on a run's page, to turn and to play."""

from vanelock.common.arrays import Complex
from vanelock.input.cases.names import words
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.run_result import RunResult
from vanelock.report import Motion, Section, View, body_of
from vanelock.report.blocks import Block

MOST = 4
"""Responses shown besides the modes."""


def shapes(run: RunResult) -> Section:
    """The 3-D view of the case with the largest peak, and of others on the same meshes.

    None where the study wants no shapes.
    """
    main = run.main
    wanted = main is not None and main.margins and run.shapes
    blocks: list[Block] = [view(run, _same_mesh(run))] if wanted else []
    return Section("Shapes in three dimensions", blocks, id="shapes")


def _same_mesh(run: RunResult) -> list[CaseResult]:
    """Cases with answers on the meshes of the main one, that first."""
    main = run.main
    assert main is not None
    cases = [main, *(each for each in run.looked_into.values() if each is not main)]
    return [each for each in cases if each.mesh_keys == main.mesh_keys][:MOST]


def view(run: RunResult, cases: list[CaseResult]) -> View:
    """Modes of the first of some cases on one mesh, and the response of each at its peak."""
    found = [body_of(part) for part in cases[0].parts]
    taken = [nodes for _, nodes in found]

    def cut(fields: list[Complex]) -> tuple[Complex, ...]:
        return tuple(field[nodes] for field, nodes in zip(fields, taken, strict=True))

    motions = []
    for each in cases:
        name = "" if each.name == "nominal" else f", {words(each.name)}"
        motions.append(
            Motion(
                f"Response at the peak{name}",
                int(each.top.harmonic_diameters[1]),
                cut(each.fields.shape(1)),
                each.at_peak.frequency,
                note="First harmonic alone.",
            )
        )
    limits = cases[0].limits
    for which in limits.conditions:
        place, frequency = limits.of_interest(which)
        motions.append(
            Motion(
                f"Mode {place + 1}{f', interlock {which}' if limits.opens else ''}",
                limits.nodal_diameter,
                cut(cases[0].mode_shapes.shape(which)),
                frequency,
                note="A linear mode: its height means nothing.",
                relative=True,
            )
        )
    return View(
        [body for body, _ in found],
        motions,
        "Response and modes on the full ring",
        "Drag to turn, scroll to zoom. Colours show the amplitude; the motion is exaggerated.",
    )
