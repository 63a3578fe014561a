"""Peak memory of runs, stage by stage, beside what a run says of itself; and of factors.

    python -m benchmarks.runs.memory [--accuracy 0.01] [--write]

prints the tables; `--write` puts them into docs/benchmarks/memory.md. Each run is one process that
computes all by itself; `--accuracy` adds a run with that key alone: some minutes.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from benchmarks.isolated import memory  # isort: skip  # it sets the threads

import numpy as np

from benchmarks.pages import page
from benchmarks.segment import CASING_MASTERS, MATERIAL, VANE_MASTERS
from vanelock import fem, load_study, mesh, run_study
from vanelock.fem.solvers.backend import factor_bytes
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.progress import Begun, Event
from vanelock.stages.cost_estimate import CostEstimate, estimated

FOUR = (
    '[mesh]\nsize = "medium"\n[sweep]\n"joints.interlock.mu" = [0.15, 0.3]\n'
    '"response.harmonics" = [1, 3]\n'
)
STUDIES = {"coarse": '[mesh]\nsize = "coarse"\n', "medium, four cases": FOUR}
SIZES = (0.025, 0.018, 0.0115, 0.008)
RUNS = """\
Resident memory, GB, and processor time, min, of one process; "said": what the run says of itself.

| study | dofs | peak | said | to reduced models | responses | pictures | time | said |
|---|---:|---:|---:|---:|---:|---:|---:|---:|"""
FACTORS = """\
Factors of a part with its faces and contacts kept, bytes a row, by symbolic and numerical factor of
CHOLMOD, and by the law of `vanelock.fem.solvers.backend`.

| part | element | rows | entries of L | bytes | law | ratio |
|---|---:|---:|---:|---:|---:|---:|"""


def measured(study: Path, folder: str) -> dict[str, float]:
    """Peaks of the kinds of stage, GB, and processor time, s. Runs in the child process."""
    peaks: dict[str, float] = {}
    kind = ["mesh"]

    def watch() -> None:
        while True:
            peaks[kind[0]] = max(peaks.get(kind[0], 0.0), 1.048576e-3 * memory("VmRSS"))
            time.sleep(0.05)

    def listener(event: Event) -> None:
        if isinstance(event, Begun):
            word = event.stage.replace("/", " ").partition(" ")[0]
            early = word in ("mesh", "fem", "rom")
            late = word in ("preload", "response", "linear", "system")
            kind[0] = "mesh" if early else "response" if late else "pictures"

    threading.Thread(target=watch, daemon=True).start()
    run_study(load_study(study), folder, listener)
    return peaks | {"seconds": time.process_time()}


def taken(text: str) -> tuple[dict[str, float], CostEstimate]:
    """What `measured` finds of a study, and what its run says beforehand."""
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "study.toml"
        study.write_text(text, "utf-8")
        command = [sys.executable, "-m", "benchmarks.runs.memory", "--child", str(study)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        found = json.loads(done.stdout.splitlines()[-1])
        said = estimated(cases(load_study(study)))
    assert said is not None
    return found, said


def run(name: str, text: str) -> str:
    """A row of the table."""
    found, said = taken(text)
    kinds = [found.get(kind, 0.0) for kind in ("mesh", "response", "pictures")]
    peak, shown = max(kinds), " | ".join(f"{each:.2f}" for each in kinds)
    minutes = f"{found['seconds'] / 60:.1f} | {said.seconds / 60:.1f}"
    return f"| {name} | {said.dofs:,.0f} | {peak:.2f} | {said.memory / 1e9:.2f} | {shown} | {minutes} |"


def factor(part: str, size: float) -> str:
    """A row of the table of factors."""
    if part == "vane":
        made, masters = mesh.vane_segment(size=size), VANE_MASTERS
    else:
        made, masters = mesh.casing_sector(size=size), CASING_MASTERS
    model = fem.assemble(made, MATERIAL)
    nodes = np.unique(np.concatenate([made.node_sets[name] for name in masters]))
    if part == "casing":
        nodes = np.union1d(nodes, np.concatenate(fem.cyclic_faces(made, made.sectors)))
    kept = np.unique(model.dofs[nodes])
    _, interior = fem.schur_complement(model.K, kept[kept >= 0])
    entries = interior.nonzeros
    rows, law = model.K.shape[0], factor_bytes(model.K.shape[0])
    each = f"{8 * entries / rows:,.0f} | {law / rows:,.0f} | {law / (8 * entries):.2f}"
    return f"| {part} | {1e3 * size:g} mm | {rows:,} | {entries:,} | {each} |"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--child")
    parser.add_argument("--accuracy", type=float)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    if given.child:
        print(json.dumps(measured(Path(given.child), str(Path(given.child).parent / "run"))))
        return
    lines: list[str] = []

    def write(text: str) -> None:
        print(text, flush=True)
        lines.append(text)

    write(f"## Factors\n\n{FACTORS}")
    for size in SIZES:
        for part in ("vane", "casing"):
            write(factor(part, size))
    studies = dict(STUDIES)
    if given.accuracy:
        studies[f"accuracy = {given.accuracy:g}"] = f"accuracy = {given.accuracy:g}\n"
    write(f"\n## Runs\n\n{RUNS}")
    for name, text in studies.items():
        write(run(name, text))
    page("memory", "Memory of a run", lines, given.write)


if __name__ == "__main__":
    main()
