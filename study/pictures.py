"""The pictures and shape files of a run."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, nonlinear, render, rom
from vanelock.mesh import Part
from vanelock.nonlinear import Response
from vanelock.study.easel import Easel
from vanelock.study.forced import Limit
from vanelock.study.limits import hooks
from vanelock.study.meshes import mesh_step
from vanelock.study.model import Study
from vanelock.study.monitor import Monitor
from vanelock.study.plan import LIMITS, Planned
from vanelock.study.progress import Notice
from vanelock.study.stages import PARTS, model_step
from vanelock.study.steps import Stages
from vanelock.study.summary import Peak
from vanelock.study.sweep import label

DETAILED = 8
"""Cases that get pictures of their own; a larger sweep gets those of the first and the last."""

Floats = NDArray[np.float64]
Shape = NDArray[np.complex128]


@dataclass
class Shown:
    """What the pictures need of the responses, collected while the cases run.

    Attributes
    ----------
    monitor : Monitor
        The displacement in the curves.
    linear : dict of (name, "free" | "stuck") to (frequency, amplitude)
        Linear responses.
    curve : dict of str to (frequency, amplitude, converged)
        Nonlinear responses by case.
    top : dict of str to Response
        The largest point of each case, alone.
    peak : dict of str to Peak
        The same in numbers.
    static : dict of str to Response
        The state at rest.
    harmonics : dict of str to int
        Highest harmonic of each case.
    """

    monitor: Monitor
    linear: dict[tuple[str, Limit], tuple[Floats, Floats]] = field(default_factory=dict)
    curve: dict[str, tuple[Floats, Floats, NDArray[np.bool_]]] = field(default_factory=dict)
    top: dict[str, Response] = field(default_factory=dict)
    peak: dict[str, Peak] = field(default_factory=dict)
    static: dict[str, Response] = field(default_factory=dict)
    harmonics: dict[str, int] = field(default_factory=dict)


@dataclass
class Gallery:
    """All pictures of a run."""

    study: Study
    planned: Sequence[Planned]
    stages: Stages
    shown: Shown
    easel: Easel

    def draw(self) -> list[Path]:
        """Draw them."""
        paths = [self._curves(), *self._preloads()]
        detailed = self._detailed()
        if self.study.outputs.loops:
            paths += [path for each in detailed for path in self._loops(each)]
        if self.study.outputs.shapes:
            paths += self._mesh(self.planned[0])
            paths += self._all_modes()
            paths += [path for each in detailed for path in self._response(each)]
            paths += [self._stress(each) for each in detailed]
        self.easel.tidy()
        return paths

    def _detailed(self) -> list[Planned]:
        """Cases with pictures of their own."""
        cases = [each for each in self.planned if each.case.name in self.shown.top]
        if len(cases) <= DETAILED:
            return cases
        told = f"pictures of loops and shapes for the first and the last of {len(cases)} cases"
        self.easel.listener(Notice(told))
        return [cases[0], cases[-1]]

    def _curves(self) -> Path:
        made = self._linear()
        made += [
            render.Curve(
                *self.shown.curve[each.case.name][:2],
                group=words(each.case.name, without="harmonics"),
                harmonics=self.shown.harmonics[each.case.name],
                converged=self.shown.curve[each.case.name][2],
                joined=each.case.study.response.frequencies is None,
            )
            for each in self.planned
        ]
        keys = [(each.response.key, each.case.name) for each in self.planned]
        monitor = self.shown.monitor.name
        orders = {abs(each.case.study.excitation.engine_order) for each in self.planned}
        order = orders.pop() if len(orders) == 1 else None  # one speed axis, or none
        return self.easel.draw(
            "figures/response.png",
            [keys, monitor, self.study.name],
            lambda path: render.response_curves(
                path, made, f"{self.study.name}: forced response", monitor, engine_order=order
            ),
        )

    def _linear(self) -> list[render.Curve]:
        """Linear limits: equal ones once; without an interlock there is no stuck one."""
        found: list[tuple[list[str], Limit, Floats, Floats]] = []
        for (name, which), (f, a) in self.shown.linear.items():
            if which == "stuck" and not self.study.joints.interlock.enabled:
                continue
            for names, other, *curve in found:
                if other == which and _equal(curve[0], f) and _equal(curve[1], a):
                    names.append(name)
                    break
            else:
                found.append(([name], which, f, a))
        groups = {name for name, _ in self.shown.linear}
        return [
            render.Curve(f, a, kind=which, group="" if len(names) == len(groups) else merged(names))
            for names, which, f, a in found
        ]

    def _preloads(self) -> list[Path]:
        paths, seen = [], set()
        for each in self.planned:
            if each.preload.key in seen:
                continue
            seen.add(each.preload.key)
            paths.append(self._preload(each))
        return paths

    def _preload(self, each: Planned) -> Path:
        static = self.shown.static[each.case.name]
        joints = self.stages.get(each.system).contacts.joint
        suffix = f"_{slug(each.preload_name)}" if each.preload_name else ""
        return self.easel.draw(
            f"figures/preload{suffix}.png",
            [each.preload.key, each.preload_name],
            lambda path: render.preload_picture(
                path,
                static.force[0, 0].real,
                static.mu,
                joints,
                subtitle=words(each.preload_name),
                opened=static.state[0] == nonlinear.OPEN,
                isotropic=static.friction == "isotropic",
            ),
        )

    def _loops(self, each: Planned) -> list[Path]:
        """Loop of the interlock contact that dissipates most at the peak."""
        top, name = self.shown.top[each.case.name], each.case.name
        joints = self.stages.get(each.system).contacts.joint
        own = [i for i, joint in enumerate(joints) if joint == "interlock"]
        sampled = top.samples > 0 and top.friction == "orthogonal"  # no loop is exact then
        if sampled or not own or not top.dissipation[0, own].any():
            return []
        contact = max(own, key=lambda i: float(top.dissipation[0, i]))
        frequency = self.shown.peak[name].frequency
        title = f"Interlock contact {own.index(contact) + 1} at {frequency:.2f} Hz"

        def function(path: Path) -> None:
            displacement, force = nonlinear.contact_loop(top, 0, contact)
            held = np.full(len(force), top.force[0, 0, contact, 0].real)
            render.loop_picture(
                path,
                displacement,
                force,
                float(top.mu[contact]),
                title,
                words(name),
                bounding=held if top.coupling == "constant-load" else None,
                isotropic=top.friction == "isotropic",
            )

        shows = [each.response.key, title, name, self.shown.monitor.name]
        return [self.easel.draw(f"figures/loop_{slug(name)}.png", shows, function)]

    def _mesh(self, each: Planned) -> list[Path]:
        keys = [mesh_step(each.case.study, part).key for part in PARTS]
        title = f"{self.study.name}: mesh"
        return [
            self.easel.draw(
                "figures/mesh.png",
                [keys, title],
                lambda path: render.mesh_picture(path, *self._parts(each), title),
            )
        ]

    def _all_modes(self) -> list[Path]:
        """Modes of each distinct set of linear limits, under the swept values that tell them."""
        groups = [self._mode_key(each) for each in self.planned]
        names = label([each.case for each in self.planned], groups)
        chosen: dict[Any, tuple[Planned, str]] = {}
        for each, group, name in zip(self.planned, groups, names, strict=True):
            chosen.setdefault(group, (each, name))
        distinct = list(chosen.values())
        if len(distinct) > DETAILED:
            told = f"pictures of modes for the first and the last of {len(distinct)} linear limits"
            self.easel.listener(Notice(told))
            distinct = [distinct[0], distinct[-1]]
        return [path for each, name in distinct for path in self._modes(each, name)]

    def _mode_key(self, each: Planned) -> tuple[Any, ...]:
        """What tells modes apart; a load or a damping ratio does not."""
        limits = self.stages.get(each.linear.limits)
        places = limits.nodal_diameter, limits.free_mode, limits.stuck_mode
        parts = tuple(step.key for step in each.rom.values())
        return *parts, *places, limits.free.tobytes(), limits.stuck.tobytes()

    def _modes(self, each: Planned, name: str) -> list[Path]:
        """The mode of interest with the interlock free and stuck."""
        limits = self.stages.get(each.linear.limits)
        k = limits.nodal_diameter
        paths = []
        for which in LIMITS if limits.interlock else LIMITS[:1]:
            place = limits.free_mode if which == "free" else limits.stuck_mode
            frequency = limits.free_frequency if which == "free" else limits.stuck_frequency
            wave = render.wave_name(k, self.study.ring.sectors)
            held = f", interlock {which}" if limits.interlock else ""
            title = f"Mode {place + 1} of {wave}{held}: {frequency:.2f} Hz"

            def coordinates(which: str = which, place: int = place) -> Shape:
                system = self.stages.get(each.linear.system)
                closed = hooks(system.contacts.joint) if which == "free" else None
                shapes = rom.linear_modes(system, k, place + 1, closed)[1]
                return np.asarray(shapes[:, place], complex)

            shows = [each.linear.limits.key, title, name]
            file = f"mode_{which}_{slug(name)}" if name else f"mode_{which}"
            paths += self._shape(file, each, coordinates, k, title, words(name), shows)
        return paths

    def _response(self, each: Planned) -> list[Path]:
        """First harmonic at the peak."""
        name = each.case.name
        top, peak = self.shown.top[name], self.shown.peak[name]
        k = int(top.harmonic_diameters[1])
        title = f"Response at its peak, {peak.frequency:.2f} Hz"
        shows = [each.response.key, title, name, self.shown.monitor.name]
        subtitle = f"{words(name)}, first harmonic"
        return self._shape(
            f"response_{slug(name)}", each, lambda: top.x[1][0], k, title, subtitle, shows
        )

    def _stress(self, each: Planned) -> Path:
        """Von Mises stress of the vane at the peak."""
        name = each.case.name
        top, peak = self.shown.top[name], self.shown.peak[name]
        title = f"Largest von Mises stress in a period, {peak.frequency:.2f} Hz"
        placed = None if each.gauges is None else self.stages.get(each.gauges).positions

        def picture(path: Path) -> None:
            part = self.stages.get(mesh_step(each.case.study, "vane"))
            harmonics = np.stack([self._stresses(each, top, h) for h in range(top.harmonics + 1)])
            total = fem.peak_von_mises(harmonics)
            harmonics[0] = 0
            vibration = fem.peak_von_mises(harmonics)
            gauges = () if placed is None else placed
            render.stress_picture(path, part, total, vibration, title, words(name), gauges)

        shows = [each.response.key, title, name, [] if placed is None else placed.tolist()]
        return self.easel.draw(f"shapes/stress_{slug(name)}.png", shows, picture)

    def _stresses(self, each: Planned, top: Response, h: int) -> Shape:
        """Harmonic h of the vane's nodal stresses at the only point of a response."""
        k = int(top.harmonic_diameters[h])
        parts = [self.stages.get(each.part(part, k)) for part in PARTS]
        coordinates = rom.split(*parts, np.asarray(top.x[h][0], complex))[0]
        return np.asarray(self._recovery(each, "vane", k).stress(coordinates, k))

    def _shape(
        self,
        name: str,
        each: Planned,
        coordinates: Callable[[], Shape],
        k: int,
        title: str,
        subtitle: str,
        shows: Any,
    ) -> list[Path]:
        """Picture and one .vtu file for each part of a displacement field."""
        fields: list[Shape] = []

        def shapes() -> list[Shape]:
            if not fields:
                fields.extend(self._fields(each, coordinates(), k))
            return fields

        def picture(path: Path) -> None:
            draw = render.mode_picture if name.startswith("mode") else render.response_picture
            draw(path, self._parts(each), shapes(), k, title, subtitle)

        paths = [self.easel.draw(f"shapes/{name}.png", shows, picture)]
        for i, part in enumerate(PARTS):

            def write(path: Path, i: int = i) -> None:
                render.write_vtu(path, self._parts(each)[i], shapes()[i])

            paths.append(self.easel.draw(f"shapes/{name}_{part}.vtu", shows, write, quick=True))
        return paths

    def _parts(self, each: Planned) -> list[Part]:
        return [self.stages.get(mesh_step(each.case.study, part)) for part in PARTS]

    def _fields(self, each: Planned, x: Shape, k: int) -> list[Shape]:
        """Displacement of every node of both parts from joined coordinates."""
        components = [self.stages.get(each.part(part, k)) for part in PARTS]
        pieces = rom.split(*components, x)
        return [
            self._recovery(each, part, k).displacement(q, k)
            for part, q in zip(PARTS, pieces, strict=True)
        ]

    def _recovery(self, each: Planned, part: str, k: int) -> rom.Recovery:
        step = each.part(part, k)
        if step.key not in self._recoveries:
            model = self.stages.get(model_step(each.case.study, part))
            self._recoveries[step.key] = rom.recovery(self.stages.get(step), model)
        return self._recoveries[step.key]

    @cached_property
    def _recoveries(self) -> dict[str, rom.Recovery]:
        return {}


