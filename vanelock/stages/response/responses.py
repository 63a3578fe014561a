"""Steps behind the reduced models: linear limits, preload, linear and nonlinear responses.

What holds at rest: closed contacts or nothing, which only press, and what inertia bears.

A response to an accuracy: one point as it was solved, and the curve through all of them.

Which displacement stands for the vibration: one component of one output node.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg as sl

from vanelock import nonlinear
from vanelock.common.arrays import Booleans, Floats
from vanelock.common.cyclic import COMPONENTS
from vanelock.common.errors import InputError
from vanelock.input.cases.values import Problem
from vanelock.input.schema.scene import DAMPING
from vanelock.nonlinear import HarmonicModes, PointStore, Response, StaticBounds
from vanelock.nonlinear.adaptive.interpolant import Interpolant
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import System, linear_stiffness, unheld_motions
from vanelock.stages.response.limits import Limit, Limits, dense, frequencies, limits

SHARPEST = 1e-6
"""Smallest damping ratio of a mode that a linear response resolves."""
Progress: TypeAlias = Callable[[int, int, float, float], None]

READ = ("rom", "excitation", "damping", "response", "campbell")
"""Tables that the frequencies of responses follow from, with the linear limits; a scene lacks two.
"""


@lru_cache(maxsize=SHARED)
def limits_step(
    mode: int,
    system: Step[System],
    names: tuple[str, ...],
    parts: tuple[Step[Any], ...],
    meshed: Step[System] | None,
) -> Step[Limits]:
    """Modes with contacts free and stuck, and their errors by the reduced `parts` and their names.

    A system that is corrected comes with what it was as `meshed`.
    """

    def compute(system: System, *others: Any) -> Limits:
        own = dict(zip(names, others[: len(parts)], strict=True))
        return limits(system, mode, own, *others[len(parts) :])

    needs = (system, *parts, *(() if meshed is None else (meshed,)))
    return step("linear limits", "rom", {"mode": mode}, Limits, needs, compute)


@lru_cache(maxsize=SHARED)
def preload_step(friction: str, system: Step[System], modes: Step[HarmonicModes]) -> Step[Response]:
    """The state at rest; `modes` of harmonic 0 at least."""

    def compute(system: System, stuck: HarmonicModes) -> Response:
        options = nonlinear.Options(friction=friction)
        return nonlinear.static_response(system, options, stuck.diameters)

    needs = (system, modes)
    return step("preload", "nonlinear", {"friction": friction}, Response, needs, compute)


@lru_cache(maxsize=SHARED)
def static_bounds_step(
    friction: str, system: Step[System], modes: Step[HarmonicModes]
) -> Step[StaticBounds]:
    """Between which loads undetermined static friction may hold, at rest, joints that may open."""

    def compute(system: System, stuck: HarmonicModes) -> StaticBounds:
        contacts = system.contacts
        opens = [name for name in contacts.joints if name not in contacts.always_closed]
        options = nonlinear.Options(friction=friction)
        return nonlinear.static_bounds(system, opens, options=options, modes=stuck.diameters)

    inputs = {"friction": friction}
    return step("static bounds", "nonlinear", inputs, StaticBounds, (system, modes), compute)


def linear_step(
    problem: Problem,
    which: Limit,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
) -> Step[Response]:
    """Linear response with contacts free or stuck, dense enough to be drawn as a curve."""
    read = tuple(getattr(problem, name, None) for name in READ)
    return _linear(which, _Alike(read, problem), system, limits, modes)


@dataclass(frozen=True)
class _Alike:
    """A study or scene that equals another with the same frequencies of the same limits."""

    read: tuple[Any, ...]
    problem: Problem = field(compare=False)


@lru_cache(maxsize=SHARED)
def _linear(
    which: Limit,
    alike: _Alike,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
) -> Step[Response]:
    given = alike.problem
    inputs = {**frequency_keys(given), "closed": which}

    def compute(system: System, limits: Limits, stuck: HarmonicModes) -> Response:
        closed = ~system.contacts.opens if which == "free" else "all"
        ratio = system.damping_ratio or DAMPING
        if which == "stuck" and system.opens_in_damping.any():  # its peak is the sharper one
            ratio = float(np.fmax(limits.stuck_damping, SHARPEST))
        grid = dense(frequencies(given, limits), limits, which == "stuck", ratio)
        highest = max([1, *system.force])
        return nonlinear.linear_response(system, grid, closed, highest, stuck.diameters)

    name = f"linear response, {which}"
    return step(name, "nonlinear", inputs, Response, (system, limits, modes), compute)


def response_step(
    name: str,
    problem: Problem,
    system: Step[System],
    limits: Step[Limits],
    modes: Step[HarmonicModes],
    progress: Progress,
    direction: str | None = None,
) -> Step[Response]:
    """Nonlinear response of a case; over a range, where its curve needs points.

    In the file's direction, or another one; upwards where the file wants both.
    """
    options = problem.response.model_dump(include={"harmonics", "coupling", "samples", "friction"})
    options["direction"] = direction or problem.response.direction.replace("both", "up")
    inputs = {**frequency_keys(problem), **options}

    def compute(
        system: System, limits: Limits, stuck: HarmonicModes, store: PointStore
    ) -> Response:
        wanted = frequencies(problem, limits)
        return nonlinear.frequency_response(
            system, wanted, nonlinear.Options(**options), progress, stuck.diameters, store
        )

    needs = (system, limits, modes)
    of = name + (", down" if options["direction"] == "down" else "")
    return step("response", "nonlinear", inputs, Response, needs, compute, resumes=True, of=of)


def frequency_keys(problem: Problem) -> dict[str, Any]:
    """What the choice of frequencies depends on, beside the linear limits."""
    return problem.response.model_dump(include={"frequencies", "range", "points"})


PRESSED = 1e-9
"""Normal force over the largest, that of interference included, that closes a contact; less is
round-off."""
HELD = 1e-10
"""Least stiffness, over that with all contacts closed, that holds."""


def undetermined(system: System, static: Response) -> bool:
    """Whether some motion at rest meets no stiffness but that of contacts that are open.

    Motions that no contact would hold aside.
    """
    normal = static.force[0, 0, :, 0].real
    springs = system.contacts.kn * np.abs(system.contacts.v0)
    largest = max(np.abs(normal).max(initial=0.0), springs.max(initial=0.0))
    closed = normal > PRESSED * largest
    if closed.all():
        return False
    held, stuck = (linear_stiffness(system, 0, which).real for which in (closed, None))
    M = system.at(0).M.real
    moved = M @ unheld_motions(system, 0).real
    held, stuck = (K + stuck.trace() / M.trace() * moved @ moved.T for K in (held, stuck))
    try:
        sl.cholesky(held - HELD * stuck)
    except sl.LinAlgError:
        return True
    return False


def not_held(system: System) -> int:
    """Number of motions of the whole that nothing holds, not even contacts, at rest."""
    return len(unheld_motions(system, system.nodal_diameter(0)).T)


def on_inertia(system: System) -> float:
    """Size of what the inertia of motions that nothing holds balances, over the static load's."""
    k, force = system.nodal_diameter(0), system.force.get(0)
    if force is None or not force.vector.any():
        return 0.0
    M = system.at(k).M
    R = unheld_motions(system, k)
    borne = M @ (R @ (R.conj().T @ force.vector))
    return float(np.linalg.norm(borne) / np.linalg.norm(force.vector))


