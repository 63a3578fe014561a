"""The settings of a study that trade speed for error, and the table of what raising them changed.

A setting is raised alone, all others as the study has them. Its finest value stands for the truth:
what is measured against it says nothing of the other settings, nor of what the finest one misses.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from vanelock import render
from vanelock.common.checked import show
from vanelock.common.errors import InputError
from vanelock.common.tables import Column, Table, counted, heads
from vanelock.input.cases.values import value_at, with_values
from vanelock.input.schema.structure.structure import ACCURACY
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study
from vanelock.input.settings import same
from vanelock.mesh.element_size import LARGEST, SMALLEST, element_size, words_of
from vanelock.mesh.geometry.dimensions import CasingDimensions, VaneDimensions
from vanelock.nonlinear.contact.sampling import least_samples
from vanelock.stages.accuracy.mesh_sizes import unknowns

DOFS = 150_000
"""Default limit of the estimated degrees of freedom of the meshes of both parts."""
STEP = 2**0.5
"""From one element size to the next."""
COARSEST = 0.025
"""Largest elements tried, m, unless the study has larger ones; larger ones change little."""


POINTS = "response.points"
"""The setting that varies the frequencies themselves: the peak is then the largest of them, not
located between them."""

_Values = Iterable[tuple[str, dict[str, Any]]]
"""Of a setting: each in words, and the keys that are changed for it."""


class Level(NamedTuple):
    """A value of a setting in words, the study with it, and whether the study has it anyway."""

    shown: str
    study: Study
    chosen: bool


def settings_of(
    study: Study, dofs: float = DOFS, names: Sequence[str] = ()
) -> dict[str, list[Level]]:
    """The settings that a study has, or those named, from rough to fine: the last is the truth."""
    every = {key: _levels(study, values) for key, values in _every(study, dofs)}
    every = {key: levels for key, levels in every.items() if len(levels) > 1}
    for name in names:
        if name not in every:
            raise InputError(f"--setting {show(name)}: this study has {', '.join(every)}")
    return {key: levels for key, levels in every.items() if not names or key in names}


def _every(study: Study, dofs: float) -> Iterator[tuple[str, _Values]]:
    if isinstance(study.vane, VaneDimensions) and isinstance(study.casing, CasingDimensions):
        yield "mesh.size", [_size(study, s) for s in _sizes(study, dofs)]
    yield _reductions(study)
    response, H = study.response, study.response.harmonics
    least = {h: least_samples(h) for h in (1, 2, 3, 5, 7, 9, H, 2 * H - 1 if H > 4 else 9)}
    sampled = response.samples
    harmonics = sorted(h for h, count in least.items() if sampled is None or sampled >= count)
    yield "response.harmonics", _of("response.harmonics", harmonics)
    if response.friction == "orthogonal":
        counts = {2**i for i in range(5, 11) if 2**i >= least[H]}
        counts |= set() if sampled is None else {sampled}
        key = "response.samples"
        yield key, [*_of(key, sorted(counts)), ("located", {key: None})]
    if response.frequencies is None:  # even ones, each step half of the one before, or adaptive
        even = _of(POINTS, sorted({*(20 * 2**i + 1 for i in range(7)), response.points or 21}))
        yield POINTS, [*even[:-1], ("adaptive", {POINTS: None}), even[-1]]
    words = ("constant-load", "uncoupled", "coupled")
    yield "response.coupling", _of("response.coupling", words)
    own, key = set(study.patches.values()), "joints.patch"
    yield key, [(word, {} if own == {word} else {key: word}) for word in ("node", "area")]


def _of(key: str, values: Iterable[Any]) -> list[tuple[str, dict[str, Any]]]:
    """Values of one key."""
    return [(str(value), {key: value}) for value in values]


def _sizes(study: Study, dofs: float) -> list[Any]:
    """Element sizes from large to small, the study's own among them, up to the largest meshes."""
    own = study.mesh.size
    largest = max(element_size(own, part) for part in ("vane", "casing"))
    found: list[Any] = [own]
    coarser = largest * STEP
    while coarser <= min(max(COARSEST, largest), LARGEST) * 1.02:
        found.insert(0, float(f"{coarser:.3g}"))
        coarser *= STEP
    finer = min(element_size(own, part) for part in ("vane", "casing")) / STEP
    while finer >= SMALLEST and unknowns(study, finer) <= dofs:
        found.append(float(f"{finer:.3g}"))
        finer /= STEP
    return found


def _size(study: Study, size: Any) -> tuple[str, dict[str, Any]]:
    shown = words_of(size)
    if size == study.mesh.size:
        return shown, {"mesh.size": size}
    return shown, {"mesh.size": size, "mesh.face_nodes": None}  # no other mesh has so many


