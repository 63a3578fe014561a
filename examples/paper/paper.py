"""Every figure and every statement of Lassalle and Firrone's vane segment, for a study of yours.

    python examples/paper/paper.py [study.toml] [--output folder] [--workers N]

The study gives the scene, the load, and the friction and interference that all is varied around.
Its cases are one sweep with a page of its own, `cases/report.html`. They and maps of peaks make the
figures, a table of what the published study states and what is found here, `statements.csv`, and a
page with all of it, `paper.md`. The values below go with `study.toml` beside this script.
"""

import argparse
import csv
import itertools
import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from numpy.typing import ArrayLike, NDArray

import vanelock
from vanelock import nonlinear
from vanelock.nonlinear import Contact, Options, Response, System

matplotlib.use("Agg")  # draws without a screen
import matplotlib.pyplot as plt

# What figures are drawn for; interference in m. Figures 14 and 16 take the largest friction.
MU = (0.1, 0.12, 0.135, 0.15)  # Figures 12 and 15
INTERFERENCE = (1.8e-6, 1.9e-6, 2e-6)  # Figures 14 and 16
HARMONICS = (1, 3, 5)  # Figure 13
# Maps of the study's own slant; those of other slants have coarser meshes and fewer cells.
MAP_MU = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0)
MAP_INTERFERENCE = (0.5e-6, 1e-6, 2e-6, 4e-6, 8e-6, 16e-6)
MAP_LOAD = (0.5, 0.7, 1.0, 1.5, 3.0, 6.0)  # factors of the study's
SLANTS = (0.0, 15.0, 25.0, 45.0)  # of the interlock faces, degrees
SLANT_MU, SLANT_INTERFERENCE = (0.05, 0.2, 0.35, 1.0), (0.5e-6, 2e-6, 4e-6, 16e-6)
RIDGE_HARMONICS, RIDGE_POINTS = (1, 3), 25  # peaks along each, half a decade beyond the maps

COUPLINGS = ("coupled", "uncoupled", "constant-load")
DIRECTIONS = ("radial", "circumferential", "axial")
APART = -1e-3  # interference of an interlock that never touches, m
ONE, UNCOUPLED, CONSTANT = FEW = tuple(Options(1, coupling=each) for each in COUPLINGS)
COINCIDENT, SLIGHT, NONE, LITTLE = 1e-6, 0.1, 0.01, 0.1  # what these words are taken to mean

Floats = NDArray[np.float64]
Chosen = NDArray[np.bool_]


class Solved(NamedTuple):
    """A response at the monitored output, and its peak: the largest point that converged."""

    response: Response
    curve: Floats  # amplitude, m; NaN where the point did not converge
    top: int  # the peak's point, amplitude, m, and frequency, Hz
    amplitude: float
    frequency: float
    within: bool  # whether it lies within the range and its neighbours converged, too


def solved(response: Response, output: tuple[int, int]) -> Solved:
    """A response, read at an output node and direction."""
    curve = np.where(response.converged, response.amplitude[:, *output], np.nan)
    top = int(np.nan_to_num(curve, nan=-1.0).argmax())
    within = top > 0 and response.converged[top - 1 : top + 2].sum() == 3
    return Solved(response, curve, top, float(curve[top]), float(response.frequency[top]), within)


@dataclass(frozen=True)
class Model:
    """A system, the range of frequencies in which its peak lies, Hz, and the monitored output."""

    system: System
    near: tuple[float, float]
    output: tuple[int, int]
    modes: Any = None  # with all contacts stuck: no parameter below moves them

    def changed(
        self, mu: float | None = None, interference: float | None = None, load: float = 1.0
    ) -> "Model":
        """With other friction or interference, m, of the interlock, or a factor of the load."""
        contacts, force = self.system.contacts, self.system.force
        pairs = contacts.of("interlock")
        if mu is not None:
            contacts = replace(contacts, mu=np.where(pairs, mu, contacts.mu))
        if interference is not None:
            contacts = replace(contacts, v0=np.where(pairs, interference, contacts.v0))
        force = {h: replace(f, vector=load * f.vector) if h else f for h, f in force.items()}
        return replace(self, system=replace(self.system, contacts=contacts, force=force))

    def prepared(self, harmonics: int) -> "Model":
        """With its modes, for as many harmonics."""
        return replace(self, modes=nonlinear.harmonic_modes(self.system, harmonics).diameters)

    def solve(self, method: Options, hertz: Any = None) -> Solved:
        """The response over the range, or at frequencies."""
        more = {"modes": self.modes, "find_jumps": False}
        hertz = self.near if hertz is None else hertz
        return solved(nonlinear.frequency_response(self.system, hertz, method, **more), self.output)


# --- Cases: one sweep ---


class Case(NamedTuple):
    """What a case changes of the study: friction and interference of the interlock, the method."""

    mu: float
    interference: float
    method: Options = ONE


def figures_of(reference: Case) -> dict[str, list[Case]]:
    """The cases of each figure, in the order in which they are drawn; that one is the study's."""
    higher = [Options(h) for h in HARMONICS]
    same = [Options(h, harmonic_diameters="sector") for h in HARMONICS[1:]]
    return {
        "reference": [reference],
        "hooks": [reference._replace(interference=APART)],
        "friction": [reference._replace(mu=mu, method=each) for mu in MU for each in FEW],
        "harmonics": [reference._replace(method=each) for each in higher],
        "one diameter": [reference._replace(method=each) for each in same],
        "interference": [Case(MU[-1], value, each) for value in INTERFERENCE for each in FEW],
    }


