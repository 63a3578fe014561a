"""The least peak over the interlock's friction and interference: by gradients, and by a map.

    python -m benchmarks.solver.optimum [--size coarse] [--write]

The map has the values of `examples/paper`, each cell a response over the study's range; the search
of `vanelock optimise` begins at the study's own values, on the same reduced parts and within the
ends of the map. Printed are the least peak of both, how many frequencies each solved, and how much
longer the map took.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.pages import page
from examples.paper.paper import MAP_INTERFERENCE as INTERFERENCE
from examples.paper.paper import MAP_MU as MU
from examples.paper.paper import Model, Plane
from vanelock import parse_study
from vanelock.commands.fit.parameters import varied_parameters
from vanelock.commands.fit.refit_model import rejoined
from vanelock.commands.optimise.objective import Peaks
from vanelock.commands.optimise.search import Optimum, optimum
from vanelock.nonlinear import Options
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.stages.response.limits import frequencies


def both(size: str, harmonics: int, force: float) -> tuple[Plane, Optimum, float]:
    """The map and the optimum of the default study with a mesh, harmonics and load, N.

    Last, CPU time of the map over that of the optimum.
    """
    ends = [f"[{each[0]:g}, {each[-1]:g}]" for each in (MU, INTERFERENCE)]
    keys = [f"joints.interlock.{name}" for name in ("mu", "interference")]
    bounds = ", ".join(f"{key} = {each}" for key, each in zip(keys, ends, strict=True))
    study = parse_study(
        f'[mesh]\nsize = "{size}"\n[excitation]\nforce = {force:g}\n'
        f"[response]\nharmonics = {harmonics}\n"
        f"[optimise]\nparameters = {{ {bounds} }}"
    )
    with tempfile.TemporaryDirectory() as folder:
        stages = Stages(Cache(Path(folder), print), lambda event: None)
        model = rejoined(study, stages)
        wanted = np.asarray(frequencies(study, stages.get(model.planned.linear.limits)))
        near = float(wanted.min()), float(wanted.max())
        system = stages.get(model.planned.system)
    output = model.monitor.node, model.monitor.component
    assert study.optimise is not None
    optimum(Peaks(model, varied_parameters(study, "optimise"), near))  # compiles
    began = time.process_time()
    found = optimum(Peaks(model, varied_parameters(study, "optimise"), near), study.optimise.starts)
    ended = time.process_time()
    plane = Plane("interference", MU, INTERFERENCE, [Options(harmonics)])
    plane = plane.solved(Model(system, near, output))
    return plane, found, (time.process_time() - ended) / (ended - began)


def line(plane: Plane, found: Optimum, longer: float, force: float, harmonics: int) -> str:
    """A row of the table."""
    (method,) = plane.methods
    size = np.nan_to_num(plane.of(method), nan=np.inf)
    i, j = np.unravel_index(int(size.argmin()), size.shape)
    mu, interference = found.value
    near = beside(MU, int(i), float(mu)) and beside(INTERFERENCE, int(j), float(interference))
    solved, by_map = found.solved, int(plane.of(method, "points").sum())
    return (
        f"| {force:g} | {harmonics} | {plane.mu[i]:g}, {1e6 * plane.value[j]:g} "
        f"| {1e6 * size[i, j]:.3f} | {mu:.3f}, {1e6 * interference:.2f} | {1e6 * found.after:.3f} "
        f"| {'yes' if near else 'no'} | {by_map} | {solved} | {found.screened} "
        f"| {by_map / solved:.1f} | {longer:.1f} |"
    )


def beside(values: tuple[float, ...], place: int, found: float) -> bool:
    """Whether a value lies between the neighbours of a map's place."""
    low, high = values[max(place - 1, 0)], values[min(place + 1, len(values) - 1)]
    return low <= found <= high


def main() -> None:
    """Print the table, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", default="medium")
    parser.add_argument("--harmonics", type=int, default=3)
    parser.add_argument("--force", type=float, nargs="+", default=[30.0])
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    lines = [
        "The default vane's least peak over friction and interference of the interlock: of a map "
        f"of {len(MU)} by {len(INTERFERENCE)} responses with the values of `examples/paper`, and "
        "by `vanelock optimise` from the study's own values within the map's ends. Beside: whether "
        "the optimum lies between the neighbours of the map's least cell. Ratios: of the map's "
        "frequencies to those of the search with all harmonics, and of CPU times, those with one "
        "harmonic included.",
        "",
        "| N a node | H | map: mu, µm | peak, µm | optimum: mu, µm | peak, µm | beside "
        "| frequencies, map | optimise | with one harmonic | ratio | of times |",
        "|---:|---:|---|---:|---|---:|---|---:|---:|---:|---:|---:|",
    ]
    print("\n".join(lines))
    for force in given.force:
        plane, found, longer = both(given.size, given.harmonics, force)
        lines.append(line(plane, found, longer, force, given.harmonics))
        print(lines[-1], flush=True)
    page("optimum", "The least peak by gradients and by a map", lines, given.write)


if __name__ == "__main__":
    main()
