"""Pictures of a scene's run with the numbers that they show: curves, preload, loops."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import render
from vanelock.common.files.csv_table import write_columns
from vanelock.input.cases.names import of_case, slug, words
from vanelock.input.cases.scene_cases import SceneCase
from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.step import Stages
from vanelock.quantities.curves_and_fields import Drawn
from vanelock.results.figures.curves import columns
from vanelock.results.figures.figure import Figure
from vanelock.results.figures.loops import Loop
from vanelock.results.figures.preload import columns as preload_columns
from vanelock.results.figures.preload import picture
from vanelock.results.files.redrawn import OutputFiles
from vanelock.stages.response.monitor import Monitor
from vanelock.stages.response.solved import as_solved
from vanelock.stages.response.summary import Peak
from vanelock.stages.scene.monitor import Found
from vanelock.stages.scene.steps import LIMITS

Floats = NDArray[np.float64]

LOOPS = 4
"""Cases whose preloads and loops are drawn: the first ones."""


@dataclass(frozen=True)
class ShownCase:
    """What pictures need of a case."""

    case: SceneCase
    key: str
    curves: dict[str, Drawn]
    peak: Peak | None
    top: Response | None
    static: Response
    joints: tuple[str, ...]
    harmonics: int


@dataclass
class SceneShown:
    """What the pictures of a run are drawn from, collected while its cases run."""

    scene: Scene
    cases: Sequence[SceneCase]
    stages: Stages
    output_files: OutputFiles
    monitor: Monitor = field(default_factory=lambda: Monitor("", 0, 0))
    top: dict[str, ShownCase] = field(default_factory=dict)
    linear: dict[str, tuple[str, Sequence[Response]]] = field(default_factory=dict)
    _preloads: set[str] = field(default_factory=set)

    def is_new(self, preload: str) -> bool:
        """Whether a state at rest, by its key, was not asked about before."""
        new = preload not in self._preloads
        self._preloads.add(preload)
        return new

    def limits_of(self, key: str, name: str, linear: Sequence[Response]) -> str | None:
        """What new linear limits are called, "" for the first; None where they are known."""
        for known, others in self.linear.values():
            same = zip(linear, others, strict=True)
            if all(np.array_equal(a.amplitude, b.amplitude) for a, b in same):
                self.linear[key] = known, others
                return None
        label = name if self.linear else ""
        self.linear[key] = label, linear
        return label

    def add(
        self,
        case: SceneCase,
        key: str,
        response: Response,
        amplitude: Floats,
        peak: Peak | None,
        static: Response,
        joints: tuple[str, ...],
        others: Sequence[Response] = (),
    ) -> None:
        """A case that is done, `others` being its responses in the other direction."""
        top = None if peak is None else as_solved(response, peak.point)
        curves = {
            f"sweeping {r.direction}" if others else "": (
                r.frequency,
                self.monitor.amplitude(r),
                r.converged,
            )
            for r in (response, *others)
        }
        self.top[case.name] = ShownCase(
            case, key, curves, peak, top, static, joints, response.harmonics
        )

    def curves(self) -> list[render.Curve]:
        """Linear limits, then every case."""
        made, seen = [], set()
        for label, linear in self.linear.values():
            if label in seen:
                continue
            seen.add(label)
            for which, each in zip(LIMITS, linear, strict=True):
                amplitude, group = self.monitor.amplitude(each), words(label) if label else ""
                made.append(render.Curve(each.frequency, amplitude, group=group, kind=which))
        for each in self.top.values():
            name = "with friction" if each.case.name == "nominal" else words(each.case.name)
            listed = each.case.scene.response.frequencies is not None
            made += [
                render.Curve(
                    frequency,
                    amplitude,
                    group=name,
                    harmonics=each.harmonics,
                    converged=converged,
                    joined=not listed,
                    variant=direction,
                )
                for direction, (frequency, amplitude, converged) in each.curves.items()
            ]
        return made


def draw(shown: SceneShown, found: Sequence[Found]) -> list[Figure]:
    """All pictures of a run."""
    made = [_curves(shown)]
    preloads: set[bytes] = set()
    for each in shown.top.values():
        held = each.static.force.tobytes()
        if each.joints and held not in preloads and len(preloads) < LOOPS:
            preloads.add(held)
            made.append(_preload(shown, each, len(preloads) > 1))
    for each in list(shown.top.values())[:LOOPS]:
        made += _loop(shown, each)
    return made


def _shows(*more: Any) -> list[Any]:
    return [code_of("results"), *more]


def _curves(shown: SceneShown) -> Figure:
    made, title = shown.curves(), f"{shown.scene.name}: forced response"
    monitor = shown.monitor.name
    shows = _shows([each.key for each in shown.top.values()], list(shown.linear), monitor, title)
    order = abs(shown.scene.excitation.engine_order) if shown.scene.ring.sectors > 1 else None
    path = shown.output_files.draw(
        "figures/response.png",
        shows,
        lambda path: render.response_curves(path, made, title, monitor, engine_order=order),
    )
    notes = [f"{title}, {monitor}: half the peak-to-peak over the excitation frequency"]
    data = _table(shown, "figures/response.csv", shows, lambda: columns(made), notes)
    caption = (
        f"Amplitude of {monitor} (half the peak-to-peak) over the excitation frequency. The thin "
        "lines are the linear limits, with all contacts open and with all stuck; the others are "
        "the responses with friction, each with a marker at its peak."
    )
    return Figure(path, "Forced response", caption, (data,))


def _preload(shown: SceneShown, each: ShownCase, several: bool) -> Figure:
    static, name = each.static, each.case.name
    suffix = f"_{slug(name)}" if several else ""
    shows = _shows(each.key, name)
    path = shown.output_files.draw(
        f"figures/preload{suffix}.png",
        shows,
        lambda path: picture(path, static, each.joints, words(name) if several else ""),
    )
    data = _table(
        shown, f"figures/preload{suffix}.csv", shows, lambda: preload_columns(static, each.joints)
    )
    caption = (
        f"Contact forces at rest, from interference and static load alone{of_case(name)}. Above: "
        "normal force of each contact. Below: friction over its bound, |t| / (μ n)."
    )
    return Figure(path, f"Preload of the contacts{of_case(name)}", caption, (data,))


def _loop(shown: SceneShown, each: ShownCase) -> list[Figure]:
    """The loop of the contact that takes most energy."""
    top, name = each.top, each.case.name
    if top is None or each.peak is None or not top.dissipation.any():
        return []
    if top.samples > 0 and top.friction == "orthogonal":  # no loop is exact then
        return []
    contact = int(top.dissipation[0].argmax())
    loop, joint = Loop(top, contact), each.joints[contact]
    number = list(each.joints[: contact + 1]).count(joint)
    heading = f"Contact {number} of {joint}"
    title = f"{heading} at {each.peak.frequency:.2f} Hz"
    shows = _shows(each.key, title, name)
    path = shown.output_files.draw(
        f"figures/loop_{slug(name)}.png",
        shows,
        lambda path: render.loop_picture(
            path,
            *loop.history,
            loop.mu,
            title,
            words(name),
            bounding=loop.bounding,
            isotropic=loop.isotropic,
        ),
    )
    notes = [f"{shown.scene.name}: {title}{of_case(name)}, one period"]
    data = _table(shown, f"figures/loop_{slug(name)}.csv", shows, loop.columns, notes)
    caption = (
        f"{heading}, the one that turns most energy into heat, over one period at the peak"
        f"{of_case(name)}. Left: friction over sliding; the area inside is the energy lost in a "
        "cycle. Right: normal force and friction over the period."
    )
    title = f"Hysteresis of contact {number} of {joint}{of_case(name)}"
    return [Figure(path, title, caption, (data,))]


def _table(
    shown: SceneShown,
    name: str,
    shows: Any,
    made: Any,
    notes: Sequence[str] = (),
) -> Any:
    def write(path: Any) -> None:
        found: Mapping[str, ArrayLike] = made()
        write_columns(path, found, notes)

    return shown.output_files.draw(name, [shows, list(notes)], write, quick=True)