@dataclass(frozen=True)
class Scene:
    """What was run: the study, its cases and linear limits, and the model that they share."""

    study: vanelock.Study
    reference: Case  # the study's, at one harmonic
    figures: Mapping[str, Sequence[Case]]
    cases: Mapping[Case, Solved]
    waves: Mapping[Case, str]
    linear: Mapping[str, Solved]  # "free" and "stuck"
    mode: int  # of interest, and its frequencies "free" and "stuck", Hz
    modes: Mapping[str, float]
    model: Model
    monitor: str

    @property
    def pairs(self) -> Chosen:
        """Contacts of the interlock; the others are the hooks'."""
        return np.asarray(self.model.system.contacts.opens)

    def coupled(self, figure: str) -> list[Case]:
        """The coupled cases of a figure."""
        return [case for case in self.figures[figure] if case.method == ONE]

    def stable(self, cases: Iterable[Case]) -> str:
        """How many of some cases' waves are stable, in words; "" where that was not asked for."""
        waves = [self.waves[case] for case in cases if self.waves[case]]
        return ", ".join(f"{waves.count(word)} {word}" for word in sorted(set(waves)))


KEYS = ("joints.interlock.mu", "joints.interlock.interference", "response.harmonics")
DEFAULTS = ("coupling", "friction", "direction", "samples", "frequencies")


def check(study: vanelock.Study) -> None:
    """Refuse what would not be all cases' own, and an interlock that does not touch."""
    wrong = [key for key in ("sweep", "rows", "scatter", "accuracy") if getattr(study, key)]
    response, usual = study.response, type(study.response)()
    wrong += [
        f"response.{key}" for key in DEFAULTS if getattr(response, key) != getattr(usual, key)
    ]
    lock = study.joints.interlock
    wrong += [] if lock and lock.interference > 0 else [f"{KEYS[1]} <= 0"]
    if wrong:
        raise SystemExit(f"{', '.join(wrong)}: a study for this script is without")


def run_cases(study: vanelock.Study, folder: Path, workers: int) -> Scene:
    """Run the study's coupled cases as one sweep, but for `[bounds]`; solve the others."""
    check(study)
    lock = study.joints.interlock
    figures = figures_of(Case(lock.mu, lock.interference))
    cases = list(dict.fromkeys(itertools.chain(*figures.values())))
    swept = [case for case in cases if case.method == Options(case.method.harmonics)]
    values = [(case.mu, case.interference, case.method.harmonics) for case in swept]
    rows = dict(zip(KEYS, zip(*values, strict=True), strict=True))
    run = run_study(study, folder, workers, rows=rows, bounds=None)
    by_values = {tuple(c.values[key] for key in KEYS): c for c in run.contents.cases.values()}
    named = {case: by_values[value] for case, value in zip(swept, values, strict=True)}
    with vanelock.open_results(folder / "results.h5") as file:
        read = {name: Response.load(group) for name, group in file["response"].items()}
        limits = file["limits/all"]
        place = {which: int(limits[f"{which}_mode"][()]) for which in ("free", "stuck")}
        modes = {which: float(limits[which][place[which]]) for which in place}
    reference, most = cases[0], named[cases[0]._replace(method=Options(max(HARMONICS)))]
    system, near = run.system(most.name), ends(named[reference].line[0])
    node, _, direction = run.monitor.rpartition(", ")
    output = system.output_names.index(node), DIRECTIONS.index(direction)
    model = Model(system, near, output)
    found = {case: solved(read[each.name], output) for case, each in named.items()}
    ready = model.prepared(1)
    for case in (case for case in cases if case not in named):
        found[case] = ready.changed(*case[:2]).solve(case.method)
    return Scene(
        study=study,
        reference=reference,
        figures=figures,
        cases=found,
        waves={case: getattr(each.summary.wave, "verdict", "") for case, each in named.items()},
        linear={which: solved(read[which], output) for which in modes},
        mode=place["free"] + 1,
        modes=modes,
        model=model,
        monitor=run.monitor,
    )


def ends(frequency: Floats) -> tuple[float, float]:
    """The first and the last, Hz."""
    return float(frequency[0]), float(frequency[-1])


def run_study(study: vanelock.Study, folder: Path, workers: int, **tables: Any) -> vanelock.Run:
    """Run a study with some of its tables replaced; all of its cases count."""
    with vanelock.choose_listener(quiet=False, as_json=False) as listener:
        vanelock.run_study(study.model_copy(update=tables), folder, listener, workers=workers)
    run = vanelock.load(folder)
    if run.failed:
        raise SystemExit(f"{folder}: could not be computed: {dict(run.failed)}")
    return run


# --- Figures 10 and 11: full stick ---


class Apart(NamedTuple):
    """How far a response is from another at the same frequencies."""

    vibration: float  # of the harmonics h >= 1 of any output, over the largest
    mean: float  # of the mean forces of some contacts, over the largest
    slipping: int  # of these, how many slip or open at any frequency


def apart(one: Response, other: Response, contacts: Chosen) -> Apart:
    """Two responses, as far as some contacts go."""
    count = min(one.harmonics, other.harmonics) + 1
    vibration = [each.output[:, 1:count] for each in (one, other)]
    mean = [each.force[:, 0, contacts].real for each in (one, other)]
    off, mean_off = (float(np.abs(a - b).max() / np.abs(b).max()) for a, b in (vibration, mean))
    return Apart(off, mean_off, int((one.state[:, contacts] != nonlinear.STUCK).any(axis=0).sum()))


def hooks_alone(scene: Scene) -> Apart:
    """Hooks in friction, the interlock apart, against the linear response."""
    (case,), hooks = scene.figures["hooks"], ~scene.pairs
    system, response = scene.model.changed(*case[:2]).system, scene.cases[case].response
    return apart(response, nonlinear.linear_response(system, response.frequency, hooks), hooks)


