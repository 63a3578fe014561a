"""Where the published trends hold, and where the waves behind them are stable.

    python -m benchmarks.solver.trends_and_stability [--study FILE] [--write]

Peaks of a study's ring over the interlock's friction and the load, by the methods of
`examples/paper`, and whether the ring stays with the coupled wave of three harmonics. Only the
ratio of load to interference matters while the hooks stick: a scene with both doubled has twice
the peak.
"""

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.pages import FOLDER, page
from examples.paper.paper import FEW, ONE, Model, Peak, Plane, draw_panels, holds, peak
from vanelock import cases, load_study, nonlinear, parse_study
from vanelock.analyses.stability import WORDS, StabilityKeys
from vanelock.nonlinear import Options, Stability
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.stages.plan import plan
from vanelock.stages.response.responses import monitor

NAME = "trends_and_stability"
PICTURE = FOLDER / f"{NAME}.png"
MU = (0.06, 0.1, 0.15, 0.2, 0.3)
LOAD = (0.1, 0.15, 0.2, 0.25, 0.5, 1.0)
METHODS = (*FEW, Options(3), Options(5))
NEAR = (240.0, 300.0)
HARMONICS = 3
THREE = Options(HARMONICS)


def scene(path: Path | None, folder: Path) -> tuple[Model, str]:
    """A study's first case with all nodal diameters, and its load."""
    given = parse_study("") if path is None else load_study(path)
    given = given.model_copy(update={"sweep": {}, "stability": StabilityKeys(), "bounds": None})
    stages = Stages(Cache(folder, print), lambda event: None)
    (planned,) = plan(cases(given))
    system = stages.get(planned.structure.whole)
    free = stages.get(planned.linear.responses["free"])
    watched = monitor(given.outputs.monitor, system, free)
    joint = given.joints.interlock
    load = f"{given.excitation.force_per_node:g} N a node, {1e6 * joint.interference:g} µm"
    return Model(system, NEAR, (watched.node, watched.component)), load


def verdict(model: Model) -> Stability:
    """Stability of the wave at the peak."""
    found = model.solve(THREE)
    return nonlinear.stability(model.system, found.response, [found.top], modes=model.modes)


def solved(model: Model, folder: Path) -> tuple[Plane, dict[tuple[float, float], Stability]]:
    """The plane of peaks, and stability by friction and load; kept in a folder on the way."""
    every = range(model.system.sectors // 2 + 1)
    held = {k: nonlinear.stuck_modes(model.system, k) for k in every}
    model = model.prepared(5)
    model = replace(model, modes={**model.modes, **held})
    lines, waves = [], {}
    for mu in MU:
        lines.append([])
        for load in LOAD:
            peaks, wave = (folder / f"{mu:g}-{load:g}-{each}" for each in ("peaks.json", "wave.h5"))
            changed = model.changed(mu, load=load)
            if not wave.exists():
                peaks.write_text(json.dumps([peak(changed, each) for each in METHODS]))
                verdict(changed).save(wave)
            lines[-1].append([Peak(*each) for each in json.loads(peaks.read_text())])
            waves[mu, load] = Stability.load(wave)
            print(f"mu {mu:g}, load {load:g}: {worded(waves[mu, load])}", flush=True)
    return Plane("load", MU, LOAD, METHODS, lines), waves


def worded(stability: Stability) -> str:
    """Verdict and growth a period."""
    growth = float(np.abs(stability.multiplier[0, 0]))
    return f"{WORDS[int(stability.verdict[0])]}, {growth:.3f}"


def trends(found: Plane) -> dict[str, np.ndarray]:
    """(m, v) where each statement holds; interference grows as the load falls."""
    amplitude = found.of(ONE) / found.value
    rises = np.zeros(amplitude.shape, bool)
    rises[:, :-1] = np.diff(amplitude, axis=1) > 0
    rises[:, -1] = rises[:, -2]
    return {**holds(found), "peak falls with interference": rises}


def lines_of(found: Plane, waves: dict[tuple[float, float], Stability], load: str) -> list[str]:
    """The page's lines; draws its picture."""
    held = trends(found)
    every = np.logical_and.reduce(list(held.values()))
    growth = [[np.abs(waves[mu, v].multiplier[0, 0]) for v in LOAD] for mu in MU]
    stays = np.array([[waves[mu, v].verdict[0] == 0 for v in LOAD] for mu in MU])
    scaled, hertz = found.of(THREE) / found.value, found.of(THREE, "frequency")
    panels = {
        "peak (µm) over load, H = 3": 1e6 * scaled,
        "growth a period": np.array(growth),
        "wave is stable": stays,
        **held,
        "all of them, and stable": every & stays,
    }
    title = "Where the published trends hold, and where their waves are stable"
    draw_panels(PICTURE, title, panels, found, f"load / ({load})")
    PICTURE.with_suffix(".csv").unlink()  # the page has the numbers
    lines = [
        "Peaks of the default vane over the interlock's friction and the load, and whether the "
        "ring stays with their waves (H = 3 and 5). Trends: those of the "
        "published study (`examples/paper`) that a map can check, at H = 1; that of interference "
        f"by the load, since the one over the other decides. Load 1: {load} of interference. "
        "Growth: what a period makes of the perturbation that decays slowest or grows fastest, and "
        "its nodal diameter, ND.",
        "",
        "| mu | load | peak / load, um | Hz | growth a period | ND | wave | trends that hold |",
        "|---:|---:|---:|---:|---:|---:|---|---:|",
    ]
    for i, mu in enumerate(MU):
        for j, value in enumerate(LOAD):
            wave, count = waves[mu, value], sum(bool(each[i, j]) for each in held.values())
            lines.append(
                f"| {mu:g} | {value:g} | {1e6 * scaled[i, j]:.2f} "
                f"| {hertz[i, j]:.1f} | {growth[i][j]:.3f} "
                f"| {wave.diameter[0, 0]} | {WORDS[int(wave.verdict[0])]} "
                f"| {count} of {len(held)} |"
            )
    return [*lines, "", f"![maps of both]({PICTURE.name})"]


def main() -> None:
    """Print the table, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--study", type=Path, help="the default study unless given")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "trends")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    given.folder.mkdir(exist_ok=True)
    model, load = scene(given.study, given.folder / "cache")
    lines = lines_of(*solved(model, given.folder), load)
    print("\n".join(lines))
    page(NAME, "Published trends, and stability", lines, given.write)


if __name__ == "__main__":
    main()
