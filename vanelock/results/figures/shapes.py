"""Mesh, modes of interest and responses at their peaks: pictures and the fields behind them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vanelock import fem, render, rom
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.cases.sweep import label
from vanelock.pipeline.progress import Notice
from vanelock.quantities.run_result import Floats, RunResult, Shape
from vanelock.report import Picture
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import LIMITS

MASS_NORMALISED = "kg^-0.5"
"""Unit of modes."""
DETAILED = 8
"""Cases that get pictures of their own; a larger sweep gets those of the first and the last."""


@dataclass(frozen=True)
class Drawn:
    """A field to be drawn, recovered when it is first needed.

    Attributes
    ----------
    name : str
        Of the files, without what marks their kind.
    title, subtitle : str
        Heading, and the line under it.
    nodal_diameter : int
        Of the wave.
    recover : callable
        The displacement of each part's nodes.
    shows : JSON
        All that it depends on.
    unit : str
        Of the displacement.
    """

    name: str
    title: str
    subtitle: str
    nodal_diameter: int
    recover: Callable[[], list[Shape]]
    shows: Any
    unit: str = "m"

    @cached_property
    def fields(self) -> list[Shape]:
        """(nodes, 3) of each part."""
        return self.recover()


def mesh(run: RunResult, each: Planned, data: Sequence[Path] = ()) -> Picture:
    """Both parts with their node sets."""
    keys = [mesh_step(each.case.study, part).key for part in PARTS]
    title = f"{run.study.name}: mesh"
    path = run.output_files.draw(
        "figures/mesh.png",
        [keys, title],
        lambda path: render.mesh_picture(path, *run.parts(each), title),
    )
    caption = (
        "Finite-element mesh of one vane segment and one casing sector (translucent). Balls are "
        "the nodes where the parts touch, are loaded and are measured; pale ones lie behind. "
        "Right: the meridional section through the front hook, whose foot sits in the casing's "
        f"groove, and the full ring of {run.study.ring.sectors} sectors,"
        " of which one is meshed."
    )
    return Picture(path, "Mesh and node sets", caption, tuple(data))


def all_modes(run: RunResult) -> list[Picture]:
    """Modes of each distinct set of linear limits, under the swept values that distinguish them."""
    groups = [_mode_key(run, each) for each in run.planned]
    names = label([each.case for each in run.planned], groups)
    chosen: dict[Any, tuple[Planned, str]] = {}
    for each, group, name in zip(run.planned, groups, names, strict=True):
        chosen.setdefault(group, (each, name))
    distinct = list(chosen.values())
    if len(distinct) > DETAILED:
        text = f"pictures of modes for the first and the last of {len(distinct)} linear limits"
        run.output_files.listener(Notice(text))
        distinct = [distinct[0], distinct[-1]]
    found: list[Picture] = []
    for each, name in distinct:
        found += _modes(run, each, name, run.study.outputs.animations and not found)
    return found


def _mode_key(run: RunResult, each: Planned) -> tuple[Any, ...]:
    """What tells modes apart; a load or a damping ratio does not."""
    limits = run.stages.get(each.linear.limits)
    places = limits.nodal_diameter, limits.free_mode, limits.stuck_mode
    k = limits.nodal_diameter
    parts = tuple(each.part(name, k).key for name in each.structure.names)
    return *parts, *places, limits.free.tobytes(), limits.stuck.tobytes()


def _modes(run: RunResult, each: Planned, name: str, animated: bool) -> list[Picture]:
    """The mode of interest, interlock free and stuck; `animated`, the last one moves too."""
    limits = run.stages.get(each.linear.limits)
    k = limits.nodal_diameter
    made = []
    wanted = LIMITS if limits.opens else LIMITS[:1]
    for which in wanted:
        place = limits.free_mode if which == "free" else limits.stuck_mode
        frequency = limits.free_frequency if which == "free" else limits.stuck_frequency
        wave = render.wave_name(k, run.study.ring.sectors)
        held = f", interlock {which}" if limits.opens else ""
        title = f"Mode {place + 1} of {wave}{held}: {frequency:.2f} Hz"

        def recover(which: str = which, place: int = place) -> list[Shape]:
            system = run.stages.get(each.linear.system)
            closed = ~system.contacts.opens if which == "free" else None
            shapes = rom.linear_modes(system, k, place + 1, closed)[1]
            return run.fields(each, np.asarray(shapes[:, place], complex), k)

        shows = [each.linear.limits.key, title, name]
        file = f"mode_{which}_{slug(name)}" if name else f"mode_{which}"
        drawn = Drawn(file, title, words(name), k, recover, shows, MASS_NORMALISED)
        caption = (
            f"Linear mode of interest{held}{of_case(name)}: natural frequency {frequency:.2f} Hz, "
            f"{wave} on the full ring, all other contacts stuck. Deformation is exaggerated as "
            "stated, colours show where it moves most. Left: one sector at its largest deflection, "
            "undeformed in grey; right: the wave around the ring."
        )
        data = _data(run, each, drawn)
        made.append(_picture(run, each, drawn, render.mode_picture, caption, data))
        if animated and which == wanted[-1]:
            caption = (
                f"The same mode over one period{of_case(name)}: a wave that travels round the ring "
                "as the load does. Colours are the displacement at the instant."
            )

            def animate(path: Path, drawn: Drawn = drawn) -> None:
                render.mode_animation(
                    path, run.parts(each), drawn.fields, k, drawn.title, drawn.subtitle
                )

            path = run.output_files.draw(f"shapes/{file}.gif", shows, animate)
            made.append(Picture(path, f"{title}, in motion", caption, data))
    return made


def response(run: RunResult, each: Planned, animated: bool) -> list[Picture]:
    """First harmonic at the peak; `animated`, all of them too."""
    name = each.case.name
    top, peak = run.top(each), run.peak(name)
    k = int(top.harmonic_diameters[1])
    title = f"Response at its peak, {peak.frequency:.2f} Hz"
    shows = [each.response.key, title, name, run.monitor.name]
    subtitle = f"{words(name)}, first harmonic"
    drawn = Drawn(
        f"response_{slug(name)}", title, subtitle, k, lambda: run.harmonic(each, 1), shows
    )
    caption = (
        f"First harmonic of the vibration with friction at the largest response, "
        f"{peak.frequency:.2f} Hz{of_case(name)}. Left: the amplitude that each point reaches in "
        "a cycle, deformation exaggerated as stated. Right: phase of the dominant component; where "
        "colours run once around the ring for each nodal diameter the wave travels, and a jump "
        "within a sector marks parts that move in opposite phase."
    )
    data = _data(run, each, drawn)
    made = [_picture(run, each, drawn, render.response_picture, caption, data)]
    if animated:

        def animate(path: Path) -> None:
            waves = [
                render.Wave(h, int(top.harmonic_diameters[h]), run.harmonic(each, h))
                for h in range(1, top.harmonics + 1)
            ]
            render.response_animation(path, run.parts(each), waves, title, words(name))

        path = run.output_files.draw(f"shapes/{drawn.name}.gif", shows, animate)
        caption = (
            f"The vibration at the peak over one period{of_case(name)}, all harmonics, each with "
            "its own nodal diameter, without what the preload does at rest. Colours are the "
            "displacement at the instant: the pattern runs round the ring with the load."
        )
        made.append(Picture(path, f"{title}, in motion", caption, data))
    return made


def stress(run: RunResult, each: Planned) -> Picture:
    """Von Mises stress of the vane at the peak."""
    name = each.case.name
    peak = run.peak(name)
    title = f"Largest von Mises stress in a period, {peak.frequency:.2f} Hz"
    placed = None if each.gauges is None else run.stages.get(each.gauges).positions
    shows = [each.response.key, title, name, [] if placed is None else placed.tolist()]

    @cache
    def values() -> tuple[Floats, Floats]:
        return _stress_over_a_period(run.stresses(each))

    def picture(path: Path) -> None:
        gauges = () if placed is None else placed
        render.stress_picture(path, run.parts(each)[0], *values(), title, words(name), gauges)

    def write(path: Path) -> None:
        total, vibration = values()
        given = {"von_mises_max (Pa)": total, "von_mises_max_of_vibration (Pa)": vibration}
        render.write_vtu(path, run.parts(each)[0], fields=given)

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
    each: Planned,
    drawn: Drawn,
    draw: Callable[..., Path],
    caption: str,
    data: tuple[Path, ...],
) -> Picture:
    def function(path: Path) -> None:
        parts, k = run.parts(each), drawn.nodal_diameter
        draw(path, parts, drawn.fields, k, drawn.title, drawn.subtitle)

    path = run.output_files.draw(f"shapes/{drawn.name}.png", drawn.shows, function)
    return Picture(path, drawn.title, caption, data)


def _data(run: RunResult, each: Planned, drawn: Drawn) -> tuple[Path, ...]:
    """One .vtu file for each part of a displacement field."""
    data = []
    for i, part in enumerate(PARTS):

        def write(path: Path, i: int = i) -> None:
            render.write_vtu(path, run.parts(each)[i], drawn.fields[i], unit=drawn.unit)

        file = f"shapes/{drawn.name}_{part}.vtu"
        data.append(run.output_files.draw(file, drawn.shows, write, quick=True))
    return tuple(data)


def _stress_over_a_period(harmonics: Shape) -> tuple[Floats, Floats]:
    """(nodes,) largest von Mises stress over a period, Pa: in all, and of the vibration alone."""
    moving = harmonics.copy()
    moving[0] = 0
    return fem.peak_von_mises(harmonics), fem.peak_von_mises(moving)