def sticking_load(system: System, stuck: Response) -> float:
    """Factor of the load at which all pairs stick in every period, to two digits.

    A slider at its bound gives way once and then sticks where the bounds leave room for all of the
    motion, kt |u| + μ |n| <= μ n0, with linear amplitudes at their worst; half of that is taken.
    """
    at_rest, force = nonlinear.static_response(system), np.abs(stuck.force[:, 1]).max(axis=0)
    needed = force[:, 1:].max(axis=1) + at_rest.mu * force[:, 0]
    bound = at_rest.mu * at_rest.force[0, 0, :, 0].real
    chosen = system.contacts.opens & (needed > 0)
    room = float(np.clip(0.5 * (bound[chosen] / needed[chosen]).min(), 1e-6, 1.0))
    digits = 10.0 ** (1 - np.floor(np.log10(room)))
    return float(np.floor(room * digits) / digits)


def all_stuck(model: Model) -> tuple[dict[Options, Solved], dict[Options, Apart]]:
    """Responses by method, and how far the coupled one is from each of the others."""
    model, every = model.prepared(1), model.system.contacts.springs
    curves = {each: model.solve(each) for each in FEW}
    one = curves[ONE].response
    others = {each: model.solve(each, one.frequency).response for each in FEW[1:]}
    return curves, {each: apart(one, other, every) for each, other in others.items()}


# --- Figure 8: the contact element under given motion, equations (8) to (10) ---

LOOPS = {"in phase": (0.6, 0.0), "partial lift-off": (1.6, 0.0), "out of phase": (0.6, 90.0)}
"""Amplitude of the normal motion over the interference, and degrees by which it lags."""
SLIDING = 3.0  # amplitude of the sliding over the displacement at which friction at rest is reached


class Loop(NamedTuple):
    """Displacement and force (s, 3) of the element over a period, m and N, and its work, J."""

    displacement: Floats
    force: Floats
    work: float
    marched: float  # the same by equations (8) to (10), step by step

    @property
    def opened(self) -> float:
        """Share of the period without contact."""
        return float(np.mean(self.displacement[:, 0] <= 0))


def loop(kn: float, kt: float, mu: float, v0: float, normal: float, lag: float) -> Loop:
    """Loop under v = v0 (1 + normal cos(θ - lag)), u = U cos θ, by springs too stiff to mind it."""
    turn, sliding, stiff = np.radians(lag), SLIDING * mu * kn * v0 / kt, 1e9 * kn
    system = System.from_matrices(
        M=np.eye(2),
        K=stiff * np.eye(2),
        contacts=[Contact(normal=0, tangential=1, kn=kn, kt=kt, mu=mu, preload=kn * v0)],
        damping_ratio=0.0,
        force={0: stiff * normal * v0 * np.exp(-1j * turn), 1: stiff * sliding},
    )
    response = nonlinear.frequency_response(system, [1.0], Options(1))
    angle = 2 * np.pi * np.arange(2**13) / 2**13
    n = kn * np.maximum(v0 * (1 + normal * np.cos(angle - turn)), 0.0)
    by_steps = marched(n, sliding * np.cos(angle), kt, mu)
    displacement, force = nonlinear.contact_loop(response, 0, 0, 2048)
    return Loop(displacement, force, float(response.dissipation[0, 0]), by_steps)


def marched(n: Floats, u: Floats, kt: float, mu: float) -> float:
    """Friction work ∮ t du of the second cycle: t follows kt u and is held within ±μ n."""
    t = work = 0.0
    for _ in range(2):
        work = 0.0
        for i in range(len(u)):
            step, before = u[i] - u[i - 1], t
            t = min(max(t + kt * step, -mu * n[i]), mu * n[i])
            work += (before + t) / 2 * step
    return work


# --- Maps: peaks over a plane of two parameters, by several methods ---


def name(method: Options) -> str:
    """A method, short and unique."""
    return f"{method.coupling}, H = {method.harmonics}"


class Peak(NamedTuple):
    """Of a response; NaN where it is not within the range or a point beside it is lost."""

    amplitude: float  # m
    frequency: float  # Hz
    opening: float  # share of the pairs of the interlock that open in every period
    lost: int  # points that did not converge
    points: int
    seconds: float  # of a processor


def peak(model: Model, method: Options) -> Peak:
    """The peak that a method finds."""
    began = time.process_time()
    found = model.solve(method)
    spent, response, top = time.process_time() - began, found.response, found.top
    counts = int((~response.converged).sum()), response.points, spent
    if not found.within:
        return Peak(np.nan, np.nan, np.nan, *counts)
    state = response.state[top, model.system.contacts.opens]
    opens = np.isin(state, (nonlinear.OPEN, nonlinear.SLIP_OPEN))
    return Peak(found.amplitude, found.frequency, opens.mean(), *counts)


@dataclass(frozen=True)
class Plane:
    """Peaks at m frictions by v values of `other`, by k methods."""

    other: str  # "interference", m, or "load", a factor
    mu: Sequence[float]
    value: Sequence[float]
    methods: Sequence[Options]
    peaks: Sequence[Sequence[Sequence[Peak]]] = ()

    def solved(self, model: Model, share_out: Callable[..., Iterable[Any]] = map) -> "Plane":
        """With its peaks; `share_out` is `map`, or one that several processes do."""
        return replace(self, peaks=list(share_out(partial(line, self, model), self.mu)))

    def of(self, method: Options, name: str = "amplitude") -> Floats:
        """(m, v) values by a method."""
        k = self.methods.index(method)
        return np.array([[getattr(cell[k], name) for cell in line] for line in self.peaks], float)

    def seconds(self, method: Options) -> float:
        """Processor time of a response by a method, the median, s."""
        return float(np.median(self.of(method, "seconds")))

    @property
    def coupled(self) -> list[Options]:
        """Coupled methods, by their harmonics."""
        return [method for method in self.methods if method.coupling == "coupled"]

    def share(self, holds: Chosen) -> float:
        """Share, of the cells whose peak every method knows, of those in which something holds."""
        known = np.logical_and.reduce([np.isfinite(self.of(method)) for method in self.methods])
        return float(holds[known].mean()) if known.any() else float("nan")


