"""The pictures of a run, in the order in which they are drawn and shown.

Meshes and their errors, modes of interest, responses at their peaks: pictures and fields.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vanelock import render
from vanelock.common.arrays import Complex
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.cases.sweep import Case, label
from vanelock.pipeline.progress import Notice
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.run_result import (
    DETAILED,
    RunResult,
    in_words,
    looked_into_names,
    named,
)
from vanelock.report import Picture
from vanelock.results.figures.contacts import contacts, loops, preloads
from vanelock.results.figures.curves import curves
from vanelock.results.files.run_folder import REPORT
from vanelock.stages.accuracy.evidence import ErrorPlaces
from vanelock.stages.parts.components import PARTS
from vanelock.stages.response.limits import Limit

MASS_NORMALISED = "kg^-0.5"
"""Unit of modes."""


@dataclass(frozen=True)
class _ShownField:
    """A field to be drawn: of files named so, under a heading and a line, of that unit.

    What `recover` gives, displacements (nodes, 3) of each part, is made when it is first needed;
    `shows` is all that it depends on.
    """

    name: str
    title: str
    subtitle: str
    nodal_diameter: int
    recover: Callable[[], list[Complex]]
    shows: Any
    unit: str = "m"

    @cached_property
    def fields(self) -> list[Complex]:
        return self.recover()


def _mesh(run: RunResult, case: CaseResult, data: Sequence[Path] = ()) -> Picture:
    """Both parts with their node sets."""
    title = f"{run.study.name}: mesh"
    path = run.output_files.draw(
        "figures/mesh.png",
        [case.mesh_keys, title],
        lambda path: render.mesh_picture(path, *case.parts, title),
    )
    caption = (
        "Finite-element mesh of one vane segment and one casing sector (translucent). Balls are "
        "the nodes where the parts touch, are loaded and are measured; pale ones lie behind. "
        "Right: the meridional section through the front hook, whose foot sits in the casing's "
        f"groove, and the full ring of {run.study.ring.sectors} sectors,"
        " of which one is meshed."
    )
    return Picture(path, "Mesh and node sets", caption, tuple(data))


def _all_modes(run: RunResult) -> list[Picture]:
    """Modes of distinct sets of linear limits, of many the first and the last."""
    distinct = _distinct_modes(run)
    if len(distinct) > DETAILED:
        text = f"pictures of modes for the first and the last of {len(distinct)} linear limits"
        run.output_files.listener(Notice(text))
    found: list[Picture] = []
    for each, name in _few(distinct):
        found += _modes(run, each, name, "animations" in run.problem.outputs.show and not found)
    return found


def _few(distinct: list[tuple[CaseResult, str]]) -> list[tuple[CaseResult, str]]:
    """Those of distinct modes that are drawn."""
    return distinct if len(distinct) <= DETAILED else [distinct[0], distinct[-1]]


def _distinct_modes(run: RunResult) -> list[tuple[CaseResult, str]]:
    """A case of each set of linear limits, under the swept values that distinguish them."""
    cases = list(run.cases.values())
    groups = list(map(_mode_key, cases))
    names = label([Case(each.name, dict(each.values), each.problem) for each in cases], groups)
    chosen: dict[Any, tuple[CaseResult, str]] = {}
    for each, group, name in zip(cases, groups, names, strict=True):
        chosen.setdefault(group, (each, name))
    return list(chosen.values())


def _mode_key(case: CaseResult) -> tuple[Any, ...]:
    """What tells modes apart; a load or a damping ratio does not."""
    limits = case.limits
    places = limits.nodal_diameter, limits.free_mode, limits.stuck_mode
    return *case.component_keys, *places, limits.free.tobytes(), limits.stuck.tobytes()


def _modes(run: RunResult, case: CaseResult, name: str, animated: bool) -> list[Picture]:
    """The mode of interest, interlock free and stuck; `animated`, the last one moves too."""
    limits = case.limits
    k = limits.nodal_diameter
    made = []
    for which in limits.conditions:
        place, frequency = limits.of_interest(which)
        wave = render.wave_name(k, run.study.ring.sectors)
        held = f", interlock {which}" if limits.opens else ""
        title = f"Mode {place + 1} of {wave}{held}: {frequency:.2f} Hz"

        def recover(which: Limit = which) -> list[Complex]:
            return case.mode_shapes.shape(which)

        shows = [case.key_at("limits"), title, name]
        file = f"mode_{which}_{slug(name)}" if name else f"mode_{which}"
        drawn = _ShownField(file, title, words(name), k, recover, shows, MASS_NORMALISED)
        caption = (
            f"Linear mode of interest{held}{of_case(name)}: natural frequency {frequency:.2f} Hz, "
            f"{wave} on the full ring, all other contacts stuck. Deformation is exaggerated as "
            "stated, colours show where it moves most. Left: one sector at its largest deflection, "
            "undeformed in grey; right: the wave around the ring."
        )
        data = _data(run, case, drawn)
        made.append(_picture(run, case, drawn, render.mode_picture, caption, data))
        if animated and which == limits.conditions[-1]:
            caption = (
                f"The same mode over one period{of_case(name)}: a wave that travels round the ring "
                "as the load does. Colours are the displacement at the instant."
            )

            def animate(path: Path, drawn: _ShownField = drawn) -> None:
                render.mode_animation(
                    path, case.parts, drawn.fields, k, drawn.title, drawn.subtitle
                )

            path = run.output_files.draw(f"shapes/{file}.gif", shows, animate)
            made.append(Picture(path, f"{title}, in motion", caption, data))
    return made


def _response(run: RunResult, case: CaseResult, animated: bool) -> list[Picture]:
    """First harmonic at the peak; `animated`, all of them too."""
    name = case.name
    top, peak = case.top, case.at_peak
    k = int(top.harmonic_diameters[1])
    title = f"Response at its peak, {peak.frequency:.2f} Hz"
    shows = [case.key_at("response"), title, name, run.monitor.name]
    subtitle = f"{words(name)}, first harmonic"
    drawn = _ShownField(
        f"response_{slug(name)}", title, subtitle, k, lambda: case.fields.shape(1), shows
    )
    caption = (
        f"First harmonic of the vibration with friction at the largest response, "
        f"{peak.frequency:.2f} Hz{of_case(name)}. Left: the amplitude that each point reaches in "
        "a cycle, deformation exaggerated as stated. Right: phase of the dominant component; where "
        "colours run once around the ring for each nodal diameter the wave travels, and a jump "
        "within a sector marks parts that move in opposite phase."
    )
    data = _data(run, case, drawn)
    made = [_picture(run, case, drawn, render.response_picture, caption, data)]
    if animated:

        def animate(path: Path) -> None:
            waves = [
                render.Wave(h, int(top.harmonic_diameters[h]), case.fields.shape(h))
                for h in range(1, top.harmonics + 1)
            ]
            render.response_animation(path, case.parts, waves, title, words(name))

        path = run.output_files.draw(f"shapes/{drawn.name}.gif", shows, animate)
        caption = (
            f"The vibration at the peak over one period{of_case(name)}, all harmonics, each with "
            "its own nodal diameter, without what the preload does at rest. Colours are the "
            "displacement at the instant: the pattern runs round the ring with the load."
        )
        made.append(Picture(path, f"{title}, in motion", caption, data))
    return made


def _stress(run: RunResult, case: CaseResult) -> Picture:
    """Von Mises stress of the vane at the peak."""
    name = case.name
    peak = case.at_peak
    title = f"Largest von Mises stress in a period, {peak.frequency:.2f} Hz"
    placed = None if (gauges := case.gauges) is None else gauges.positions
    shows = [case.key_at("response"), title, name, [] if placed is None else placed.tolist()]

    def picture(path: Path) -> None:
        marked = () if placed is None else placed
        values = case.fields.largest, case.fields.vane.amplitude
        render.stress_picture(path, case.parts[0], *values, title, words(name), marked)

    def write(path: Path) -> None:
        stresses = {
            "von_mises_max (Pa)": case.fields.largest,
            "von_mises_max_of_vibration (Pa)": case.fields.vane.amplitude,
        }
        render.write_vtu(path, case.parts[0], fields=stresses)

    path = run.output_files.draw(f"shapes/stress_{slug(name)}.png", shows, picture)
    data = run.output_files.draw(f"shapes/stress_{slug(name)}_vane.vtu", shows, write, quick=True)
    caption = (
        f"Largest von Mises stress of the vane in a period at the peak, {peak.frequency:.2f} Hz"
        f"{of_case(name)}. Left: with what the preload does at rest; right: of the vibration "
        "alone, which causes fatigue. Stress at nodes that carry contact forces grows with every "
        "refinement of the mesh, so look at fillets and aerofoils, not at contacts."
    )
    return Picture(path, "Stress of the vane at the peak", caption, (data,))


def _picture(
    run: RunResult,
    case: CaseResult,
    drawn: _ShownField,
    draw: Callable[..., Path],
    caption: str,
    data: tuple[Path, ...],
) -> Picture:
    def function(path: Path) -> None:
        parts, k = case.parts, drawn.nodal_diameter
        draw(path, parts, drawn.fields, k, drawn.title, drawn.subtitle)

    path = run.output_files.draw(f"shapes/{drawn.name}.png", drawn.shows, function)
    return Picture(path, drawn.title, caption, data)


def _data(run: RunResult, case: CaseResult, drawn: _ShownField) -> tuple[Path, ...]:
    """One .vtu file for each part of a displacement field."""
    data = []
    for i, part in enumerate(PARTS):

        def write(path: Path, i: int = i) -> None:
            render.write_vtu(path, case.parts[i], drawn.fields[i], unit=drawn.unit)

        file = f"shapes/{drawn.name}_{part}.vtu"
        data.append(run.output_files.draw(file, drawn.shows, write, quick=True))
    return tuple(data)


def _mesh_errors(run: RunResult, result: CaseResult) -> list[Picture]:
    """The picture of a case, where a part of it is an own mesh."""
    if "mesh_error" not in result.products:
        return []
    places: ErrorPlaces = result.products.get("mesh_error")
    title = f"Where the meshes err in the mode of interest, {result.limits.stuck_frequency:.2f} Hz"
    subtitle = f"{result.study.name}. What elements add to its stiffness, by their own estimate."
    shows = [result.key_at("mesh_error"), title, result.study.name]

    def picture(path: Path) -> None:
        densities = places.vane, places.casing
        render.mesh_error_picture(path, result.parts, densities, title, subtitle)

    table = places.table
    caption = (
        "What each element adds to the stiffness of the mode of interest, by its own estimate: "
        "elements are best made smaller where colours are dark. The table lists the worst places."
    )
    own = shows, picture, table.by_head, table.lines
    return [run.picture("figures/mesh_error", title, *own, caption)]


FEW = 60
"""Cases that all get their damping ratio: each takes its system anew."""


def look_into(run: RunResult) -> None:
    """Have all that pictures and page show made, be they drawn anew or not."""
    shapes = run.shapes
    if "report" in run.problem.outputs.show:
        chosen = looked_into_names(run)
        for name, case in run.cases.items():
            if name in chosen:
                run.cases[name] = _with_details(case)
            elif case.peak is not None and len(run.cases) <= FEW:
                run.cases[name] = replace(case, numbers=_energies(case))
    wanted = [(case, "mode_shapes") for case, _ in _few(_distinct_modes(run))] if shapes else []
    wanted += [(case, "fields") for case in named(run)] if shapes else []
    wanted += [(run.first, "mesh_error")] if shapes else []
    if (main := run.main) is not None:
        wanted += [(main, "mode_shapes")] if shapes else []
        wanted += [(main, "neglected"), (main, "mesh_doubt")] if main.errors is None else []
    for case, place in wanted:
        if place in case.products:
            case.products.get(place)


def _with_details(case: CaseResult) -> CaseResult:
    """A case with all numbers at its peak, and what moves and checks it made."""
    for place in ("audit", "sensitivities"):
        if place in case.products:
            case.products.get(place)
    numbers = {
        **_energies(case),
        "bandwidth_ratio": (case.bandwidth, "1"),
        "largest_slip": (float(np.nanmax(case.wear.slip, initial=0.0)), "m"),
    }
    if case.margins is not None:
        for analysis in case.analyses:
            if states := [state.stress.governing for state in case.states(analysis)]:
                numbers[analysis.reserve] = (states[-1].reserve, "1")
        m, gauges = case.margins.governing, case.margins.gauges
        numbers |= {
            "alternating_stress": (m.amplitude, "Pa"),
            "mean_stress": (m.mean, "Pa"),
            "goodman_reserve": (m.reserve, "1"),
            "vibration_may_grow": (m.growth, "1"),
            "place": (f"{m.part}, {m.where}", ""),
        }
        if gauges:
            numbers["gauge_alternating_stress"] = ([each.amplitude for each in gauges], "Pa")
            numbers["gauge_mean_stress"] = ([each.mean for each in gauges], "Pa")
            numbers["gauge_goodman_reserve"] = ([each.reserve for each in gauges], "1")
    return replace(case, numbers=numbers, detailed=True)


def _energies(case: CaseResult) -> dict[str, Any]:
    """Where the energy goes at a case's peak."""
    b = case.balance
    return {
        "damping_ratio": (b.damping_ratio, "1"),
        "input_work": (b.input, "J"),
        "friction_work": (b.friction, "J"),
        "stored_energy": (b.stored, "J"),
    }


