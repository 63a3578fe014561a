"""Mistuning: rings whose segments differ, each solved whole, and how much more one vibrates.

The rings are drawn, or one is given; see `nonlinear.ring_response`. Each is a step of its own, so
that they are computed side by side.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from vanelock import nonlinear, render, report
from vanelock.analyses.analysis import Analysis, AnalysisPart, products_of
from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Flag, Table, by_case
from vanelock.input.cases.names import of_case, slug
from vanelock.input.schema.comparison import FrequencyRange
from vanelock.input.schema.distributions import Deviation
from vanelock.input.schema.structure.structure import KeyTable, flat

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Planned, Problem, RunResult, SolvedCase, Step
    from vanelock.rom import Component, System

FREQUENCY = "vane.frequency"
"""What the deviation of the natural frequencies of a vane alone is called."""
OF_JOINT = ("interference", "mu", "kn", "kt", "slider")
"""What deviates of a joint: relative to its own values, `slider` to the limit of friction."""
VANE_MODES = 5
"""Of a vane alone, each of which deviates by itself; more where the mode of interest is above."""
PERCENTILES = (5, 50, 95)
"""Of the rings drawn."""
APART = 0.01
"""Relative difference of the tuned peak from that of the curve from which it is worth a line."""
TEXT = (
    "The segments of a real ring differ, and one of them vibrates more than all would if they were "
    "alike. The balances of all segments are solved together, for every ring drawn; whether these "
    "solutions are stable is not decided."
)
ABSENT = "**Mistuning**: all segments are alike; `[mistuning]` computes rings in which they differ."


class MistuningKeys(KeyTable):
    """How much more some segment vibrates where the segments of a ring are not alike."""

    rings: int = Field(default=20, ge=1, le=10_000, description="number of rings drawn")
    range: FrequencyRange | None = Field(default=None, description="[low, high] frequency [Hz]")
    keys: Annotated[dict[str, Deviation], BeforeValidator(flat)] = Field(
        min_length=1, max_length=100, description="what deviates"
    )

    @property
    def count(self) -> int:
        """Rings: as many as are drawn, or the one that is given."""
        drawn = any(isinstance(value, float) for value in self.keys.values())
        return self.rings if drawn else 1


@dataclass(frozen=True)
class MistunedRing(Product):
    """The monitored displacement of every segment of one ring.

    Attributes
    ----------
    frequency : (p,) float
        Hz.
    amplitude : (p, N) float
        Half the peak-to-peak, m.
    converged : (p,) bool
    tuned : float
        Largest amplitude over the frequencies, were all segments alike, m; NaN if none converged.
    """

    frequency: Floats = field(metadata={"unit": "Hz"})
    amplitude: Floats = field(metadata={"unit": "m"})
    converged: Booleans
    tuned: float = field(metadata={"unit": "m"})

    @property
    def known(self) -> Floats:
        """(p, N) amplitudes; -1 where a point did not converge, so that no maximum is there."""
        return np.where(self.converged[:, None], self.amplitude, -1.0)


@dataclass(frozen=True)
class MistunedRings(Product):
    """R rings of N segments in numbers, and the curves of the worst one.

    Attributes
    ----------
    amplitude : (R, N) float
        Largest amplitude of each segment over the frequencies, m; NaN if no point converged.
    frequency : (R, N) float
        Where it has it, Hz.
    tuned : (R,) float
        The same of tuned rings, m.
    points, lost : (R,) int
        Frequencies, and how many of them did not converge.
    at_edge : (R,) bool
        Whether the largest of all segments is at an end of the range.
    worst : MistunedRing
        That with the largest amplitude.
    """

    amplitude: Floats = field(metadata={"unit": "m"})
    frequency: Floats = field(metadata={"unit": "Hz"})
    tuned: Floats = field(metadata={"unit": "m"})
    points: Integers
    lost: Integers
    at_edge: Booleans
    worst: MistunedRing

    @property
    def amplification(self) -> Floats:
        """(R, N) amplitudes over that of a tuned ring."""
        return self.amplitude / self.tuned[:, None]

    @property
    def largest(self) -> Floats:
        """(R,) amplification of the worst segment of each ring; NaN where nothing converged."""
        return np.asarray(self.amplification.max(axis=1))

    @property
    def place(self) -> tuple[int, int] | None:
        """Ring and segment of the largest amplitude; None if nothing converged."""
        if np.isnan(self.amplitude).all():
            return None
        ring, segment = np.unravel_index(np.nanargmax(self.amplitude), self.amplitude.shape)
        return int(ring), int(segment)


def _check(problem: "Problem", keys: MistuningKeys) -> Iterator[str]:
    """What keeps segments from differing."""
    sectors, known = problem.ring.sectors, problem.joint_names
    ready = getattr(problem, "system", None) is not None  # whose file says how many
    if sectors == 1 and not ready:
        yield "mistuning: needs a ring of several segments: ring.sectors = 1"
    of_study = hasattr(problem, "joints")
    table, joints = ("joints" if of_study else "contacts"), "|".join(known) or r"[\w-]+"
    for name, value in keys.keys.items():
        where, count = f'mistuning.keys."{name}"', len(value) if isinstance(value, tuple) else 0
        own = of_study and name == FREQUENCY
        if not own and not re.fullmatch(rf"{table}\.({joints})\.({'|'.join(OF_JOINT)})", name):
            allowed = f"{', '.join(OF_JOINT)} of {table}.{f', {table}.'.join(known) or '<name>'}"
            yield f"{where}: allowed are {allowed}{f', and {FREQUENCY}' if of_study else ''}"
        elif count and name.endswith(".slider"):
            yield f"{where}: given {count} numbers: needs 1"
        elif count and not ready and count != sectors:
            yield f"{where}: given {count} numbers: needs 1, or one a segment: {sectors}"
    if "rings" in keys.model_fields_set and keys.count != keys.rings:
        yield f"mistuning.rings = {keys.rings}: all deviations are given by segment: one ring"


def _parts(problem: "Problem", keys: MistuningKeys) -> Sequence[AnalysisPart]:
    """One for each ring."""
    alike = {"vane_modes": max(VANE_MODES, problem.response.mode), "seed": problem.seed}
    return [AnalysisPart(f"ring {i + 1}", {"ring": i, **alike}) for i in range(keys.count)]


def _compute(case: "SolvedCase", keys: MistuningKeys, part: AnalysisPart) -> MistunedRing:
    """One ring of a case."""
    system, watched = case.whole, case.monitored
    count = part.inputs["vane_modes"]
    of_vane = _vane_modes_step(case.planned, count) if FREQUENCY in keys.keys else None
    modes = None if of_vane is None else case.get(of_vane)
    hertz = case.frequencies if keys.range is None else (keys.range[0], keys.range[1])
    found = nonlinear.ring_response(
        system,
        hertz,
        _drawn(system, keys, (part.inputs["seed"], part.inputs["ring"]), modes),
        case.options,
        modes=case.modes,
        shared=case.get(_ring_modes_step(case.planned, of_vane)).diameters,
    )
    return MistunedRing(
        found.frequency,
        found.amplitude[:, :, watched.node, watched.component],
        found.converged,
        float(found.alike[watched.node, watched.component]),
    )


def _vane_modes_step(planned: "Planned", count: int) -> "Step[nonlinear.SectorModes]":
    """Modes of a vane alone, free, as they are seen in the ring's coordinates."""
    from vanelock.pipeline.step import step

    def compute(system: "System", vane: "Component") -> nonlinear.SectorModes:
        part = {}
        for k, one in system.diameters.items():
            part[k] = np.zeros((vane.size, len(one.K)))
            part[k][np.arange(vane.size), one.parts["vane"]] = 1.0
        block = vane.at(0)
        return nonlinear.SectorModes.of_part(system, block.K.real, block.M.real, part, count)

    needs, kind = (planned.structure.whole, planned.part("vane", 0)), nonlinear.SectorModes
    return step("vane modes", "rom", {"count": count}, kind, needs, compute, False, True)