def line(plane: Plane, model: Model, mu: float) -> list[list[Peak]]:
    """Peaks at one friction, by value and method: what a process does of a plane."""
    model = model.prepared(max(method.harmonics or 1 for method in plane.methods))
    models = [model.changed(mu, **{plane.other: value}) for value in plane.value]
    return [[peak(each, method) for method in plane.methods] for each in models]


def slanted(scene: Scene, folder: Path, workers: int) -> dict[float, Model]:
    """The models of other slants of the interlock's faces, on medium meshes or coarser ones."""
    study, here = scene.study, getattr(scene.study.vane, "interlock_slant", None)
    slants = tuple(slant for slant in SLANTS if here is not None and slant != here)
    if not slants:
        return {}
    mesh, response = study.mesh, {"harmonics": max(HARMONICS[:2])}
    if mesh.size in ("paper", "fine") or not isinstance(mesh.size, str):
        mesh = mesh.model_copy(update={"size": "medium", "face_nodes": None})
    tables = {"mesh": mesh, "response": study.response.model_copy(update=response)}
    tables["outputs"] = study.outputs.model_copy(update={"show": ("loops",)})
    tables |= dict.fromkeys(("bounds", "stability", "campbell"))
    run = run_study(study, folder, workers, sweep={"vane.interlock_slant": slants}, **tables)
    found = {}
    for case in run.contents.cases.values():
        model = Model(run.system(case.name), ends(case.line[0]), scene.model.output)
        found[float(case.values["vane.interlock_slant"])] = model
    return found


def slight(plane: Plane, one: Options, more: Options, bound: float) -> Chosen:
    """Where more harmonics change the peak by less than a relative bound."""
    return np.asarray(np.abs(plane.of(more) / plane.of(one) - 1) < bound)


def holds(plane: Plane) -> dict[str, Chosen]:
    """(m, v) where each statement that a map can show holds, by what it says."""
    amplitude, frequency = plane.of(ONE), plane.of(ONE, "frequency")
    slopes = np.gradient(np.log(amplitude))
    found = {"peak falls with friction": slopes[0] < 0}
    if plane.other == "interference":
        found["peak falls with interference"] = slopes[1] < 0
    for method in (UNCOUPLED, CONSTANT):
        higher = plane.of(method, "frequency") > frequency
        found[f"{method.coupling}: higher f, lower A"] = higher & (plane.of(method) < amplitude)
    for (one, more), bound in zip(itertools.pairwise(plane.coupled), (SLIGHT, NONE), strict=False):
        found[f"H = {more.harmonics} changes < {bound:.0%}"] = slight(plane, one, more, bound)
    return found


# --- The peak along friction or interference over decades ---


class Ridge(NamedTuple):
    """The peak along a parameter of the interlock; NaN where it is lost."""

    name: str  # "mu", or "interference", m
    harmonics: int
    value: Floats
    amplitude: Floats
    frequency: Floats

    @property
    def best(self) -> tuple[float, float] | None:
        """The lowest, of the parabola over log(value) through three; None where it is at an end."""
        known = np.isfinite(self.amplitude)
        x, a = np.log(self.value[known]), self.amplitude[known]
        low = int(a.argmin()) if len(a) else 0
        if low in (0, len(a) - 1):
            return None
        x, a = x[low - 1 : low + 2], a[low - 1 : low + 2]
        bend, rise, level = np.polyfit(x - x[1], a, 2)
        move = float(np.clip(-rise / (2 * bend), x[0] - x[1], x[2] - x[1])) if bend > 0 else 0.0
        least = level + rise * move + bend * move**2
        return float(np.exp(x[1] + move)), float(least)


def ridge(model: Model, key: tuple[str, int]) -> Ridge:
    """The peak followed along a parameter, with a number of harmonics: `key` is both."""
    name, harmonics = key
    mapped = MAP_MU if name == "mu" else MAP_INTERFERENCE
    value = np.geomspace(mapped[0] / 10**0.5, mapped[-1] * 10**0.5, RIDGE_POINTS)
    output = model.system.output_names[model.output[0]], model.output[1]
    along, more = (model.system, name, value, model.near), {"output": output, "joint": "interlock"}
    try:
        found = nonlinear.peak_response(*along, Options(harmonics), **more)
    except ValueError:  # no peak lies within the range
        return Ridge(name, harmonics, value, *np.full((2, len(value)), np.nan))
    known = np.where(found.converged, [found.amplitude, found.frequency], np.nan)
    return Ridge(name, harmonics, value, *known)


# --- Statements ---


class Results(NamedTuple):
    """All that statements are judged by and figures show."""

    scene: Scene
    hooks: Apart
    load: float  # the factor at which all contacts stick
    stuck: Mapping[Options, Solved]
    stuck_apart: Mapping[Options, Apart]
    loops: Mapping[str, Loop]
    planes: Mapping[str, Plane]
    ridges: Sequence[Ridge]


class Statement(NamedTuple):
    """A statement of the published study, what is found, and why they differ."""

    figure: str
    says: str
    finds: str
    agrees: str  # "yes" where all that it is judged by is true, "partly" where some is, "no"
    waves: str  # whether those of its coupled peaks are stable, where that is asked for
    why: str