def draw(run: RunResult) -> None:
    """Draw what is not there yet, and remove what earlier runs drew and this one does not."""
    run.pictures = [*_drawn(run), *_of_analyses(run)]
    run.output_files.tidy(keep=[REPORT] if "report" in run.problem.outputs.show else [])


def _drawn(run: RunResult) -> list[Picture]:
    """All but those of analyses."""
    shown = run.problem.outputs.show
    made = [curves(run), *preloads(run)]
    chosen = _detailed(run)
    moving = chosen[:1] + chosen[-1:] if "animations" in shown else []
    if "loops" in shown:
        for each in chosen:
            made += _own(each, loops(run, each))
    if run.shapes:
        modes = _all_modes(run)
        made.append(_mesh(run, run.first, modes[0].data if modes else ()))
        made += _mesh_errors(run, run.first)
        made += modes
        for each in chosen:
            made += _own(each, _response(run, each, each in moving))
        for each in chosen:
            made += _own(each, [_stress(run, each), contacts(run, each)])
    return made


def _of_analyses(run: RunResult) -> Iterator[Picture]:
    """Those of analyses that are asked for, and of the cases that are looked into."""
    for analysis in run.analyses:
        made = [*analysis.run_pictures(run)]
        cases = run.looked_into.values() if analysis.looked_into else named(run)
        for each in cases:
            if analysis.looked_into or each.products.of_analysis(analysis.key):
                made += _own(each, analysis.pictures(run, each))
        yield from (replace(picture, section=analysis.key) for picture in made)


def _detailed(run: RunResult) -> list[CaseResult]:
    """Cases with pictures of their own; says which, if any are drawn."""
    cases, count = named(run), len(run.peaks)
    drawn = [name for name in ("loops", "shapes") if name in run.problem.outputs.show]
    if drawn and len(cases) < count:
        text = f"pictures of {' and '.join(drawn)} for {in_words(run)} of {count}"
        run.output_files.listener(Notice(text))
    return cases


def _own(result: CaseResult, made: Iterable[Picture]) -> Iterator[Picture]:
    """Pictures of a case."""
    return (replace(picture, case=result.name) for picture in made)
