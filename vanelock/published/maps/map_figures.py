"""Maps of where each statement holds, errors over the plane, and the peak over decades."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vanelock import render
from vanelock.published.evidence import (
    REFERENCE,
    Evidence,
    error,
    falls,
    higher_and_lower,
    slight,
)
from vanelock.published.maps.optimum import Ridge
from vanelock.published.maps.plane import Method, Plane
from vanelock.published.sheets import COUPLINGS, load_of
from vanelock.published.statements import NONE, SLIGHT
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture

Floats = NDArray[np.float64]

AXES = {"interference": "interlock interference (µm)", "load": "load / the study's"}
SCALE = {"interference": 1e6, "load": 1.0}


def orders(plane: Plane) -> list[int]:
    """Harmonics of the plane's coupled methods, ascending."""
    texts = [name for name in plane.methods if name.startswith("coupled")]
    return sorted(int(text.rpartition("= ")[2]) for text in texts)


def holds(plane: Plane) -> dict[str, NDArray[np.bool_]]:
    """(m, v) where each statement that can be mapped holds, by what it says."""
    amplitude, _ = plane.of(REFERENCE)
    along = "interference" if plane.other == "interference" else "load"
    found = {"peak falls with friction": falls(amplitude, 0)}
    if along == "interference":
        found["peak falls with interference"] = falls(amplitude, 1)
    for coupling in COUPLINGS[1:]:
        found[f"{coupling}: higher f, lower A"] = higher_and_lower(plane, coupling)
    known = orders(plane)
    if len(known) > 1:
        found[f"H = {known[1]} changes < {SLIGHT:.0%}"] = slight(plane, known[0], known[1], SLIGHT)
    if len(known) > 2:
        found[f"H = {known[2]} changes < {NONE:.0%}"] = slight(plane, known[1], known[2], NONE)
    return found


def panels(plane: Plane, with_errors: bool) -> list[render.MapPanel]:
    """Peak, where statements hold, and the errors of cheaper methods in percent."""
    best = Method(orders(plane)[-1])
    amplitude, frequency = plane.of(best)
    made = [
        render.MapPanel(f"peak (µm), {best.name}", 1e6 * amplitude, ".3g", logarithmic=True),
        render.MapPanel("its frequency (Hz)", frequency, ".1f"),
        render.MapPanel("interlock pairs that lift off (%)", 100 * plane.opening[..., 0], ".0f"),
    ]
    made += [render.MapPanel(title, values) for title, values in holds(plane).items()]
    if with_errors:
        for method in [REFERENCE, *(Method(1, each) for each in COUPLINGS[1:])]:
            values = 100 * error(plane, method, best)
            title = f"error of {method.name} (%)"
            made.append(render.MapPanel(title, values, "+.0f", diverging=True))
    return made


def map_picture(run_data: RunData, e: Evidence, name: str, plane: Plane, words: str) -> Picture:
    """A plane's maps and its data."""
    scale = SCALE[plane.other]
    title = f"Where each statement holds: {words}"
    own = e.plan.base.joints.interlock
    at = own.interference if plane.other == "interference" else 1.0
    caption = (
        "Each cell is a computed response; its peak is that of the best method here. Yes and no "
        "say whether the statement of the published study holds there. Errors are those of the "
        f"peak against {Method(orders(plane)[-1]).name}. "
    )
    file, shows = f"figures/{name}", [title, e.monitor, *_numbers(plane)]
    path = run_data.output_files.draw(
        f"{file}.png",
        shows,
        lambda path: render.map_picture(
            path,
            (scale * plane.value).tolist(),
            plane.mu.tolist(),
            panels(plane, len(orders(plane)) > 1),
            AXES[plane.other],
            "friction coefficient",
            title,
            f"Monitored: {e.monitor}",
            (scale * at, own.mu),
        ),
    )
    data = run_data.table(f"{file}.csv", shows, lambda: plane_columns(plane), [title])
    return Picture(path, title, caption, (data,))