def judged(
    figure: str, says: str, finds: str, true: Sequence[bool], waves: str = "", why: str = ""
) -> Statement:
    """A statement; why it is not true, if it is not."""
    agrees = "yes" if all(true) else "partly" if any(true) else "no"
    return Statement(figure, says, finds, agrees, waves, why)


def statements(r: Results) -> list[Statement]:
    """All of them."""
    scene, plane = r.scene, r.planes["interference"]
    made = [*linear(r), hysteresis(r.loops), *damping(scene), *harmonics(scene, plane)]
    for figure, name in (("15", "friction"), ("16", "interference")):
        made += [against(scene, figure, name, method) for method in FEW[1:]]
    return [*made, *conclusion(plane)]


def linear(r: Results) -> list[Statement]:
    """Figures 4, 10 and 11: where nothing slips."""
    scene, system, hooks = r.scene, r.scene.model.system, r.hooks
    order, N = abs(system.engine_order), system.sectors
    free, stuck = scene.modes["free"], scene.modes["stuck"]
    rpm = [60 * f / order for f in (free, stuck, scene.cases[scene.reference].frequency)]
    excited = f"mode {scene.mode} of nodal diameter {min(order % N, -order % N)} is excited by EO"
    crosses = f"crosses EO {order} at {rpm[0]:.0f} rpm free and {rpm[1]:.0f} rpm stuck; "
    crosses += f"response with friction peaks at {rpm[2]:.0f} rpm"
    within = min(rpm[:2]) <= 1.001 * rpm[2] <= 1.001**2 * max(rpm[:2])
    alone = "hooks alone: nonlinear response coincides with the linear free one, no slip"
    none = f"differs by {hooks.vibration:.0e} of the peak; {hooks.slipping} hook contacts slip"
    stiffer = "all joints stuck: resonance higher than with the interlock free"
    rise = f"{free:.2f} to {stuck:.2f} Hz, {100 * (stuck / free - 1):+.1f} %"
    vibration, mean, slipping = map(max, zip(*r.stuck_apart.values(), strict=True))
    alike = "all stuck, small load: coupled and uncoupled responses coincide"
    means = [f"{each.mean:.0e} ({method.coupling})" for method, each in r.stuck_apart.items()]
    small = f"at {r.load:g} of the load: harmonics h >= 1 differ by {vibration:.0e}, mean contact "
    small += f"forces by {', '.join(means)}; {slipping:.0f} contacts slip"
    relaxed = "contacts that slid when assembled rest at the bound of friction, and vibration "
    relaxed += "relaxes their mean force: harmonic 0 alone differs"
    coincide = [vibration < COINCIDENT, slipping == 0]
    return [
        judged("4", f"{excited} {order}", crosses, [within], scene.stable([scene.reference])),
        judged("10", alone, none, [hooks.vibration < COINCIDENT, hooks.slipping == 0]),
        judged("11", stiffer, rise, [stuck > free]),
        judged("11", alike, small, coincide, why=relaxed if mean > 1e-3 else ""),
    ]


def hysteresis(loops: Mapping[str, Loop]) -> Statement:
    """Figure 8."""
    says = "three shapes of loops: in phase, with partial lift-off, out of phase"
    work = ", ".join(f"{name} {1e6 * each.work:.3g} µJ" for name, each in loops.items())
    worst = max(abs(each.work / each.marched - 1) for each in loops.values())
    opened = [each.opened for each in loops.values()]
    finds = f"{work} a cycle; open {100 * opened[1]:.0f} % of the period with lift-off; energies "
    finds += f"within {worst:.0e} of the element marched step by step"
    return judged("8", says, finds, [[x > 0 for x in opened] == [False, True, False], worst < 1e-4])


def damping(scene: Scene) -> list[Statement]:
    """Figures 12 and 14, and the text to Figure 10: what friction takes."""
    of = {name: scene.coupled(name) for name in ("friction", "interference")}
    both, share = of["friction"] + of["interference"], 0.0
    for found in (scene.cases[case] for case in of["friction"]):
        work = found.response.dissipation[found.top]
        share = max(share, float(work[~scene.pairs].sum() / max(work.sum(), 1e-300)))
    little = "hooks contribute little to the damping, the interlock most of it"
    most = f"hooks take at most {share:.1%} of the friction work at the peaks"
    lower = "responses with friction are lower than the fully stuck one"
    stuck = [scene.cases[case].amplitude / scene.linear["stuck"].amplitude for case in both]
    ratios = f"{min(stuck):.3g} to {max(stuck):.3g} of it"
    made = [
        judged("10, text", little, most, [share < LITTLE], scene.stable(of["friction"])),
        judged("12, 14", lower, ratios, [ratio < 1 for ratio in stuck], scene.stable(both)),
    ]
    words = ("12", "friction", "friction coefficient"), ("14", "interference", "interference")
    for figure, name, word in words:
        free = [scene.cases[case].amplitude / scene.linear["free"].amplitude for case in of[name]]
        falls = [after < before for before, after in itertools.pairwise(free)]
        why = f"beyond the optimum {word} the contacts stick more and dissipate less"
        finds = f"{', '.join(f'{x:.3f}' for x in free)} of the linear free peak"
        says, waves = f"the peak falls as the {word} grows", scene.stable(of[name])
        made.append(judged(figure, says, finds, falls, waves, "" if all(falls) else why))
    return made


