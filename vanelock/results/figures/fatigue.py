"""Haigh diagrams, and the stress and wear of every node and contact as CSV."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vanelock import render
from vanelock.input.cases.names import of_case, slug, words
from vanelock.quantities.answers import CaseAnswers
from vanelock.quantities.contacts.wear_tables import contact_table
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.stress.margins import Margin
from vanelock.report import Picture

DIGITS = 6
"""Significant digits of stresses in tables of all nodes."""
HAIGH = "Haigh diagram"
"""Title of these pictures."""
MARKED = 5
"""Features marked in a Haigh diagram, gauges aside."""


def haigh(run: RunResult, found: CaseAnswers) -> Picture:
    """Haigh diagram of the vane at a case's peak, and its numbers at every node."""
    cycle, locations = found.stress.cycles.vane, found.stress.locations["vane"]
    bears = found.stress.worst["vane"][0].strength
    named = [render.Named(m.what, m.mean, m.amplitude, m.node is None) for m in _marked(found)]
    title = f"Fatigue of the vane at the peak, {found.peak.frequency:.2f} Hz"
    text = (
        f"fatigue limit {1e-6 * bears.limit:g} MPa, tensile strength {1e-6 * bears.tensile:g} MPa"
    )
    subtitle = "; ".join([*([] if found.name == "nominal" else [words(found.name)]), text])
    shows = [found.key, title, subtitle, [bears.limit, bears.tensile]]
    path = run.output_files.draw(
        f"figures/haigh_{slug(found.name)}.png",
        shows,
        lambda path: render.haigh_picture(
            path,
            cycle.mean,
            cycle.amplitude,
            ~locations.clear,
            bears.limit,
            bears.tensile,
            named,
            title,
            subtitle,
        ),
    )
    notes = [
        f"{title}{of_case(found.name)}; {text}",
        "amplitude: largest alternating von Mises stress; mean: trace of the mean stress;",
        "signed: its von Mises stress with the sign of the trace; n: Goodman safety factor",
        "clear: 0 at sharp re-entrant corners and beside point forces, where stress has no limit",
    ]
    data = run.table(f"figures/fatigue_{slug(found.name)}.csv", shows, lambda: _nodes(found), notes)
    caption = (
        f"Every node of the vane{of_case(found.name)}: what alternates at the peak over what acts "
        "at rest, as equivalent stresses (von Mises amplitude and hydrostatic mean, by Sines). "
        "Below the black Goodman line life is infinite; the safety factor n is the factor on both "
        "stresses at which they reach it. Marked: the worst locations of some features, away "
        "from sharp corners and point forces, and the gauges."
    )
    return Picture(path, HAIGH, caption, (data,), section="fatigue")


def _marked(found: CaseAnswers) -> list[Margin]:
    return [*found.stress.features["vane"][:MARKED], *found.stress.gauges[:3]]


def _nodes(found: CaseAnswers) -> dict[str, ArrayLike]:
    cycle, locations = found.stress.cycles.vane, found.stress.locations["vane"]
    bears = found.stress.worst["vane"][0].strength
    x, y, z = 1e3 * locations.part.points.T
    columns: dict[str, ArrayLike] = {
        "node": np.arange(len(x)),
        "x (mm)": _short(x),
        "y (mm)": _short(y),
        "z (mm)": _short(z),
        "feature": locations.feature.tolist(),
        "clear": locations.clear,
        "amplitude (MPa)": _short(1e-6 * cycle.amplitude),
        "mean (MPa)": _short(1e-6 * cycle.mean),
        "signed mean (MPa)": _short(1e-6 * cycle.mean_mises),
        "half of the range (MPa)": _short(1e-6 * cycle.chord),
        "n": _short(bears.reserve(cycle.amplitude, cycle.mean)),
    }
    return columns


def wear_table(run: RunResult, found: CaseAnswers) -> Path:
    """CSV of every contact's wear indicators, which the page shows as a table."""
    names, *numbers = contact_table(found.places, found.wear).by_head().items()
    columns = dict([names, *((head, _short(values)) for head, values in numbers)])
    notes = [
        f"Contacts at the peak, {found.peak.frequency:.4g} Hz{of_case(found.name)}",
        "slip: distance under load in a cycle, both ways; pressure: force over the contact's area",
    ]
    shows = [found.key, [str(k) for k in found.places.coefficient]]
    return run.table(f"figures/wear_{slug(found.name)}.csv", shows, lambda: columns, notes)


def _short(values: ArrayLike) -> list[float]:
    return [float(f"{v:.{DIGITS}g}") for v in np.asarray(values, float).ravel()]
