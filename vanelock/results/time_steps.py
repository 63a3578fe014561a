"""The period at a case's peak, instant by instant, for ParaView.

Of sector 0 at the time t = k T/K: what vibrates, that with the state at rest, and the vane's von
Mises stress,

    u(t) = Re Σ_{h=1}^{H} u_h e^{ihωt},    u_0 + u(t),    von Mises of σ_0 + Re Σ σ_h e^{ihωt}.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, render
from vanelock.input.cases.names import slug
from vanelock.quantities.curves_and_fields import RunData, Shape
from vanelock.stages.parts.components import PARTS
from vanelock.stages.plan import Planned


def steps(run_data: RunData, each: Planned) -> tuple[Path, ...]:
    """The list of the instants of a case, where the study asks for some."""
    count, name = run_data.study.outputs.steps, each.case.name
    if not count:
        return ()
    top, peak = run_data.top(each), run_data.shown.peak[name]
    shows = [each.response.key, name, run_data.shown.monitor.name, count]
    folder = f"shapes/response_{slug(name)}"

    @cache
    def stresses() -> Shape:
        return run_data.stresses(each)

    def fields(i: int, angle: float) -> Mapping[str, NDArray[np.float64]]:
        harmonics = {h: run_data.harmonic(each, h)[i] for h in range(top.harmonics + 1)}
        rest = np.real(harmonics.pop(0))
        vibration = render.at_instant(harmonics, angle)
        found = {"vibration (m)": vibration, "displacement (m)": rest + vibration}
        if PARTS[i] == "vane":
            stress = render.at_instant(dict(enumerate(stresses())), angle)
            found["von_mises (Pa)"] = fem.von_mises(stress)
        return found

    files = []
    for k in range(count):
        row = []
        for i, part in enumerate(PARTS):

            def write(path: Path, i: int = i, k: int = k) -> None:
                angle = 2 * np.pi * k / count
                render.write_step(path, run_data.parts(each)[i], fields(i, angle))

            row.append(
                run_data.output_files.draw(f"{folder}/{part}_{k:03d}.vtu", shows, write, quick=True)
            )
        files.append(row)
    times = [k / count / peak.frequency for k in range(count)]
    listed = run_data.output_files.draw(
        f"{folder}.pvd", shows, lambda path: render.write_pvd(path, times, files), quick=True
    )
    return (listed,)
