"""Contacts of a run: at rest, their loops, and their states around a resonance."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vanelock import nonlinear, render
from vanelock.common.arrays import Floats, Integers
from vanelock.input.cases.names import of_case, slug, words
from vanelock.nonlinear import Response
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.contacts import exact
from vanelock.quantities.run_result import DETAILED, RunResult, named
from vanelock.report import Picture
from vanelock.rom.joining.connections import properties
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.outputs import tangents
from vanelock.stages.parts.segment import segment_of


def preloads(run: RunResult) -> list[Picture]:
    """One for each distinct preload."""
    found: dict[str, Picture] = {}
    distinct = {each.key_at("preload") for each in run.cases.values()}
    for each in run.cases.values() if len(distinct) <= DETAILED else named(run):
        key = each.key_at("preload")
        if key not in found and each.system.contacts.springs.any():
            found[key] = _preload(run, each)
    return list(found.values())


def _preload(run: RunResult, case: CaseResult) -> Picture:
    static, joints = case.static, case.system.contacts.joints
    name = case.preload_name
    suffix = f"_{slug(name)}" if name else ""
    shows = [case.key_at("preload"), name]
    names = {joint: tangents(run.problem, joint) for joint in joints}
    caption = (
        f"Contact forces at rest, nothing vibrating{of_case(name)}. Above: normal force "
        "of each contact of a sector. Below: friction over its bound, |t| / (μ n): 1 where the "
        "contact slid while the parts were assembled. An open contact carries nothing and cannot "
        "damp; the spread of the normal forces shows how unevenly a joint will slip."
    )

    def draw(path: Path) -> None:
        force, used = _at_rest(static)
        render.preload_picture(path, force[:, 0], used, joints, words(name))

    return run.picture(
        f"figures/preload{suffix}",
        "Preload of the contacts",
        shows,
        draw,
        lambda: _preload_columns(static, joints, names),
        (),
        caption,
    )


def _at_rest(static: Response) -> tuple[Floats, Floats]:
    """Forces (c, 3) at rest, N, open contacts without what round-off leaves there; utilisation."""
    opened = static.state[0] == nonlinear.OPEN
    force = np.where(opened[:, None], 0.0, static.force[0, 0].real)
    return force, render.utilisation(force, static.mu, static.friction == "isotropic")


def _preload_columns(
    static: Response, joints: tuple[str, ...], names: Mapping[str, tuple[str, str]]
) -> Mapping[str, ArrayLike]:
    """Contact by contact: joint, number in its joint, state, forces in directions with names."""
    force = static.force[0, 0].real
    states = np.array(["sticks", "slid at assembly", "open"])
    opened, used = static.state[0] == nonlinear.OPEN, _at_rest(static)[1]
    slid = np.nan_to_num(used) >= 1 - 1e-6
    return {
        "joint": joints,
        "contact": _numbers(joints),
        "state": states[np.where(opened, 2, np.where(slid, 1, 0))],
        "normal force n (N)": force[:, 0],
        "direction 1": [names[joint][0] for joint in joints],
        "friction force 1 (N)": force[:, 1],
        "direction 2": [names[joint][1] for joint in joints],
        "friction force 2 (N)": force[:, 2],
        "friction coefficient mu (-)": static.mu,
        "friction utilisation |t| / (mu n) (-)": used,
    }


def _numbers(joints: tuple[str, ...]) -> list[int]:
    """Each contact's number in its joint, from 1, as pictures and tables count."""
    return [joints[: i + 1].count(joint) for i, joint in enumerate(joints)]


@dataclass(frozen=True)
class Loop:
    """A contact's period at the only point of a response.

    Attributes
    ----------
    top : Response
        One point.
    contact : int
        Which contact.
    tangents : (str, str)
        What its friction directions are called.
    """

    top: Response
    contact: int
    tangents: tuple[str, str]

    @cached_property
    def history(self) -> tuple[Floats, Floats]:
        """(s, 3) displacements, m, and forces, N, at equal steps of the period."""
        found: tuple[Floats, Floats] = nonlinear.contact_loop(self.top, 0, self.contact)
        return found

    @property
    def mu(self) -> float:
        """Friction coefficient."""
        return float(self.top.mu[self.contact])

    @property
    def load(self) -> Floats:
        """(s,) normal force that bounds friction, N: the instant's, or that at rest."""
        load = self.history[1][:, 0]
        if self.top.coupling != "constant-load":
            return load
        return np.full(len(load), self.top.force[0, 0, self.contact, 0].real)

    def columns(self) -> Mapping[str, ArrayLike]:
        """The period as columns."""
        u, f = self.history
        return {
            "time / period (-)": np.arange(len(u)) / len(u),
            "normal displacement v (µm)": 1e6 * u[:, 0],
            **{f"displacement, {d} (µm)": 1e6 * u[:, i + 1] for i, d in enumerate(self.tangents)},
            "normal force n (N)": f[:, 0],
            **{f"friction force, {d} (N)": f[:, i + 1] for i, d in enumerate(self.tangents)},
            "friction limit mu n (N)": self.mu * self.load,
        }


