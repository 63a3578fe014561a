"""Peaks asked for to an accuracy with the mesh left open, in drawn scenes, against finer meshes.

    python -m benchmarks.accuracy.open_mesh [--data FOLDER] [--scenes 0 1 2] [--write]

runs scenes to 1 %, without an accuracy, and on a finer mesh, each in a process of its own, keeps
what it finds in the folder and goes on there where it was broken off; `--write` puts the tables
into docs/benchmarks/accuracy_open_mesh.md. Ten minutes of processor time a scene.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from benchmarks.isolated import memory  # isort: skip  # it sets the threads
from benchmarks.accuracy.asked import framed, solved, stated
from benchmarks.accuracy.references import LADDER, reference
from benchmarks.accuracy.runs import outcome
from benchmarks.accuracy.scenes import Scene, draw
from benchmarks.accuracy.tables import errors
from benchmarks.pages import page
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.rom.joining.mesh_excess import DOUBT
from vanelock.stages.accuracy.evidence import amplitude_errors_of, neglected_harmonics_step
from vanelock.stages.accuracy.mesh_errors import amplitude_error
from vanelock.stages.plan import Planned, plan

Known = dict[str, Any]
ACCURACY, MEMORY = 0.01, 8e9
"""What is asked for, and the memory that meshes may take for it, bytes."""
FINE = 0.006
"""Element size of both meshes that are taken for the truth, m."""
MODES, SETTLED = 1e-4, 1e-3
"""Of the finer run: accuracy of its reduced parts, and change of amplitude by further harmonics."""
CHOSEN = (0, 6, 12, 18, 24, 25, 31, 37, 43, 45, 50, 56, 62)
"""A scene of each design, the first to the fifth of the designs in turn, none with isotropic
friction, whose reference would take days."""
TRUTHS = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
"""What earlier runs on fine meshes found: delete one to have it computed again."""
INTRODUCTION = """\
Scenes of [accuracy](accuracy.md), one of each design, with all that a study leaves to the program:
the mesh, its correction, the fillets at the aerofoils' roots and contacts on areas; the key
`accuracy = 0.01` alone is added, and `--memory "8 GB"`. The truth is the same scene on meshes of 6
mm, corrected as well, reduced to 1e-4, its peak located with as many harmonics as change it by less
than 0.1 %. Its frequency is itself uncertain by a quarter of what was taken off, its amplitude, by
the program's own estimate, by 0.5 to 0.8 % (scenes 6, 18, 37). Of the default study, whose limit is
known without any correction, a mesh of 8 mm with a casing of 6 mm is 0.1 % off in both ([what the
correction leaves](mesh_correction.md)). Memory is the largest that a run's process held, processor
time that of its steps from the meshes to the response, pictures left out; its ratio is to the same
scene without an accuracy.
"""


def opened(number: int) -> Scene:
    """A scene with its mesh, fillets and patches left to the program."""
    scene = draw(number)
    values = {key: dict(table) for key, table in scene.values.items() if key != "mesh"}
    del values["vane"]["root_fillet"]
    values["joints"] = {
        name: {key: value for key, value in joint.items() if key != "patch"}
        for name, joint in values["joints"].items()
    }
    return replace(scene, values=values)


def truth(scene: Scene, folder: Path) -> Known:
    """The peak of a scene on the fine mesh, and what it is uncertain by."""
    study = scene.study(
        mesh={"size": FINE}, rom={"accuracy": MODES}, response={"harmonics": max(LADDER)}
    )
    stages = Stages(Cache(folder / f"design_{scene.design}" / "cache", print), silent)
    (case,) = cases(study)
    (planned,) = plan([case], lambda *_: None)
    found = reference(scene, framed(planned, stages), SETTLED)
    return {**found, "frequency_error": own_errors(planned, stages)["frequency_error"]}


def own_errors(planned: Planned, stages: Stages) -> Known:
    """What a study without an accuracy states on the first screen of its page."""
    limits, own = stages.get(planned.linear.limits), amplitude_errors_of(planned)
    assert own is not None
    frequency = DOUBT * max(limits.free_lowered, limits.stuck_lowered)
    amplitude = amplitude_error(stages.get(own), frequency)
    missed = float(np.nan_to_num(stages.get(neglected_harmonics_step(planned)).amplitude))
    return {"amplitude_error": amplitude + missed, "frequency_error": frequency}


def run(scene: Scene, folder: Path, accuracy: float | None) -> Known:
    """A scene run to an accuracy, or without one."""
    study = scene.study() if accuracy is None else scene.study(accuracy=accuracy)
    stages = Stages(Cache(folder / f"design_{scene.design}" / "cache", print), silent)
    done = solved(study, stages, MEMORY)
    estimates = done.response.estimates
    kept = np.array([done.response.harmonics]) if estimates is None else estimates.harmonics
    found = asdict(
        outcome(scene, "", done.given, done.response, kept, rom=0.0, response=0.0, diameters=0)
    )
    if done.planned.choice is None:
        own = own_errors(done.planned, stages)
    else:
        mesh, (_, amplitude, frequency) = done.planned.choice.rounds[-1], stated(done.response)
        own = {
            "size": mesh.size,
            "dofs": mesh.dofs,
            "meshes": len(done.planned.choice.rounds),
            "mesh": mesh.amplitude,
            "amplitude_error": amplitude + mesh.amplitude,
            "frequency_error": frequency + mesh.error,
            "short": done.planned.choice.short,
        }
    seconds = sum(stages.cpu.get(key, 0.0) for key in stages.done)
    return {**found, **own, "seconds": seconds, "memory": memory("VmHWM") / 1000}


KINDS: dict[str, Callable[[Scene, Path], Known]] = {
    "truth": truth,
    "asked": partial(run, accuracy=ACCURACY),
    "default": partial(run, accuracy=None),
}


def found(kind: str, number: int, folder: Path, compute: bool) -> Known | None:
    """What a run of a kind found, from the folder or by a process of its own."""
    if kind == "truth" and str(number) in TRUTHS:
        known: Known = TRUTHS[str(number)]
        return known
    path = folder / f"{number:02d}_{kind}.json"
    if not path.exists() and compute:
        command = [sys.executable, "-m", "benchmarks.accuracy.open_mesh", "--data", str(folder)]
        command += ["--child", kind, str(number)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"{kind} {number}: {done.stderr.strip().splitlines()[-1:]}", flush=True)
        else:
            path.write_text(done.stdout.splitlines()[-1], "utf-8")
    return json.loads(path.read_text("utf-8")) if path.exists() else None


def table(numbers: list[int], folder: Path, compute: bool) -> list[str]:
    """What the scenes come to, and a row of each."""
    rows, figures, defaults, missing = [], [], [], []
    for number in numbers:
        runs = [found(kind, number, folder, compute) for kind in KINDS]
        if any(run is None for run in runs):
            missing.append(f"{number} ({draw(number).kind or 'nothing special'})")
            continue
        known, asked, other = (run for run in runs if run is not None)
        off, usual = [errors(SimpleNamespace(**each), known) for each in (asked, other)]
        own, meant = [(each["amplitude_error"], each["frequency_error"]) for each in (asked, other)]
        ratio = asked["seconds"] / other["seconds"]
        figures.append((max(off), max(own), asked["dofs"], asked["memory"], ratio))
        defaults.append((max(usual), max(meant)))
        percents = (known["frequency_error"], *off, *own, *usual, *meant)
        rows.append(
            f"| {number} | {draw(number).kind} "
            f"| {1e6 * known['amplitude']:.2f} | {known['frequency']:.2f} | "
            + " | ".join(f"{100 * each:.2f}" for each in percents)
            + f" | {asked['size']} | {asked['dofs']:,} | {asked['meshes']} "
            f"| {asked['memory']:.1f} | {asked['seconds']:.0f} | {ratio:.1f} |"
        )
        print(rows[-1], flush=True)
    worst, told, dofs, held, ratios = np.array(figures).T
    off, meant = np.array(defaults).T
    return [
        "| scenes | both errors below 1 % | median | worst | stated below true | dofs, mean "
        "| memory GB, largest | processor time over the default's, median | largest |",
        "|---:|" + "---:|" * 8,
        f"| {len(rows)} | {np.sum(worst <= ACCURACY)} | {100 * np.median(worst):.2f} % "
        f"| {100 * worst.max():.2f} % | {np.sum(told < worst)} | {dofs.mean():,.0f} "
        f"| {held.max():.1f} | {np.median(ratios):.1f} | {ratios.max():.1f} |",
        "",
        "The same scenes without an accuracy, on the default mesh and with three harmonics, which "
        "add errors of their own, and what their pages state:",
        "",
        "| scenes | both errors below 1 % | median | worst | stated, median | stated below true |",
        "|---:|" + "---:|" * 5,
        f"| {len(rows)} | {np.sum(off <= ACCURACY)} | {100 * np.median(off):.2f} % "
        f"| {100 * off.max():.2f} % | {100 * np.median(meant):.2f} % | {np.sum(meant < off)} |",
        "",
        *([f"Not run: {', '.join(missing)}.", ""] if missing else []),
        "## Scenes",
        "",
        "Uncertainty of the truth's frequency, errors and stated errors in %.",
        "",
        "| scene | what is special | peak µm | at Hz | uncertain by | error | of frequency "
        "| stated | of frequency | default: error | of frequency | stated | of frequency | size "
        "| dofs | meshes | memory GB | time s | over default |",
        "|---:|---|" + "---:|" * 17,
        *rows,
    ]


def main() -> None:
    """Compute what is missing and print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder that keeps what was computed")
    parser.add_argument("--scenes", type=int, nargs="+", default=list(CHOSEN))
    parser.add_argument("--only", choices=KINDS, nargs="+", help="compute these and stop")
    parser.add_argument("--kept", action="store_true", help="compute nothing")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    folder = given.data or Path(tempfile.gettempdir()) / "vanelock_open_mesh"
    folder.mkdir(parents=True, exist_ok=True)
    if given.child:
        kind, number = given.child
        print(json.dumps(KINDS[kind](opened(int(number)), folder)))
        return
    if given.only:
        for number in given.scenes:
            for kind in given.only:
                print(kind, number, found(kind, number, folder, True) is not None, flush=True)
        return
    lines = table(given.scenes, folder, not given.kept)
    print("\n".join(lines))
    lines = [INTRODUCTION, *lines]
    page("accuracy_open_mesh", "An accuracy with the mesh left open", lines, given.write)


if __name__ == "__main__":
    main()