def _reductions(study: Study) -> tuple[str, _Values]:
    """Accuracy of the reduced parts, or their numbers of modes."""
    own, options = study.rom, [study.rom.of(part) for part in PARTS]
    levels: list[tuple[str, dict[str, Any]]] = []
    if "modes" not in options[0]:
        accuracy = ACCURACY if own.accuracy is None else own.accuracy
        for a in sorted({1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, accuracy}, reverse=True):
            is_own = own.accuracy is None and a == accuracy
            levels.append((f"{a:g}", {} if is_own else {"rom.accuracy": a}))
        return "rom.accuracy", levels
    for factor in (0.5, 1, 2, 4):
        pair = tuple(max(int(factor * (each["modes"] or 1)), 1) for each in options)
        shown = f"{pair[0]}" if pair[0] == pair[1] else f"{pair[0]} + {pair[1]}"
        levels.append((shown, {} if factor == 1 else {"rom.modes": pair}))
    return "rom.modes", levels


def _levels(study: Study, values: _Values) -> list[Level]:
    """Those of a setting's values that the study can have."""
    levels = []
    for shown, changes in values:
        own = all(same(value_at(study, name), value) for name, value in changes.items())
        try:
            changed = study if own else with_values(study, changes)
        except ValidationError:
            continue  # such as patches of a part that has no dimensions
        levels.append(Level(shown, changed, own))
    return levels


NAME = "converge"
WORDS = ("response.coupling", "joints.patch")
"""Settings whose values are no sequence."""
ALONE = ("adaptive", "located")
"""Values that are no members of their sequence."""


@dataclass(frozen=True)
class Outcome:
    """A value of a setting, and what came of it.

    Attributes
    ----------
    setting, value : str
        Key and value.
    cost : float
        Processor time of the affected stages, over that of all stages of the study as it is.
    cpu : float
        The same, s.
    amplitude, frequency : float
        Of the peak, m and Hz; NaN where no point converged.
    amplitude_error, frequency_error : float
        Relative distance from the finest value; NaN for that one, and where one of them is lost.
    chosen : bool
        Whether the study has this value.
    lost : int
        Points that did not converge.
    """

    setting: str
    value: str
    cost: float
    cpu: float
    amplitude: float
    frequency: float
    amplitude_error: float
    frequency_error: float
    chosen: bool
    lost: int


def table(outcomes: Sequence[Outcome], name: str) -> Table:
    """A line for each value of each setting."""
    columns = (
        *heads("setting", "value"),
        Column("cost", form=".3f"),
        Column("amplitude off by", form=".1e", key="amplitude_error"),
        Column("frequency off by", form=".1e", key="frequency_error"),
        Column("chosen", key="own"),
    )
    rows = [
        (
            *(each.setting, each.value, each.cost, each.amplitude_error, each.frequency_error),
            "chosen" if each.chosen else "",
        )
        for each in outcomes
    ]
    notes = [
        "cost: processor time of the stages that the setting affects, over that of all stages of "
        "the study; off by: relative distance of the peak from the setting's finest value (-)."
    ]
    for each in outcomes:
        if each.lost:
            notes.append(
                f"{each.setting} = {each.value}: {counted(each.lost, 'point')} DID NOT CONVERGE"
            )
    return Table(f"{name}: error against cost", columns, rows, notes, "converge")


def markdown(outcomes: Sequence[Outcome]) -> str:
    """The same as text for a page; the chosen values in bold."""
    lines = [
        "| setting | value | cost | amplitude off by | frequency off by |",
        "|---|---:|---:|---:|---:|",
    ]
    before = ""
    for each in outcomes:
        errors = (
            "" if np.isnan(e) else f"{e:.1e}" for e in (each.amplitude_error, each.frequency_error)
        )
        value = f"**{each.value}**" if each.chosen else each.value
        setting = f"`{each.setting}`" if each.setting != before else ""
        lines.append(f"| {setting} | {value} | {each.cost:.3f} | {' | '.join(errors)} |")
        before = each.setting
    return "\n".join([*lines, ""])


def draw(path: Path, outcomes: Sequence[Outcome], name: str) -> Path:
    """A panel for each setting: both errors against cost."""
    panels = [
        render.Panel(
            key,
            tuple(
                render.MeasuredValue(
                    each.value,
                    each.cost,
                    each.amplitude_error,
                    each.frequency_error,
                    each.chosen,
                    joined=key not in WORDS and each.value not in ALONE,
                )
                for each in outcomes
                if each.setting == key
            ),
        )
        for key in dict.fromkeys(each.setting for each in outcomes)
    ]
    picture: Path = render.convergence_picture(path, panels, f"{name}: error against cost")
    return picture