def harmonics(scene: Scene, plane: Plane) -> list[Statement]:
    """Figure 13 and its text."""
    cases, H = scene.figures["harmonics"], HARMONICS
    size = [scene.cases[case].amplitude for case in cases]
    start, end = size[1] / size[0] - 1, size[-1] / size[-2] - 1
    pairs, steps = itertools.pairwise(plane.coupled), [0 <= start < SLIGHT, abs(end) < NONE]
    small = [slight(plane, *pair, NONE if i else SLIGHT) for i, pair in enumerate(pairs)]
    share = plane.share(np.logical_and.reduce(small))
    says = "slight increase of the peak from one to three harmonics, none from three to five"
    finds = f"{start:+.1%} from H = {H[0]} to {H[1]}, {end:+.2%} from {H[-2]} to {H[-1]}; within "
    finds += f"{SLIGHT:.0%} and {NONE:.0%} on {share:.0%} of the map"
    why = "where contacts lift off for part of the period, near the optimum friction, one harmonic "
    why += "does not carry the impact"
    spent = {method.harmonics or 0: plane.seconds(method) for method in plane.coupled}
    faster = "calculation time increases fast with the number of harmonics"
    times = "; ".join(f"H = {h}: {seconds / spent[1]:.1f}" for h, seconds in spent.items())
    times += f" times that of one harmonic, {1e3 * spent[1]:.0f} ms a response of "
    times += f"{plane.of(ONE, 'points').mean():.0f} frequencies"
    return [
        judged("13", says, finds, steps, scene.stable(cases), "" if share == 1 else why),
        judged("13, text", faster, times, [spent[max(spent)] > len(spent) * spent[1]]),
    ]


def against(scene: Scene, figure: str, name: str, method: Options) -> Statement:
    """Figures 15 and 16: peaks by another coupling against the coupled ones."""
    cases, one = scene.coupled(name), method.coupling
    pairs = [(scene.cases[case], scene.cases[case._replace(method=method)]) for case in cases]
    shift = [other.frequency - coupled.frequency for coupled, other in pairs]
    ratio = [other.amplitude / coupled.amplitude for coupled, other in pairs]
    says = f"{one} peaks lie at higher frequency and lower amplitude than coupled ones"
    finds = f"shifted by {', '.join(f'{x:+.2f}' for x in shift)} Hz, amplitudes times "
    finds += ", ".join(f"{x:.2f}" for x in ratio)
    why = "beyond the optimum friction the order turns round, see the map"
    if method == CONSTANT and max(ratio) >= 1:
        why = by_mean_load(scene, cases[int(np.nanargmax(ratio))])
    true = [*(x > 0 for x in shift), *(x < 1 for x in ratio)]
    return judged(figure, says, finds, true, scene.stable(cases), why if max(ratio) >= 1 else "")


def by_mean_load(scene: Scene, case: Case) -> str:
    """Why friction bounded by the load at rest peaks higher than a coupled case."""
    at_rest = nonlinear.static_response(scene.model.changed(*case[:2]).system)
    top = scene.cases[case].response.at([scene.cases[case].top])
    rest, mean = (each.force[0, 0, scene.pairs, 0].real.mean() for each in (at_rest, top))
    why = f"contacts lift off, so their mean load grows from {rest:.3g} N at rest to {mean:.3g} N "
    why += f"a pair at the coupled peak (μ = {case.mu:g}, {1e6 * case.interference:g} µm), and "
    return why + "friction with it; held at rest it dissipates less"


def conclusion(plane: Plane) -> list[Statement]:
    """The text to Figures 15 and 16."""
    safe = [plane.share(plane.of(method) < plane.of(ONE)) for method in FEW[1:]]
    longer, everywhere = plane.seconds(ONE) / plane.seconds(UNCOUPLED), min(safe) > 0.999
    says = "the coupled method is the more conservative one"
    higher = f"its peak is the higher one on {safe[0]:.0%} of the map (uncoupled) and "
    higher += f"{safe[1]:.0%} (constant-load)"
    why = "beyond the friction and interference that damp best the order turns round; friction "
    why += "bounded by the load at rest misses what lift-off adds to the mean load"
    slower = "the coupled method takes more calculation time"
    times = f"{longer:.2f} times the uncoupled one's at H = 1"
    alike = "coupling adds one real unknown to the two of each contact direction, and what does "
    alike += "not depend on the state is prepared once for both"
    true, why = [safe[0] > 0.5, everywhere], "" if everywhere else why
    return [
        judged("15, 16, text", says, higher, true, why=why),
        judged("text", slower, times, [longer > 1.1], why="" if longer > 1.1 else alike),
    ]


# --- Figures: each a picture and a CSV file of its numbers ---


@contextmanager
def drawn(path: Path, title: str, rows: int = 1, columns: int = 1) -> Iterator[Any]:
    """Axes of a picture, and the columns of its CSV file; both are written in the end."""
    size = (8.0, 5.0) if rows * columns == 1 else (5.0 * columns, 4.2 * rows)
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained")
    figure.suptitle(title)
    yield list(axes.flat), (numbers := dict[str, ArrayLike]())
    figure.savefig(path, dpi=120)
    plt.close(figure)
    write_table(path.with_suffix(".csv"), numbers)


def write_table(path: Path, columns: Mapping[str, ArrayLike]) -> None:
    """Columns as CSV, of one length or not."""
    cells = itertools.zip_longest(*(np.ravel(each).tolist() for each in columns.values()))
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([list(columns), *cells])