def plane_columns(plane: Plane) -> Mapping[str, ArrayLike]:
    """A plane as columns, a row for each cell and method."""
    m, v, k = plane.amplitude.shape
    unit = "interference (µm)" if plane.other == "interference" else "load (factor)"
    return {
        "friction coefficient": np.repeat(plane.mu, v * k),
        unit: SCALE[plane.other] * np.tile(np.repeat(plane.value, k), m),
        "method": np.array(list(plane.methods) * (m * v)),
        "peak (µm)": 1e6 * plane.amplitude.ravel(),
        "at (Hz)": plane.frequency.ravel(),
        "lifting off (share)": plane.opening.ravel(),
        "slipping (share)": plane.slipping.ravel(),
        "points not converged": plane.lost.ravel(),
        "points": plane.points.ravel(),
        "processor time (s)": plane.seconds.ravel(),
    }


def map_pictures(run_data: RunData, e: Evidence) -> list[Picture]:
    """Maps over friction and interference, friction and load, and for other slants."""
    base = e.plan.base
    slant = getattr(base.vane, "interlock_slant", None)
    words = "" if slant is None else f", slant {slant:g}°"
    unit = "kg m" if base.excitation.unbalance else "N a node"
    made = [
        map_picture(
            run_data,
            e,
            "map_interference",
            e.planes["interference"],
            f"friction and interference{words}, {load_of(base):g} {unit}",
        ),
        map_picture(run_data, e, "map_load", e.planes["load"], f"friction and load{words}"),
    ]
    for other, plane in e.slants.items():
        text = f"friction and interference, slant {other:g}°"
        made.append(map_picture(run_data, e, f"map_slant{other:g}", plane, text))
    return made


def ridge_picture(run_data: RunData, e: Evidence) -> Picture:
    """The peak against friction and interference over decades."""
    marked = {
        "mu": e.plan.base.joints.interlock.mu,
        "interference": 1e6 * e.plan.base.joints.interlock.interference,
    }
    labels = {"mu": "friction coefficient", "interference": "interlock interference (µm)"}
    limits = [(f"linear, interlock {which}", e.linear[which].amplitude) for which in e.linear]
    drawn = []
    for name, label in labels.items():
        lines = [_line(each) for each in e.ridges if each.name == name]
        drawn.append(render.RidgePanel(label, lines, limits, marked[name]))
    title = "Peak over decades of friction and interference"
    shows = [title, e.monitor, [_values(line) for panel in drawn for line in panel.lines]]
    path = run_data.output_files.draw(
        "figures/optimum.png",
        shows,
        lambda path: render.ridge_picture(path, drawn, title, e.monitor),
    )
    data = run_data.table("figures/optimum.csv", shows, lambda: _ridge_columns(e), [title])
    caption = (
        "The peak itself followed along each parameter, the other one as in the study; the ring "
        "marks the least. With little friction the peak is that of the free interlock."
    )
    return Picture(path, title, caption, (data,))


def _line(ridge: Ridge) -> render.RidgeLine:
    scale = 1e6 if ridge.name == "interference" else 1.0
    best = ridge.best
    return render.RidgeLine(
        scale * ridge.parameter,
        np.where(ridge.converged, ridge.amplitude, np.nan),
        f"H = {ridge.harmonics}",
        None if best is None or best[2] else (scale * best[0], best[1]),
    )


def _values(line: render.RidgeLine) -> list[list[float | None]]:
    arrays = [np.asarray(line.parameter, float), np.asarray(line.amplitude, float)]
    return [[None if x != x else x for x in array.tolist()] for array in arrays]


def _ridge_columns(e: Evidence) -> Mapping[str, ArrayLike]:
    found: dict[str, ArrayLike] = {}
    for ridge in e.ridges:
        scale, unit = (1e6, " (µm)") if ridge.name == "interference" else (1.0, "")
        words = f"{ridge.name}{unit}, H = {ridge.harmonics}"
        found[words] = scale * ridge.parameter
        found[f"peak (µm) along {words}"] = np.where(ridge.converged, 1e6 * ridge.amplitude, np.nan)
        found[f"at (Hz) along {words}"] = np.where(ridge.converged, ridge.frequency, np.nan)
    return found


def _numbers(plane: Plane) -> Sequence[object]:
    """All of a plane as JSON can hold it."""
    arrays = plane.mu, plane.value, plane.amplitude, plane.frequency, plane.opening
    return [
        [None if x != x else x for x in np.asarray(array, float).ravel().tolist()]
        for array in arrays
    ]