def _ring_modes_step(
    planned: "Planned", modes_of_vane: "Step[nonlinear.SectorModes] | None"
) -> "Step[nonlinear.HarmonicModes]":
    """Stuck modes of all nodal diameters, which all rings share."""
    from vanelock.pipeline.step import step

    def compute(system: "System", stuck: Any, *others: Any) -> nonlinear.HarmonicModes:
        return nonlinear.ring_modes(system, *(others or (None,)), stuck=stuck.diameters)

    needs = tuple(filter(None, (planned.structure.whole, planned.modes, modes_of_vane)))
    kind = nonlinear.HarmonicModes
    return step("ring modes", "nonlinear", {}, kind, needs, compute, False, True)


def _drawn(
    system: "System",
    keys: MistuningKeys,
    seeds: tuple[int, int],
    modes: "nonlinear.SectorModes | None" = None,
) -> "nonlinear.Mistuning":
    """By how much the segments of a ring differ, drawn from the study's seed and its number."""
    asked: dict[str, dict[str, Any]] = {}
    for key, value in keys.keys.items():
        *_, joint, name = key.split(".")
        asked.setdefault("modes" if key == FREQUENCY else joint, {})[name] = value
    seed = int(np.random.SeedSequence(seeds).generate_state(1)[0])
    return nonlinear.Mistuning.scatter(system, asked, seed, modes)


