"""The page of a scene's run, report.html."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import vanelock
from vanelock.common.files.digests import file_digest
from vanelock.input.cases.names import words
from vanelock.input.schema.scene import Scene
from vanelock.pipeline.cache import code_of
from vanelock.quantities.warnings import by_text, without_effect
from vanelock.report import (
    Answer,
    Answers,
    Page,
    Picture,
    Plot,
    Section,
    Table,
    Text,
    Trace,
    write_page,
)
from vanelock.report.blocks import Block, Cell
from vanelock.results.figures.figure import Figure
from vanelock.results.files.redrawn import REPORT
from vanelock.results.page_sections.curves import render_grey
from vanelock.results.page_sections.provenance import versions, written
from vanelock.results.scene.figures import SceneShown
from vanelock.stages.scene.gather import gathered
from vanelock.stages.scene.monitor import Found
from vanelock.stages.scene.steps import piece_step, system_step


def write_scene_page(
    shown: SceneShown, found: Sequence[Found], exhibits: Sequence[Figure], text: str
) -> Path:
    """Write the page of a run into its folder, unless it is there and shows the same already."""
    shows = [
        code_of("results", "stages", "report"),
        [each.key for each in shown.top.values()],
        shown.monitor.name,
        text,
        [file_digest(each.path) for each in exhibits],
    ]

    def write(path: Path) -> None:
        write_page(path, _page(shown, found, exhibits, text))

    return shown.output_files.draw(REPORT, shows, write)


def _page(shown: SceneShown, found: Sequence[Found], exhibits: Sequence[Figure], text: str) -> Page:
    version = f"vanelock {vanelock.__version__}, {written()}"
    sections = [
        _summary(shown, found),
        Section("Curves", [_plot(shown)], id="curves"),
        Section(
            "Contacts",
            [Picture(e.path, e.title, e.caption, e.data) for e in exhibits[1:]],
            id="contacts",
        ),
        _models(shown),
        _provenance(text),
    ]
    full = [each for each in sections if each.blocks]
    return Page(shown.scene.name, f"Friction-damped vibration; {version}", full)


def _summary(shown: SceneShown, found: Sequence[Found]) -> Section:
    blocks: list[Block] = [Answers(tuple(_answers(shown, found)))]
    warned = by_text({each.case.name: each for each in found})
    warned += [f"{line}." for line in without_effect([(c.case.values, c) for c in found])]
    if warned:
        blocks.append(Text("**Be careful.** " + "\n\n".join(warned)))
    blocks.append(_cases(found))
    return Section("Summary", blocks, id="summary")


def _answers(shown: SceneShown, found: Sequence[Found]) -> list[Answer]:
    known = [each for each in found if each.peak is not None]
    if not known:
        return [Answer("Peak", "none", "no point of any case converged", "bad")]
    most = max(known, key=lambda each: each.peak.amplitude if each.peak else 0.0)
    assert most.peak is not None
    case = f"{words(most.case.name)}, " if len(found) > 1 else ""
    over = "".join(
        f"; {value:.2f} of the linear peak with {word} contacts"
        for value, word in ((most.of_free, "open"), (most.of_stuck, "stuck"))
        if not np.isnan(value)
    )
    answers = [
        Answer(
            "Largest peak" if len(known) > 1 else "Peak",
            f"{1e6 * most.peak.amplitude:.3g} µm",
            f"{case}{shown.monitor.name}, half the peak-to-peak{over}",
            "warn" if most.peak.at_edge else "",
        ),
        Answer("At", f"{most.peak.frequency:.2f} Hz", _speed(shown, most.peak.frequency)),
    ]
    total = sum(most.work.values())
    if total > 0:
        shares = ", ".join(f"{k} {100 * v / total:.0f} %" for k, v in most.work.items() if v > 0)
        answers.append(
            Answer("Friction work", f"{1e6 * total:.3g} µJ", f"in a period at the peak: {shares}")
        )
    least = min(known, key=lambda each: each.peak.amplitude if each.peak else np.inf)
    if least is not most and least.peak is not None:
        answers.append(
            Answer("Smallest peak", f"{1e6 * least.peak.amplitude:.3g} µm", words(least.case.name))
        )
    return answers


def _speed(shown: SceneShown, frequency: float) -> str:
    """Rotor speed, in a ring."""
    order = abs(shown.scene.excitation.engine_order)
    if shown.scene.ring.sectors == 1:
        return ""
    return f"{60 * frequency / order:,.0f} rpm at engine order {order}"


def _cases(found: Sequence[Found]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for each in found:
        top = (None, None)
        if each.peak is not None:
            top = (1e6 * each.peak.amplitude, each.peak.frequency)  # type: ignore[assignment]
        shares = (each.of_free, each.of_stuck, 100 * each.slipping, 100 * each.opening)
        numbers = tuple(None if np.isnan(v) else v for v in shares)
        rows.append((words(each.case.name), *top, *numbers, 1e6 * sum(each.work.values())))
    return Table(
        ("case", "peak", "at", "of open", "of stuck", "slip", "open", "friction work"),
        rows,
        "Of open, of stuck: over the linear peaks. Slip, open: contacts that rub, that lift off in "
        "a period at the peak.",
        ("", "µm", "Hz", "", "", "%", "%", "µJ"),
    )


def _plot(shown: SceneShown) -> Plot:
    traces = []
    for each in shown.curves():
        frequency, order = np.asarray(each.frequency, float), np.argsort(each.frequency)
        height = 1e6 * np.asarray(each.amplitude, float)
        if each.converged is not None:
            height = np.where(np.asarray(each.converged, bool), height, np.nan)
        limit = each.kind in ("free", "stuck")
        traces.append(
            Trace(
                frequency[order],
                height[order],
                each.label,
                dash="dash" if each.kind == "free" else "dot" if limit else "solid",
                width=1.5 if limit else 2.0,
                colour=render_grey() if limit and not each.group else "",
                mode="lines" if each.joined else "lines+markers",
            )
        )
    caption = (
        f"Half the peak-to-peak of {shown.monitor.name}. Dashed and dotted: linear, contacts open "
        "and stuck. Click a name in the legend to hide its curve, twice to see it alone."
    )
    data = [shown.output_files.folder / "figures" / "response.csv"]
    return Plot(traces, "frequency (Hz)", "amplitude (µm)", "Forced response", caption, data=data)


def _models(shown: SceneShown) -> Section:
    scene: Scene = shown.cases[0].scene
    given = gathered(scene)
    pieces = [shown.stages.get(piece_step(scene, name, given)) for name in scene.components]
    system = shown.stages.get(system_step(scene, given=given))
    rows: list[tuple[Cell, ...]] = [
        (
            piece.name,
            scene.components[piece.name].kind,
            len(np.unique(piece.node[piece.node > 0])),
            int(np.sum(piece.node == 0)),
            piece.size,
        )
        for piece in pieces
    ]
    rows.append(("system", "joined", None, None, len(next(iter(system.diameters.values())).K)))
    joints: list[tuple[Cell, ...]] = []
    contacts = system.contacts
    for name in dict.fromkeys(contacts.joint):
        own = np.array([joint == name for joint in contacts.joint])
        ranges = [
            _range(values[own])
            for values in (contacts.kn, contacts.kt[:, 0], contacts.mu, 1e6 * contacts.v0)
        ]
        joints.append((name, int(own.sum()), *ranges))
    return Section(
        "Models",
        [
            Table(("component", "kind", "nodes kept", "modes", "coordinates"), rows, "Sizes"),
            Table(
                ("contacts", "pairs", "kn", "kt", "μ", "interference"),
                joints,
                "Contact properties of the first case",
                ("", "", "N/m", "N/m", "", "µm"),
            ),
        ],
        id="models",
    )


def _range(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _provenance(text: str) -> Section:
    blocks: list[Block] = [
        Text(
            f"Written {written()} by `vanelock run`, from `results.h5` beside this page, which "
            "holds the components, the system and every response with their units."
        ),
        Table(("program", "version"), versions(), "Versions"),
    ]
    if text.strip():
        lines = [(line,) for line in text.rstrip().splitlines()]
        blocks.append(Table(("the scene file",), lines, "As it was given"))
    return Section("Provenance", blocks, id="provenance")
