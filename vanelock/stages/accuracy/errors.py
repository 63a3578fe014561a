"""What a response to an accuracy is worth: errors by source, and what they cost.

Only what a scene needs: what a response does without, and the evidence that it may.
"""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import NamedTuple

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Floats
from vanelock.common.tables import Cell, Column, Flag, Table, heads
from vanelock.nonlinear import Response, peak_errors
from vanelock.rom import System
from vanelock.stages.accuracy.budget import SOURCES, Budget
from vanelock.stages.accuracy.choose_mesh import MeshChoice, Round


@dataclass(frozen=True)
class Source:
    """What one source adds to the error of the largest response.

    Attributes
    ----------
    name : str
        Of `budget.SOURCES`, or "samples".
    amplitude, frequency : float
        Estimated relative error of the peak's; NaN where there is none.
    share : float
        What it may be; NaN where the setting is pinned.
    cost : float
        Processor time of the stages that depend on it, over that of all; NaN where another
        source's line holds it.
    setting : str
        What was chosen, in words.
    """

    name: str
    amplitude: float
    frequency: float
    share: float
    cost: float
    setting: str


@dataclass(frozen=True)
class Errors:
    """Estimated errors of a case."""

    accuracy: float
    """What was asked for."""
    sources: tuple[Source, ...]
    warnings: tuple[str, ...]
    """Why the accuracy may not be met, a line each."""
    corrected: float
    """Frequency of the peak less what the mesh is estimated to add to it, Hz; NaN where that is
    taken off already."""

    @property
    def counted(self) -> tuple[Source, ...]:
        """Sources that the accuracy is of: a pinned mesh is none."""
        return tuple(
            each for each in self.sources if each.name != "mesh" or np.isfinite(each.share)
        )

    @property
    def total(self) -> tuple[float, float]:
        """Sums over these of what is known, for amplitude and frequency."""
        return (
            float(np.nansum([each.amplitude for each in self.counted])),
            float(np.nansum([each.frequency for each in self.counted])),
        )

    @property
    def unknown(self) -> tuple[list[str], list[str]]:
        """Those of these whose error of amplitude, and of frequency, is not known.

        None of the latter where the study lists its frequencies, which then are no source.
        """
        amplitude = [each.name for each in self.counted if np.isnan(each.amplitude)]
        frequency = [each.name for each in self.counted if np.isnan(each.frequency)]
        listed = all(each.name != "frequencies" for each in self.sources)
        return amplitude, [] if listed else frequency


def errors(
    response: Response, choice: MeshChoice, settings: dict[str, str], costs: dict[str, float]
) -> Errors:
    """Errors of a case, and warnings."""
    found, budget, mesh = peak_errors(response), choice.budget, choice.rounds[-1]
    total, nan = sum(costs.values()) or 1.0, float("nan")
    # the errors are those of the largest of the frequencies that a study lists
    listed = budget.pinned.get("frequencies") == "response.frequencies"
    sources = []
    for name in (*SOURCES, "samples"):
        amplitude = found.amplitude_error.get(name, nan)
        frequency = found.frequency_error.get(name, nan)
        if name == "samples" and not response.samples:
            continue  # events are located
        if name == "frequencies" and listed:
            continue  # exactly these are asked for
        if name == "mesh":  # by the mode itself, which a mesh may move beyond first order
            amplitude, frequency = mesh.amplitude, mesh.error
        cost, share = costs.get(name, nan) / total, budget.shares.get(name, nan)
        sources.append(Source(name, amplitude, frequency, share, cost, settings.get(name, "")))
    uncorrected = choice.study.mesh.correction == "none"
    less = found.frequency * (1 - mesh.error) if uncorrected else nan
    known = Errors(budget.accuracy, tuple(sources), (), less)
    return replace(known, warnings=tuple(_warnings(known, budget, choice.rounds, choice.short)))


def _warnings(errors: Errors, budget: Budget, rounds: Sequence[Round], short: str) -> list[str]:
    lines = []
    amplitude, frequency = errors.total
    worst = max(amplitude, frequency)
    if worst > budget.accuracy:
        dominant = max(
            errors.counted, key=lambda error: np.nanmax([error.amplitude, error.frequency])
        )
        lines.append(
            f"WARNING: the estimated error is {worst:.1e}, more than the accuracy "
            f"{budget.accuracy:g} asked for; most of it is {dominant.name} ({dominant.setting})"
        )
    if short:
        lines.append(f"WARNING: {short}")
    if "mesh" in budget.pinned and rounds and rounds[-1].largest > budget.accuracy:
        lines.append(
            f"WARNING: the accuracy holds for this mesh alone ({budget.pinned['mesh']} is given): "
            f"frequencies are off by about {rounds[-1].error:.1e}, the peak by about "
            f"{rounds[-1].amplitude:.1e} because of it"
        )
    for kind, unknown in zip(("amplitude", "frequency"), errors.unknown, strict=True):
        if unknown:
            lines.append(f"WARNING: the {kind}'s error is not known for: {', '.join(unknown)}")
    return lines


