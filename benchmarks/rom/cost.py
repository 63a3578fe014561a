"""What a reduction costs: its routes against each other, and all from mesh to `System`.

    python -m benchmarks.rom.cost [--vane 0.0058] [--casing 0.0095] [--write]

prints the tables; `--write` puts them into docs/benchmarks/reduction_cost.md as well. CPU times on
one thread. Each reduction runs in a process of its own.
"""

import argparse
import ctypes
import gc
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.isolated import memory  # isort: skip  # it sets the threads

import numpy as np
import scipy.linalg as sl

from benchmarks.pages import page
from benchmarks.rom.direct import direct
from benchmarks.segment import CASING_MASTERS, JOINTS, MATERIAL, VANE_MASTERS
from vanelock import fem, mesh, rom
from vanelock.stages.parts.segment import Segment

ROUTES: dict[str, dict[str, Any]] = {
    "paper": {"route": "paper", "modes": 10},
    "direct": {"interface": "published", "modes": 10},
    "direct, followed": {"interface": "followed", "modes": 10},
    "cyclic, 10 modes": {"modes": 10},
    "cyclic, default": {},
}
DIAMETERS = ([1], [0, 1, 2, 3])
INTRODUCTION = """\
The casing's sector, {dofs} dofs, {face} of them on the cyclic faces and {masters} masters; ten
fixed-interface and ten face modes, or the default accuracy up to the vane's {band:.0f} Hz. "Direct"
is `benchmarks/rom/direct.py`: the subspace of the route "paper" by another way, or one with the
faces' static answer to the other masters. All take their factors from {backend}. Memory: peak of
the process during the reduction above what it held before, with the model assembled. In brackets:
over the route "paper". CPU times, one thread.

| route | coordinates | ND 1: CPU time | memory | NDs 0 to 3: CPU time | memory |
|---|---:|---:|---:|---:|---:|"""
CHAIN = """\
Vane {vane} dofs, casing {casing} dofs; default settings, nodal diameters 0 to 3, the casing in the
vane's band; a system of {size} coordinates. The unit is a real factorisation of the stiffness of
the larger part, the vane, with a little mass since it is free: {unit:.2f} s, the median of
{count} spread over the run ({low:.2f} to {high:.2f} s).

| stage | CPU time | factorisations |
|---|---:|---:|"""


LOADS = 8
"""At rest, together, so that what one adds shows."""


def spent(run: Callable[[], Any]) -> tuple[Any, float]:
    """What it returns, and its CPU time, s."""
    begin = time.process_time()
    found = run()
    return found, time.process_time() - begin


def measured(file: str, given: dict[str, Any]) -> dict[str, Any]:
    """CPU time and memory of a reduction of the casing. Runs in the child process."""
    model = fem.assemble(mesh.Part.load(file), MATERIAL)
    fem.factorise(fem.assemble(mesh.casing_sector(size="coarse"), MATERIAL).K)  # loads libraries
    gc.collect()
    if sys.platform == "linux":  # freed memory back, and the peak to what is held now
        ctypes.CDLL(None).malloc_trim(0)
        Path("/proc/self/clear_refs").write_text("5")
    before = memory("VmRSS")
    reduce = direct if "interface" in given else rom.reduce
    small, seconds = spent(lambda: reduce(model, CASING_MASTERS, **given))
    peak = memory("VmHWM")
    if small.route != "cyclic":
        fields = rom.recovery(small, model).displacement(np.eye(small.size), 1)
        np.save(f"{file}-{small.route}.npy", fields.reshape(-1, small.size))
    return {"seconds": seconds, "memory": peak - before, "size": small.size}


