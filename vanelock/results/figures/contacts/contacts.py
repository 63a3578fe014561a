"""Where on the vane contacts stick, slip and open around a resonance, and what each dissipates."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import render
from vanelock.input.cases.names import of_case, slug, words
from vanelock.nonlinear import Response
from vanelock.quantities.run_result import Floats, RunResult
from vanelock.report import Picture
from vanelock.results.figures.contacts.preload import numbers
from vanelock.rom.joining.connections import properties
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.segment import segment_of
from vanelock.stages.plan import Planned

Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Around:
    """The contacts at some points of a response, k of them.

    Attributes
    ----------
    headings : tuple of str
        Where each is, such as "at the peak".
    frequency : (k,) float
        Hz.
    state : (k, c) int
        As of `Response`.
    dissipation : (k, c) float
        J in a cycle.
    """

    headings: tuple[str, ...]
    frequency: Floats
    state: NDArray[np.int64]
    dissipation: Floats

    @classmethod
    def of(cls, response: Response, amplitude: Floats, peak: int) -> "Around":
        """The peak and, on either side, the converged point nearest to half its amplitude."""
        frequency, solved = response.frequency, np.flatnonzero(response.converged)
        chosen, headings = [], []
        for side, heading in ((-1, "below the peak"), (0, "at the peak"), (1, "above the peak")):
            points = solved[np.sign(frequency[solved] - frequency[peak]) == side]
            if side == 0:
                points = np.array([peak])
            if len(points):
                apart = np.abs(amplitude[points] - 0.5 * amplitude[peak])
                chosen.append(int(points[apart.argmin()]))
                headings.append(heading)
        at = np.array(chosen)
        return cls(tuple(headings), frequency[at], response.state[at], response.dissipation[at])


def contacts(run: RunResult, each: Planned) -> Picture:
    """The map of a case's contacts, with its table."""
    name = each.case.name
    response = run.stages.get(each.response)
    around = Around.of(response, run.monitor.amplitude(response), run.peak(name).point)
    title = f"{run.study.name}: contacts around the resonance"
    shows = [each.response.key, title, name, run.monitor.name]

    def places() -> tuple[Integers, Floats, Floats, tuple[str, ...]]:
        """The vane's node of each contact, its place and frame, and its joint."""
        vane, casing = (run.stages.get(each.part(part, 0)) for part in PARTS)
        found = segment_of(each.case.study).assembly(vane, casing).contacts
        nodes = np.concatenate([touching.own_nodes for touching in found])
        frames = np.concatenate([touching.frames for touching in found])
        return nodes, vane.masters.position(nodes), frames, properties(found).joint

    def picture(path: Path) -> None:
        _, positions, frames, joint = places()
        render.contact_map_picture(
            path,
            run.parts(each)[0],
            positions,
            frames,
            joint,
            around.frequency,
            around.state,
            around.dissipation,
            title,
            words(name),
            around.headings,
        )

    def table() -> Mapping[str, ArrayLike]:
        nodes, positions, _, joint = places()
        return columns(around, joint, nodes, positions)

    notes = [f"{title}{of_case(name)}; places on the vane of sector 0; energy of friction a cycle"]
    hertz = around.frequency[around.headings.index("at the peak")]
    caption = (
        f"State of every contact of a sector at the peak, {hertz:.2f} Hz, "
        f"and where the response is about half as large{of_case(name)}. Above: the vane's "
        "interlock face seen along its normal; below: the hooks' bands, unrolled. Colour and shape "
        "show whether a contact sticks, slips or opens in the period, a marker's area the energy "
        "that friction takes there in a cycle; numbers are those of the tables. Large markers in "
        "one corner say that few contacts do the damping, and wear."
    )
    file, heading = f"figures/contacts_{slug(name)}", "Contacts around the resonance"
    return run.picture(file, heading, shows, picture, table, notes, caption)


def columns(
    around: Around, joint: tuple[str, ...], nodes: ArrayLike, positions: Floats
) -> Mapping[str, ArrayLike]:
    """A row for each contact at each frequency: its place, its state and its energy."""
    names = np.array([look[0] for look in render.LOOKS])
    times = len(around.frequency)
    x, y, z = np.tile(1e3 * positions, (times, 1)).T
    return {
        "joint": list(joint) * times,
        "contact": numbers(joint) * times,
        "node of the vane (from 0)": np.tile(nodes, times),
        "x (mm)": x,
        "y (mm)": y,
        "z (mm)": z,
        "at": np.repeat(around.headings, len(joint)),
        "frequency (Hz)": np.repeat(around.frequency, len(joint)),
        "state": names[around.state].ravel(),
        "energy per cycle (µJ)": 1e6 * around.dissipation.ravel(),
    }