def slug(name: str) -> str:
    """A case's name for use in file names."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", name.replace("=", "")).strip("_")


def words(name: str, without: str = "") -> str:
    """A case's name, such as "mu=0.3,harmonics=1", as people write it; one key left out."""
    symbols = {"mu": "μ", "harmonics": "H", "engine_order": "EO"}
    clear = {"coupling": "", "friction": " friction"}  # whose values say what they are
    texts = []
    for text in name.split(","):
        key, _, value = text.partition("=")
        if key in clear:
            texts.append(value + clear[key])
        elif key != without:
            texts.append(f"{symbols.get(key, key)} = {value}" if value else key)
    return ", ".join(texts)


def merged(names: Sequence[str]) -> str:
    """Words for cases that share a curve: the values that differ are listed, equal ones once."""
    values: dict[str, list[str]] = {}
    for name in names:
        for text in words(name).split(", "):
            key, _, value = text.partition(" = ")
            if value not in values.setdefault(key, []):
                values[key].append(value)
    return ", ".join(
        f"{key} = {' or '.join(found)}" if any(found) else key for key, found in values.items()
    )


def _equal(a: Floats, b: Floats) -> bool:
    """Whether two curves are the same but for round-off."""
    return a.shape == b.shape and bool(np.allclose(a, b, rtol=1e-6, atol=0, equal_nan=True))