def curves_of(r: Results) -> dict[str, dict[str, Solved]]:
    """What Figures 10 to 16 show, by title and label."""
    scene = r.scene
    limits = {f"linear {which}": each for which, each in scene.linear.items()}

    def lines(figure: str, text: str, method: Options | None = None) -> dict[str, Solved]:
        chosen = [each for each in scene.figures[figure] if method in (None, each.method)]
        return {label(each, text): scene.cases[each] for each in chosen}

    def label(case: Case, text: str) -> str:
        other = {"sector": "one diameter"}.get(case.method.harmonic_diameters, case.method.coupling)
        own = text.format(case.mu, 1e6 * case.interference, case.method.harmonics)
        return own if other == "coupled" else f"{own}, {other}"

    small = {f"stuck, {m.coupling}": s._replace(curve=s.curve / r.load) for m, s in r.stuck.items()}
    mu, pressed, H = "μ = {0:g}", "{1:g} µm", "H = {2}"
    title = f"interlock interference, μ = {MU[-1]:g}"
    return {
        "Figure 10: hook joints alone": limits | lines("hooks", "hooks in friction"),
        "Figure 11: hooks and interlock stuck, at a small load": limits | small,
        "Figure 12: friction coefficient": limits | lines("friction", mu, ONE),
        "Figure 13: number of harmonics": lines("harmonics", H) | lines("one diameter", H),
        f"Figure 14: {title}": limits | lines("interference", pressed, ONE),
        "Figure 15: coupled and uncoupled, friction coefficient": lines("friction", mu),
        f"Figure 16: coupled and uncoupled, {title}": lines("interference", pressed),
    }


def draw_curves(path: Path, title: str, scene: Scene, curves: Mapping[str, Solved]) -> None:
    """Responses over the linear resonance with the hooks stuck and the interlock free."""
    free, colours = scene.linear["free"], dict[str, str]()
    dashes = {"uncoupled": "--", "constant-load": ":", "one diameter": "--"}
    with drawn(path, title) as ((axes,), numbers):
        for label, each in curves.items():
            same, _, other = label.partition(", ")
            colour = colours.setdefault(same, f"C{len(colours)}")
            style = {"color": colour, "ls": dashes.get(other, "-"), "label": label}
            x, y = each.response.frequency, each.curve
            axes.plot(x / free.frequency, y / free.amplitude, **style)
            numbers |= {f"{label} (Hz)": x, f"{label} (µm)": 1e6 * y}
        axes.set(xlabel="frequency / linear free", ylabel=f"{scene.monitor} / linear free peak")
        axes.legend(fontsize=8)


def draw_loops(path: Path, title: str, loops: Mapping[str, Loop]) -> None:
    """Figure 8."""
    heads = ("normal displacement (µm)", "sliding (µm)", "normal force (N)", "friction force (N)")
    with drawn(path, title, 1, len(loops)) as (every, numbers):
        for axes, (name, each) in zip(every, loops.items(), strict=True):
            columns = [*1e6 * each.displacement.T[:2], *each.force.T[:2]]
            axes.plot(*(np.append(x, x[0]) for x in columns[1::2]))
            axes.set(title=name, xlabel=heads[1], ylabel=heads[3])
            numbers |= {f"{name}: {h}": x for h, x in zip(heads, columns, strict=True)}


def draw_map(path: Path, title: str, plane: Plane) -> None:
    """The peak, where each statement holds, and the errors of one harmonic."""
    best = plane.coupled[-1]
    panels: dict[str, Any] = {f"peak (µm), {name(best)}": 1e6 * plane.of(best)}
    panels |= {"at (Hz)": plane.of(best, "frequency"), **holds(plane)}
    panels["pairs that lift off (%)"] = 100 * plane.of(ONE, "opening")
    for method in FEW if best != ONE else ():
        panels[f"error of {name(method)} (%)"] = 100 * (plane.of(method) / plane.of(best) - 1)
    unit = "interference (µm)" if plane.other == "interference" else "load (factor)"
    draw_panels(path, title, panels, plane, unit)