def _combine(rings: Sequence[MistunedRing]) -> MistunedRings:
    """Rings in numbers."""
    known = [ring.known for ring in rings]
    amplitude = np.array([each.max(axis=0) for each in known])
    at = np.array([each.argmax(axis=0) for each in known])
    largest = [int(each.max(axis=1).argmax()) for each in known]
    return MistunedRings(
        amplitude=np.where(amplitude < 0, np.nan, amplitude),
        frequency=np.array([ring.frequency[i] for ring, i in zip(rings, at, strict=True)]),
        tuned=np.array([ring.tuned for ring in rings]),
        points=np.array([len(ring.frequency) for ring in rings]),
        lost=np.array([np.count_nonzero(~ring.converged) for ring in rings]),
        at_edge=np.array(
            [i in (0, len(r.frequency) - 1) for i, r in zip(largest, rings, strict=True)]
        ),
        worst=rings[int(np.argmax(amplitude.max(axis=1)))],
    )


def _warnings(case: "CaseResult", products: Sequence[MistunedRings]) -> Iterator[str]:
    """What keeps rings from being taken as they are."""
    (found,), peak = products, case.peak
    if peak is None:
        return
    if lost := int(found.lost.sum()):
        yield (
            f"{lost} of {found.points.sum()} points of mistuned rings DID NOT CONVERGE: "
            "a segment may vibrate more than is shown"
        )
    if edge := int(found.at_edge.sum()):
        yield (
            f"{edge} of {len(found.largest)} mistuned rings vibrate most at the end of the "
            "frequency range: a peak may lie beyond"
        )
    tuned = float(found.tuned[0])
    if not abs(tuned - peak.amplitude) <= APART * peak.amplitude:
        yield (
            f"mistuned rings are compared with {1e6 * tuned:.4g} um of a tuned one in "
            f"their range, while the peak of the curve is {1e6 * peak.amplitude:.4g} um"
        )


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """Of each case how far mistuned rings are amplified, and the worst segment."""
    known, count = products_of(cases, "mistuning")
    columns = (
        Column("case"),
        Column("rings"),
        Column(
            "amplification, 5 %",
            form=".4f",
            key="p5",
            note="amplification: of the worst segment, over the peak of a tuned ring",
        ),
        Column("50 %", form=".4f", key="p50"),
        Column("95 %", form=".4f", key="p95"),
        Column("largest", form=".4f", key="largest"),
        Column("peak", "µm", key="peak_um", note="peak, at: of the worst segment of all rings"),
        Column("at", "Hz", ".6g", "frequency_hz"),
        Column("ring"),
        Column("segment"),
        Column("points"),
        Column("not converged", key="lost"),
    )
    rows: list[tuple[Cell, ...]] = []
    flags: list[Flag] = []
    for name, (each,) in known.items():
        finite = each.largest[np.isfinite(each.largest)]
        many = len(finite) > 1
        shares = np.percentile(finite, PERCENTILES).tolist() if many else [None] * 3
        worst: tuple[Cell, ...] = (None,) * 5
        if (place := each.place) is not None:
            ends = each.amplitude[place], each.frequency[place]
            worst = (float(finite.max()), *ends, *(i + 1 for i in place))
        lost, points = int(each.lost.sum()), int(each.points.sum())
        rows.append((name, len(each.largest), *shares, *worst, points, lost or None))
        flags.append("warn" if lost else "")
    sectors = [each.amplitude.shape[1] for (each,) in known.values()][:1]
    notes = [
        "one linear mode a segment, without friction, reaches at most "
        f"{nonlinear.whitehead(N):.2f} (Whitehead, 1966)"
        for N in sectors
    ]
    made = Table("Mistuned rings", columns, rows, notes, "mistuning", flags)
    yield from by_case(made.without_empty("p5", "p50", "p95", "lost"), count)


