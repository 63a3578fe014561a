"""Where the published trends hold, and where the waves behind them are stable.

    python -m benchmarks.solver.trends_and_stability [--study FILE] [--write]

Peaks of a study's ring over the interlock's friction and the load, by all methods of the campaign,
and whether the ring stays with the coupled wave of three harmonics. Only the ratio of load to
interference matters while the hooks stick: a scene with both doubled has twice the peak.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.clock import page
from vanelock import cases, load_study, nonlinear, parse_study, render
from vanelock.input.schema.assessment.bounds_and_stability import StabilityKeys
from vanelock.nonlinear import HarmonicModes, Options, Stability, System
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.published.maps import plane
from vanelock.published.maps.map_figures import holds
from vanelock.published.maps.plane import Method, Plane
from vanelock.stages.assessment.stability import WORDS, whole_step
from vanelock.stages.plan import plan
from vanelock.stages.response.monitor import monitor
from vanelock.stages.response.responses import silent_progress

ROOT = Path(__file__).resolve().parents[2]
NAME = "trends_and_stability"
PICTURE = ROOT / "docs" / "benchmarks" / f"{NAME}.png"
MU = (0.06, 0.1, 0.15, 0.2, 0.3)
LOAD = (0.1, 0.15, 0.2, 0.25, 0.5, 1.0)
METHODS = (
    Method(1),
    Method(1, "uncoupled"),
    Method(1, "constant-load"),
    Method(3),
    Method(5),
)
NEAR = (240.0, 300.0)
HARMONICS = 3


def scene(path: Path | None, folder: Path) -> tuple[System, tuple[int, int], str]:
    """The system of a study's first case with all nodal diameters, and what is monitored."""
    given = parse_study("") if path is None else load_study(path)
    given = given.model_copy(update={"sweep": {}, "stability": StabilityKeys(), "bounds": None})
    stages = Stages(Cache(folder, print), lambda event: None)
    (planned,) = plan(cases(given), silent_progress)
    system = stages.get(whole_step(planned))
    free = stages.get(planned.linear.responses["free"])
    watched = monitor(given.outputs.monitor, system, free)
    joint = given.joints.interlock
    load = f"{given.excitation.force_per_node:g} N a node, {1e6 * joint.interference:g} µm"
    return system, (watched.node, watched.component), load


def verdict(system: System, output: tuple[int, int], modes: HarmonicModes) -> Stability:
    """Stability of the wave at the peak."""
    found = nonlinear.frequency_response(
        system, NEAR, Options(HARMONICS), modes=modes.diameters, find_jumps=False
    )
    size = np.where(found.converged, found.amplitude[:, *output], -np.inf)
    return nonlinear.stability(system, found, [int(size.argmax())], modes=modes.diameters)


def solved(
    system: System, output: tuple[int, int], folder: Path
) -> tuple[Plane, dict[tuple[float, float], Stability]]:
    """The plane of peaks, and stability by friction and load; kept in a folder on the way."""
    held = {k: nonlinear.stuck_modes(system, k) for k in range(system.sectors // 2 + 1)}
    every = {**nonlinear.harmonic_modes(system, 5).diameters, **held}
    modes = HarmonicModes(every)
    points, waves = [], {}
    for mu in MU:
        for load in LOAD:
            peaks, wave = (folder / f"{mu:g}-{load:g}-{what}.h5" for what in ("peaks", "wave"))
            changed = plane.changed(system, mu, "load", load)
            if not wave.exists():
                rows = [plane.peak(changed, each, NEAR, output, modes) for each in METHODS]
                plane.of_point("load", mu, load, METHODS, rows).save(peaks)
                verdict(changed, output, modes).save(wave)
            points.append(Plane.load(peaks))
            waves[mu, load] = Stability.load(wave)
            print(f"mu {mu:g}, load {load:g}: {worded(waves[mu, load])}", flush=True)
    return plane.joined(points, MU, LOAD), waves


def worded(stability: Stability) -> str:
    """Verdict and growth a period."""
    growth = float(np.abs(stability.multiplier[0, 0]))
    return f"{WORDS[int(stability.verdict[0])]}, {growth:.3f}"


def trends(found: Plane) -> dict[str, np.ndarray]:
    """(m, v) where each statement holds; interference grows as the load falls."""
    amplitude = found.of(Method(1))[0] / found.value
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
    scaled = found.of(Method(3))[0] / found.value
    panels = [
        render.MapPanel("peak (µm) over load, H = 3", 1e6 * scaled, ".3g", logarithmic=True),
        render.MapPanel("growth a period", np.array(growth), ".3f", logarithmic=True),
        render.MapPanel("wave is stable", stays),
        *(render.MapPanel(name, where) for name, where in held.items()),
        render.MapPanel("all of them, and stable", every & stays),
    ]
    render.map_picture(
        PICTURE,
        LOAD,
        MU,
        panels,
        f"load / ({load})",
        "interlock friction coefficient",
        "Where the published trends hold, and where their waves are stable",
    )
    lines = [
        "Made by `python -m benchmarks.solver.trends_and_stability --write`.",
        "",
        "Peaks of the default vane over the interlock's friction and the load, and whether the "
        "ring stays with their waves (H = 3 and 5). Trends: those of the "
        "[published study](../campaign.md) that a map can check, at H = 1; that of interference "
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
                f"| {found.of(Method(3))[1][i, j]:.1f} | {growth[i][j]:.3f} "
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
    system, output, load = scene(given.study, given.folder / "cache")
    lines = lines_of(*solved(system, output, given.folder), load)
    print("\n".join(lines))
    page(NAME, "Published trends, and stability", lines, given.write)


if __name__ == "__main__":
    main()