def error_table(case: str, estimates: Errors, monitor: str) -> Table:
    """Source, estimate, cost and setting."""
    columns = (
        Column("source"),
        Column("amplitude error", form=".1e", key="amplitude"),
        Column("frequency error", form=".1e", key="frequency"),
        Column("allowed", form=".1e", key="share"),
        Column("cost", form=".2f"),
        Column("setting"),
    )
    rows: list[tuple[Cell, ...]] = [astuple(each) for each in estimates.sources]
    together = [
        total if any(np.isfinite(getattr(each, kind)) for each in estimates.counted) else None
        for kind, total in zip(("amplitude", "frequency"), estimates.total, strict=True)
    ]
    asked = f"accuracy = {estimates.accuracy:g}"
    rows.append(("total", *together, estimates.accuracy, 1.0, asked))
    met = max(estimates.total) <= estimates.accuracy and not any(estimates.unknown)
    flags: list[Flag] = [""] * len(estimates.sources)
    flags.append("good" if met else "warn")
    notes = [
        "errors: estimated, relative, of the largest response by each source; allowed: its share "
        "of the accuracy; cost: share of the processor time.",
    ]
    if np.isfinite(estimates.corrected):
        notes.append(
            f"less what the mesh adds by estimate, the peak lies near {estimates.corrected:.1f} Hz "
            "(`vanelock manual benchmarks/mesh_error`)"
        )
    notes += estimates.warnings
    title = f"Errors of the peak of {monitor}" + ("" if case == "nominal" else f", {case}")
    return Table(title, columns, rows, notes, "errors", flags)


class LeftOut(NamedTuple):
    """Something that a case does without, or was asked to and keeps, and the evidence."""

    kind: str
    what: str
    evidence: str


def left_out(
    response: Response,
    system: System,
    watched: str,
    diameters: tuple[Sequence[int], Sequence[int]],
    energy: dict[str, float],
    above: dict[str, float | None],
    modes_error: float,
) -> Iterator[LeftOut]:
    """What a response does without."""
    used, never = diameters
    yield from _joints(response, system.contacts.joint)
    assert response.estimates is not None
    H, needed = response.harmonics, response.estimates.harmonics
    harmonics = response.estimates.sources.index("harmonics")
    worst = float(np.nanmax(response.estimates.error[:, harmonics], initial=0.0))
    top = int(np.nanargmax(np.where(response.converged, response.estimates.amplitude, -np.inf)))
    at_peak = float(response.estimates.error[top, harmonics])
    yield LeftOut(
        "harmonics",
        f"above {H}; above {needed[top]} at the peak",
        f"estimated {at_peak:.0e} of the amplitude at the peak, {worst:.0e} at worst; "
        f"{int((needed < H).sum())} of {response.points} points took fewer than {H}",
    )
    if never:
        yield LeftOut(
            "nodal diameters",
            _listed_harmonics(never),
            f"never reduced: harmonics 0 to {response.estimates.tried}, kept or tried, have "
            f"nodal diameters {_listed_harmonics(used)}",
        )
    for part, hertz in above.items():
        if hertz is not None and np.isfinite(hertz):
            yield LeftOut(
                "modes",
                f"{part}: fixed-interface modes above {hertz:.0f} Hz, but their static part",
                f"estimated {modes_error:.0e} of the peak, both parts together",
            )
    for name, share in energy.items():
        evidence = f"holds {100 * share:.2g} % of the strain energy of the mode of interest"
        yield LeftOut("parts", f"{name}: kept", evidence)
    if (count := len(system.output_names)) > 1:
        what = f"{count - 1} of {count} output nodes"
        yield LeftOut("outputs", what, f"nothing was refined for them, only for {watched}")


def _joints(response: Response, joints: Sequence[str]) -> Iterator[LeftOut]:
    """Contacts that stick at all points: they bring no unknowns."""
    stuck = np.all(response.state[response.converged] == nonlinear.STUCK, axis=0)
    used = _utilisation(response)[response.converged].max(axis=0, initial=0.0)
    for joint in dict.fromkeys(joints):
        own = np.array([each == joint for each in joints])
        count, sticking = int(own.sum()), int((own & stuck).sum())
        if sticking == 0:
            continue
        pairs = f"all {sticking} pairs" if sticking == count else f"{sticking} of {count} pairs"
        yield LeftOut(
            "joints" if sticking == count else "contacts",
            f"{joint}: friction of {pairs}",
            f"stuck at every point, largest |t| / (mu n) {used[own & stuck].max():.3g}: "
            "no unknowns",
        )


SAMPLES = 64
"""Of a period, at which friction is compared with its bound."""


def _utilisation(response: Response) -> Floats:
    """(p, c) largest friction force over its bound in a period; 0 where there is no friction."""
    angle = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    waves = np.exp(1j * np.outer(np.arange(response.harmonics + 1), angle))
    history = np.einsum("phcd,hs->pscd", response.force, waves).real
    bound = response.mu * np.maximum(history[..., 0], 0.0)
    friction = np.abs(history[..., 1:])
    t = (
        np.hypot(*np.moveaxis(friction, -1, 0))
        if response.friction == "isotropic"
        else friction.max(-1)
    )
    ratio = np.divide(t, bound, out=np.zeros_like(t), where=bound > 1e-9 * bound.max(initial=0.0))
    return np.asarray(ratio.max(axis=1))


def left_out_table(case: str, rows: Sequence[LeftOut]) -> Table:
    """What a case does without, and why that is right."""
    columns = (Column("left out", key="kind"), *heads("what", "evidence"))
    title = "Left out, or kept, and why" + ("" if case == "nominal" else f", {case}")
    return Table(title, columns, rows, key="left_out")


def _listed_harmonics(numbers: Sequence[int]) -> str:
    """Whole numbers in words: "0, 1, 4 to 8"."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [", ".join(map(str, run)) if len(run) < 3 else f"{run[0]} to {run[-1]}" for run in runs]
    return ", ".join(texts)