def _answers(case: "CaseResult") -> "Iterator[report.Answer]":
    """How much more the worst segment vibrates."""
    for found in case.found("mistuning"):
        if (place := found.place) is None:
            continue
        ring, segment = place
        count = len(found.largest)
        of = f"of ring {ring + 1}, the worst of {count} drawn" if count > 1 else "of the ring given"
        note = (
            f"of a tuned ring: segment {segment + 1} {of}, {1e6 * found.amplitude[place]:.3g} µm "
            f"at {found.frequency[place]:.2f} Hz"
        )
        verdict = "warn" if found.lost.any() or found.at_edge.any() else ""
        yield report.Answer("Mistuning", f"{found.amplification[place]:.3f} times", note, verdict)


def _pictures(run: "RunResult", case: "CaseResult") -> "Iterator[report.Picture]":
    """The worst ring, and the numbers of all."""
    (found,), name = case.found("mistuning"), case.name
    if (place := found.place) is None:
        return
    ring, segment = place
    curve, worst, count = case.drawn, found.worst, len(found.largest)
    title = f"Mistuned ring{of_case(name)}"
    which = f"the worst of {count} rings; " if count > 1 else ""
    subtitle = (
        f"{which}segment {segment + 1} vibrates {found.amplification[place]:.3f} times as much "
        f"as those of a tuned ring; {case.monitor.name}"
    )
    known = np.where(worst.converged[:, None], worst.amplitude, np.nan)
    lines = worst.frequency, known, curve[:2], found.amplification[ring]
    caption = (
        f"The ring with the largest vibration{of_case(name)}. Above: response of all its "
        "segments, and what they would do if all were alike. Below: largest amplitude of each "
        "segment over the peak of a tuned ring. The table has all rings."
    )
    rings, sectors = found.amplitude.shape
    columns = {
        "ring": np.repeat(np.arange(rings) + 1, sectors),
        "segment": np.tile(np.arange(sectors) + 1, rings),
        "amplitude (µm)": 1e6 * found.amplitude.ravel(),
        "frequency (Hz)": found.frequency.ravel(),
        "amplification (-)": found.amplification.ravel(),
    }
    yield run.picture(
        f"figures/mistuning_{slug(name)}",
        "Mistuned rings",
        [*case.key_of("mistuning"), case.key_at("response"), title, subtitle],
        lambda path: render.segments_picture(path, *lines, title, subtitle),
        lambda: columns,
        [f"{title}: largest amplitude of every segment; {case.monitor.name}"],
        caption,
    )


TEMPLATE = """\
# Rings whose segments are not alike, and how much more the worst segment vibrates: standard
# deviations, relative, or lists with one number a segment. See `vanelock manual mistuning`.
# [mistuning]
# rings = 20                    # drawn
# range = [250, 290]            # Hz; that of the response if left out
# [mistuning.keys]
# "JOINT.mu" = 0.05             # and interference, kn, kt
# "JOINT.slider" = 0.1          # static friction, of its limit
# "vane.frequency" = 0.005      # natural frequencies of a study's vane alone
"""

MISTUNING = Analysis(
    key="mistuning",
    title="mistuning",
    keys=MistuningKeys,
    scene_keys=MistuningKeys,
    product=lambda: MistunedRing,
    compute=_compute,
    parts=_parts,
    combine=_combine,
    whole_ring=lambda problem, keys: True,
    elements=True,
    check=_check,
    # about one point of a tuned ring for each of a segment
    cost=lambda study, keys, curve: keys.count * study.ring.sectors * curve,
    warnings=_warnings,
    tables=_tables,
    pictures=_pictures,
    answers=_answers,
    text=TEXT,
    template=TEMPLATE,
    absent=lambda case: ABSENT if case.ring[0] > 1 else "",
)