def loops(run: RunResult, result: CaseResult) -> list[Picture]:
    """The loop of a case, where there is one."""
    top, name = result.top, result.name
    contacts = result.system.contacts
    own = np.flatnonzero(contacts.opens & contacts.springs).tolist()
    if not exact(top) or not own or not top.dissipation[0, own].any():
        return []
    contact = max(own, key=lambda i: float(top.dissipation[0, i]))
    joint = contacts.joints[contact]
    loop = Loop(top, contact, tangents(run.problem, joint))
    frequency = result.at_peak.frequency
    heading = f"contact {contacts.joints[: contact + 1].count(joint)} of {joint}"
    title = f"C{heading[1:]} at {frequency:.2f} Hz"
    shows = [result.key_at("response"), title, name, run.monitor.name]

    def draw(path: Path) -> None:
        period = *loop.history, loop.load, loop.mu
        isotropic = top.friction == "isotropic"
        render.loop_picture(path, *period, title, words(name), isotropic, loop.tangents)

    notes = [f"{run.problem.name}: {title}{of_case(name)}, one period"]
    caption = (
        f"C{heading[1:]}, the one that dissipates most, over one "
        f"period at the peak, {frequency:.2f} Hz{of_case(name)}. Left: friction force over "
        "relative displacement; the enclosed area is the energy dissipated per cycle. On the "
        "dashed limits ±μn the contact slips, on the steep flanks it sticks. Right: normal and "
        "friction force over the period; the limits follow the normal force."
    )
    file, heading = f"figures/loop_{slug(name)}", f"Hysteresis of {heading}"
    return [run.picture(file, heading, shows, draw, loop.columns, notes, caption)]


@dataclass(frozen=True)
class _Around:
    """The contacts (c,) at k points of a response: where these are, Hz, states, J in a cycle."""

    headings: tuple[str, ...]
    frequency: Floats
    state: Integers
    dissipation: Floats

    @classmethod
    def of(cls, response: Response, amplitude: Floats, peak: int) -> "_Around":
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


def contacts(run: RunResult, result: CaseResult) -> Picture:
    """The map of a case's contacts, with its table."""
    name = result.name
    response = result.response
    around = _Around.of(response, run.monitor.amplitude(response), result.at_peak.point)
    title = f"{run.study.name}: contacts around the resonance"
    shows = [result.key_at("response"), title, name, run.monitor.name]

    def places() -> tuple[Integers, Floats, Floats, tuple[str, ...]]:
        """The vane's node of each contact, its place and frame, and its joint."""
        vane, casing = map(result.component, PARTS)
        found = segment_of(result.study).assembly(vane, casing).contacts
        nodes = np.concatenate([touching.own_nodes for touching in found])
        frames = np.concatenate([touching.frames for touching in found])
        return nodes, vane.masters.position(nodes), frames, properties(found).joint

    def picture(path: Path) -> None:
        _, positions, frames, joint = places()
        render.contact_map_picture(
            path,
            result.parts[0],
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
        return _contact_columns(around, joint, nodes, positions)

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


def _contact_columns(
    around: _Around, joint: tuple[str, ...], nodes: ArrayLike, positions: Floats
) -> Mapping[str, ArrayLike]:
    """A row for each contact at each frequency: its place, its state and its energy."""
    names = np.array([look[0] for look in render.LOOKS])
    times = len(around.frequency)
    x, y, z = np.tile(1e3 * positions, (times, 1)).T
    return {
        "joint": list(joint) * times,
        "contact": _numbers(joint) * times,
        "node of the vane (from 0)": np.tile(nodes, times),
        "x (mm)": x,
        "y (mm)": y,
        "z (mm)": z,
        "at": np.repeat(around.headings, len(joint)),
        "frequency (Hz)": np.repeat(around.frequency, len(joint)),
        "state": names[around.state].ravel(),
        "energy per cycle (µJ)": 1e6 * around.dissipation.ravel(),
    }