def constant_loads(system: System) -> dict[str, int]:
    """By joint, contacts across which nothing moves along the normal; only where there are any."""
    k = system.nodal_diameter(1)
    still = ~np.any(system.contact_rows(k)[:, 0], axis=1)
    joints = np.array(system.contacts.joints)[still].tolist()
    return {name: joints.count(name) for name in dict.fromkeys(joints)}


PARTS = 12
"""Pieces of the curve drawn between neighbouring points."""
BEYOND = 0.5
"""How far, of their difference, a curve may leave the range of two points: further is a jump."""


def as_solved(response: Response, point: int) -> Response:
    """A point alone, with the harmonics that it was solved with and no more.

    A response to an accuracy has at every point as many as the most demanding one; what is above a
    point's own is zero there, which the contact law would not say.
    """
    found = response.at([point])
    if found.estimates is None:
        return found
    H = int(found.estimates.harmonics[0])
    kept = slice(H + 1)
    return replace(
        found,
        x={h: x for h, x in found.x.items() if h <= H},
        contact=found.contact[:, kept],
        force=found.force[:, kept],
        output=found.output[:, kept],
        harmonic_diameters=found.harmonic_diameters[kept],
    )


def drawn(response: Response, amplitude: Floats) -> tuple[Floats, Floats, Booleans]:
    """Frequencies, amplitudes and whether they converged, of the curve to draw."""
    plain = response.frequency, amplitude, response.converged
    order = np.argsort(response.frequency, kind="stable")
    f = response.frequency[order]
    if response.estimates is None or not response.converged.all() or len(f) < 3:
        return plain
    if np.any(np.diff(f) <= 0):
        return plain
    a = amplitude[order]
    share = np.arange(PARTS) / PARTS
    fine = (f[:-1, None] + np.diff(f)[:, None] * share).reshape(-1)
    cubic = Interpolant(f, a, response.estimates.slope[order]).at(fine).reshape(-1, PARTS)
    line = a[:-1, None] + np.diff(a)[:, None] * share
    room = BEYOND * np.abs(np.diff(a)) + 0.02 * np.maximum(a[:-1], a[1:])
    low, high = np.minimum(a[:-1], a[1:]) - room, np.maximum(a[:-1], a[1:]) + room
    smooth = np.all((cubic >= low[:, None]) & (cubic <= high[:, None]), axis=1)
    curve = np.where(smooth[:, None], cubic, line).reshape(-1)
    return np.append(fine, f[-1]), np.append(curve, a[-1]), np.ones(len(fine) + 1, bool)