def draw_panels(path: Path, title: str, panels: dict[str, Any], plane: Plane, unit: str) -> None:
    """Maps of a plane, three in a row; its peaks as CSV."""
    scale = 1e6 if plane.other == "interference" else 1.0
    with drawn(path, title, -(-len(panels) // 3), 3) as (every, numbers):
        for axes in every[len(panels) :]:
            axes.remove()
        for axes, (says, values) in zip(every, panels.items(), strict=False):
            shades = ("RdYlGn", 0, 1) if values.dtype == bool else ("viridis", None, None)
            shown = dict(zip(("cmap", "vmin", "vmax"), shades, strict=True), alpha=0.6)
            axes.imshow(values.astype(float), origin="lower", aspect="auto", **shown)
            for (i, j), x in np.ndenumerate(values):
                text = ("yes" if x else "no") if values.dtype == bool else f"{x:.4g}"
                axes.text(j, i, text, ha="center", va="center", fontsize=8)
            axes.set_xticks(range(len(plane.value)), [f"{scale * x:g}" for x in plane.value])
            axes.set_yticks(range(len(plane.mu)), [f"{x:g}" for x in plane.mu])
            axes.set(title=says, xlabel=unit, ylabel="friction coefficient")
        cells = [
            (mu, scale * value, name(method), *each)
            for mu, row in zip(plane.mu, plane.peaks, strict=True)
            for value, cell in zip(plane.value, row, strict=True)
            for method, each in zip(plane.methods, cell, strict=True)
        ]
        peaks = ("peak (m)", "at (Hz)", "lifting off (share)", *Peak._fields[3:])
        heads = ("friction coefficient", unit, "method", *peaks)
        numbers |= dict(zip(heads, zip(*cells, strict=True), strict=True))


def draw_ridges(path: Path, title: str, ridges: Sequence[Ridge], scene: Scene) -> None:
    """The peak over decades of friction and interference."""
    labels = {"mu": (1.0, "friction coefficient"), "interference": (1e6, "interference (µm)")}
    with drawn(path, title, 1, 2) as (every, numbers):
        for axes, (along, (scale, label)) in zip(every, labels.items(), strict=True):
            for each in (ridge for ridge in ridges if ridge.name == along):
                x, a, text = scale * each.value, 1e6 * each.amplitude, f"H = {each.harmonics}"
                numbers |= {f"{label}, {text}": x, f"peak (µm) along {label}, {text}": a}
                numbers |= {f"at (Hz) along {label}, {text}": each.frequency}
                if (best := each.best) is not None:
                    axes.plot(scale * best[0], 1e6 * best[1], "ko", mfc="white")
                    text += f": least {1e6 * best[1]:.4g} µm at {scale * best[0]:.3g}"
                axes.loglog(x, a, label=text)
            for (which, limit), dash in zip(scene.linear.items(), ("--", ":"), strict=True):
                axes.axhline(1e6 * limit.amplitude, color="grey", ls=dash, label=f"linear {which}")
            axes.axvline(scale * getattr(scene.reference, along), color="grey", lw=0.5)
            axes.set(xlabel=label, ylabel="peak (µm)")
            axes.legend(fontsize=8)


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    cells = [heads, ["---"] * len(heads), *rows]
    return "".join("| " + " | ".join(map(str, row)) + " |\n" for row in cells)


def doubts(scene: Scene) -> Iterator[str]:
    """Cases whose peak is not to be trusted, and the statements with it."""
    for case, found in scene.cases.items():
        lost, end = (~found.response.converged).sum(), found.top in (0, len(found.curve) - 1)
        if lost or end:
            where = ", the largest point is at the end of the range" if end else ""
            yield f"{case}: {lost} points did not converge{where}"


def shares(planes: Mapping[str, Plane]) -> str:
    """Share of each map in which each statement holds, %."""
    names, rows = list(holds(planes["interference"])), []
    for which, plane in planes.items():
        held = {says: f"{100 * plane.share(where):.0f}" for says, where in holds(plane).items()}
        rows.append([which, *(held.get(says, "") for says in names)])
    return table(["map", *names], rows)


def write(folder: Path, r: Results, stated: Sequence[Statement]) -> None:
    """All figures, the table of statements, and the page that shows them."""
    scene, heads = r.scene, Statement._fields
    (figures := folder / "figures").mkdir(exist_ok=True)
    write_table(folder / "statements.csv", dict(zip(heads, zip(*stated, strict=True), strict=True)))
    loops = partial(draw_loops, loops=r.loops)
    pictures: dict[str, Any] = {"Figure 8: the contact element under given motion": loops}
    for title, curves in curves_of(r).items():
        pictures[title] = partial(draw_curves, scene=scene, curves=curves)
    for which, each in r.planes.items():
        pictures[f"Map {which}: where statements hold"] = partial(draw_map, plane=each)
    ridges = partial(draw_ridges, ridges=r.ridges, scene=scene)
    pictures["Optimum: the peak over decades of friction and interference"] = ridges
    parts = [f"# The published study: {scene.study.name}", table(heads, stated)]
    parts += [f"**Be careful.** {doubt}." for doubt in doubts(scene)]
    parts += ["Share of each map in which a statement holds, %:", shares(r.planes)]
    parts.append(f"Figures are of {scene.monitor}. All cases: [report](cases/report.html).")
    for title, draw in pictures.items():
        file = title.partition(":")[0].lower().replace(" ", "_")
        draw(figures / f"{file}.png", title)
        parts.append(f"![{title}](figures/{file}.png)")
    (folder / "paper.md").write_text("\n\n".join(parts), "utf-8")


def make(study: vanelock.Study, folder: Path, workers: int = 1) -> Results:
    """Run the study and everything around it, in a folder."""
    scene = run_cases(study, folder / "cases", workers)
    model, lock = scene.model.changed(*scene.reference[:2]), study.joints.interlock
    load = sticking_load(model.system, scene.linear["stuck"].response)
    element = lock.kn, lock.kt, lock.mu, lock.interference
    loops = {each: loop(*element, *motion) for each, motion in LOOPS.items()}
    higher = tuple(Options(h) for h in HARMONICS if h > 1)
    pressed = Plane("interference", MAP_MU, MAP_INTERFERENCE, (*FEW, *higher))
    coarse = Plane("interference", SLANT_MU, SLANT_INTERFERENCE, (*FEW, *higher[:1]))
    keys = itertools.product(("mu", "interference"), sorted({*RIDGE_HARMONICS} & {*HARMONICS}))
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        share_out = map if workers == 1 else pool.map
        planes = {"interference": pressed.solved(model, share_out)}
        planes["load"] = Plane("load", MAP_MU, MAP_LOAD, FEW).solved(model, share_out)
        for slant, other in slanted(scene, folder / "slants", workers).items():
            planes[f"slant {slant:g}"] = coarse.solved(other, share_out)
        ridges = list(share_out(partial(ridge, model), keys))
    stuck = all_stuck(model.changed(load=load))
    return Results(scene, hooks_alone(scene), load, *stuck, loops, planes, ridges)


def main(arguments: Sequence[str] | None = None) -> list[Statement]:
    """Make it all, and print the statements."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "study", nargs="?", type=Path, default=Path(__file__).with_name("study.toml")
    )
    parser.add_argument("--output", type=Path, default=Path("runs/paper"), help="folder")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    given = parser.parse_args(arguments)
    results = make(vanelock.load_study(given.study), given.output, given.workers)
    stated = statements(results)
    write(given.output, results, stated)
    for each in stated:
        print(f"{each.figure}: {each.says}: {each.agrees}: {each.finds} {each.why}")
    return stated


if __name__ == "__main__":
    main()