def in_child(file: str, given: dict[str, Any]) -> dict[str, Any]:
    """`measured` in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.rom.cost", "--child", file, json.dumps(given)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def routes(casing: mesh.Part, band: float) -> list[str]:
    """Table of the routes, and how far their subspaces are apart."""
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "casing.h5")
        casing.save(file)
        unit: list[dict[str, Any]] = []
        for name, given in ROUTES.items():
            given = given if "modes" in given else {"band": band}
            row = [in_child(file, given | {"nodal_diameters": k}) for k in DIAMETERS]
            unit = unit or row
            cells = [
                f"{r['seconds']:.1f} s ({r['seconds'] / u['seconds']:.2f}) | "
                f"{r['memory']:.0f} MB ({r['memory'] / u['memory']:.2f})"
                for r, u in zip(row, unit, strict=True)
            ]
            lines.append(f"| {name} | {row[0]['size']} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
            if name == "direct":
                spans = [np.load(f"{file}-{route}.npy") for route in ("paper", "direct")]
                angle = subspace_angle(*spans)
    lines += ["", 'The displacement fields of "paper" and "direct" at nodal diameter 1 span']
    lines += [f"subspaces at an angle of {angle:.1e}."]
    return lines


def subspace_angle(a: np.ndarray, b: np.ndarray) -> float:
    """Largest angle between the column spaces of fields, each column scaled to unit length."""
    a, b = (x / np.linalg.norm(x, axis=0) for x in (a, b))
    return float(sl.subspace_angles(a, b).max())


def chain(vane_size: str | float, casing_size: str | float) -> tuple[list[str], float]:
    """Table from mesh to `System`, and the band, Hz."""
    rows, units = {}, []

    def stage(name: str, run: Callable[[], Any]) -> Any:
        found, rows[name] = spent(run)
        return found

    fem.factorise(fem.assemble(mesh.casing_sector(size="coarse"), MATERIAL).K)  # loads libraries
    blade = stage("mesh, vane", lambda: mesh.vane_segment(size=vane_size))
    shell = stage("mesh, casing", lambda: mesh.casing_sector(size=casing_size))
    vane = stage("assembly, vane", lambda: fem.assemble(blade, MATERIAL))
    casing = stage("assembly, casing", lambda: fem.assemble(shell, MATERIAL))
    length = float(np.linalg.norm(np.ptp(blade.points, axis=0)))
    K = vane.K + (0.01 / length) ** 2 * MATERIAL.E / MATERIAL.rho * vane.M
    unit = lambda: units.append(spent(lambda: fem.factorise(K))[1])  # noqa: E731
    unit()
    small_vane = stage("reduction, vane", lambda: rom.reduce(vane, VANE_MASTERS))
    unit()
    loads = {f"heat {i}": fem.thermal(vane, blade.points[:, 2] ** i) for i in range(LOADS)}
    _, loaded = spent(lambda: rom.reduce(vane, VANE_MASTERS, loads=loads))
    unit()
    small_casing = stage(
        "reduction, casing",
        lambda: rom.reduce(
            casing, CASING_MASTERS, nodal_diameters=DIAMETERS[1], band=small_vane.band
        ),
    )
    unit()
    unit()
    system = stage("join", lambda: Segment(JOINTS, 1, 1.0).join(small_vane, small_casing))
    median = float(np.median(units))
    text = CHAIN.format(
        vane=vane.K.shape[0],
        casing=casing.K.shape[0],
        size=len(system.at(1).K),
        unit=median,
        count=len(units),
        low=min(units),
        high=max(units),
    )
    rows["all"] = sum(rows.values())
    table = [f"| {name} | {t:.2f} s | {t / median:.2f} |" for name, t in rows.items()]
    share = (loaded / rows["reduction, vane"] - 1) / LOADS
    table += [
        "",
        f"Each load at rest adds {100 * share:.1f} % to the vane's reduction, of {LOADS}.",
    ]
    return [*text.splitlines(), *table], small_vane.band


def report(vane_size: str | float, casing_size: str | float) -> list[str]:
    """Lines of the page."""
    second, band = chain(vane_size, casing_size)
    print("\n".join(second), flush=True)
    shell = mesh.casing_sector(size=casing_size)
    model = fem.assemble(shell, MATERIAL)
    masters = np.unique(np.concatenate([shell.node_sets[name] for name in CASING_MASTERS]))
    faces = model.dofs[np.concatenate([shell.node_sets[name] for name in ("left", "right")])]
    text = INTRODUCTION.format(
        dofs=model.K.shape[0],
        face=int(np.sum(faces >= 0)),
        masters=3 * len(masters),
        band=band,
        backend=fem.backends()[0].upper(),
    )
    del model
    return [
        "## Routes",
        "",
        *text.splitlines(),
        *routes(shell, band),
        "",
        "## From mesh to system",
        "",
        *second,
    ]


def main() -> None:
    """Print the tables."""
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(measured(sys.argv[2], json.loads(sys.argv[3]))))
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vane", default="0.0058", help="mesh size of the vane")
    parser.add_argument("--casing", default="0.0095", help="mesh size of the casing")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    sizes = [float(s) if s[0].isdigit() else s for s in (options.vane, options.casing)]
    lines = report(*sizes)
    print("\n".join(lines))
    page("reduction_cost", "Cost of a reduction", lines, options.write)


if __name__ == "__main__":
    main()