CARTESIAN = ("x", "y", "z")
MOST = 6
"""Output nodes that a message names."""


@dataclass(frozen=True)
class Monitor:
    """A component of an output node.

    Attributes
    ----------
    name : str
        Such as "upper 17, x".
    node, component : int
        Where it is among the outputs.
    """

    name: str
    node: int
    component: int

    def amplitude(self, response: Response) -> Floats:
        """(p,) half the peak-to-peak, m; not a number where a point did not converge."""
        amplitude = response.amplitude[:, self.node, self.component]
        return np.where(response.converged, amplitude, np.nan)


def monitor(name: str | None, system: System, free: Response) -> Monitor:
    """The displacement that a case monitors."""
    node, component = output_of(name, system.output_names, system.sectors)
    at = system.output_names.index(node)
    largest = int(free.amplitude[:, at].max(axis=0).argmax())
    components = COMPONENTS if system.sectors > 1 else CARTESIAN
    place = components.index(component) if component else largest
    return Monitor(f"{node}, {components[place]}", at, place)


def output_of(name: str | None, names: Sequence[str], sectors: int) -> tuple[str, str]:
    """The output node and component, "" where none is named, that `outputs.monitor` means."""
    if not names:
        raise InputError("outputs: the scene has no output nodes: give outputs.nodes or a load")
    components = COMPONENTS if sectors > 1 else CARTESIAN
    node, _, component = (name or names[0]).partition(", ")
    if node not in names or (component and component not in components):
        some = ", ".join(names[:MOST]) + (", ..." if len(names) > MOST else "")
        raise InputError(
            f'outputs.monitor = "{name}": allowed are {some}, and after ", " one of '
            f"{', '.join(components)}"
        )
    return node, component
