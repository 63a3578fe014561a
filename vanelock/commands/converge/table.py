"""What `vanelock converge` found: its table, its text for a page, its picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vanelock import render
from vanelock.common.tables import Column, Table, counted, heads

NAME = "converge"
WORDS = ("response.coupling", "joints.hook.patch")
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
    own : bool
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
    own: bool
    lost: int


def table(found: Sequence[Outcome], name: str) -> Table:
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
            "chosen" if each.own else "",
        )
        for each in found
    ]
    notes = [
        "cost: processor time of the stages that the setting affects, over that of all stages of "
        "the study; off by: relative distance of the peak from the setting's finest value (-)."
    ]
    for each in found:
        if each.lost:
            notes.append(
                f"{each.setting} = {each.value}: {counted(each.lost, 'point')} DID NOT CONVERGE"
            )
    return Table(f"{name}: error against cost", columns, rows, notes, "converge")


def markdown(found: Sequence[Outcome]) -> str:
    """The same as text for a page; the chosen values in bold."""
    lines = [
        "| setting | value | cost | amplitude off by | frequency off by |",
        "|---|---:|---:|---:|---:|",
    ]
    before = ""
    for each in found:
        errors = (
            "" if np.isnan(e) else f"{e:.1e}" for e in (each.amplitude_error, each.frequency_error)
        )
        value = f"**{each.value}**" if each.own else each.value
        setting = f"`{each.setting}`" if each.setting != before else ""
        lines.append(f"| {setting} | {value} | {each.cost:.3f} | {' | '.join(errors)} |")
        before = each.setting
    return "\n".join([*lines, ""])


def draw(path: Path, found: Sequence[Outcome], name: str) -> Path:
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
                    each.own,
                    joined=key not in WORDS and each.value not in ALONE,
                )
                for each in found
                if each.setting == key
            ),
        )
        for key in dict.fromkeys(each.setting for each in found)
    ]
    picture: Path = render.convergence_picture(path, panels, f"{name}: error against cost")
    return picture
