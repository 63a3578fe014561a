"""Peaks asked for to an accuracy, in many drawn scenes, against over-resolved references.

    python -m benchmarks.accuracy.peaks [--data FOLDER] [--scenes 0 1 2] [--write]

computes references, runs with fixed settings and runs by accuracy, keeps each in the folder (a run
that is broken off goes on where it was), and prints the tables; `--write` puts them and two
pictures into docs/benchmarks/accuracy.md. All 65 scenes take some hours. With `--only`, it computes
only some of the three and prints no tables; with `--kept`, tables are of what the folder holds.
"""

import argparse
import json
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.accuracy.asked import asked
from benchmarks.accuracy.models import Models, prepared
from benchmarks.accuracy.pictures import costs, errors
from benchmarks.accuracy.references import ACCURACY, BESIDE, reference
from benchmarks.accuracy.runs import Outcome, Setting, fixed
from benchmarks.accuracy.scenes import COUNT, Scene, draw
from benchmarks.accuracy.tables import (
    TARGETS,
    Compared,
    Known,
    asked_table,
    beyond_table,
    compared,
    estimate_table,
    fixed_table,
    ratio_table,
    scene_table,
    size_table,
)
from benchmarks.accuracy.words import ASKED, BEYOND, ESTIMATES, FIXED, INTRODUCTION, SCENES, SIZES
from benchmarks.pages import FOLDER, page

DEFAULT = Setting(1e-4, 3)
"""What a study takes unless given; its mean time is the unit."""
GIVEN = {
    DEFAULT: 3,
    Setting(1e-4, 9): 1,
    Setting(1e-4, 14): 1,
    Setting(1e-4, 9, 4): 7,
    Setting(1e-4, 14, 4): 7,
}
"""Fixed settings, and every how many scenes they are run, since some take long."""
SURE = 0.3
"""Of an accuracy, how large the doubt of a reference may be to judge by it."""
REFERENCES = json.loads((Path(__file__).parent / "references.json").read_text())
"""What earlier runs found, which took hours: delete one to have it computed again."""
KINDS = ("references", "fixed", "asked")


@dataclass(frozen=True)
class Folder:
    """What is kept of the scenes, and computes what is missing unless asked not to.

    Attributes
    ----------
    path : Path
    only_kept : bool
    """

    path: Path
    only_kept: bool = False

    def known(self, scene: Scene) -> Known | None:
        """The reference of a scene."""
        path = self.path / "references" / f"{scene.number:02d}.json"
        if not path.exists():
            if str(scene.number) in REFERENCES:
                earlier: Known = REFERENCES[str(scene.number)]
                return earlier
            if self.only_kept:
                return None
            models = Models(scene, self.path)
            found = reference(scene, prepared(scene, models.reduced(ACCURACY)))
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(found))
        read: Known = json.loads(path.read_text())
        return read

    def with_setting(self, scene: Scene, setting: Setting) -> Outcome | None:
        """A run with a fixed setting."""
        models = Models(scene, self.path)
        return self._run(scene, setting.name, lambda: fixed(scene, models, setting))

    def by_accuracy(self, scene: Scene, accuracy: float) -> Outcome | None:
        """A run by accuracy."""
        return self._run(scene, f"asked_{accuracy:g}", lambda: asked(scene, accuracy, self.path))

    def _run(self, scene: Scene, name: str, run: Callable[[], Outcome]) -> Outcome | None:
        path = self.path / "runs" / f"{scene.number:02d}_{name}.json"
        if path.exists():
            return Outcome(**json.loads(path.read_text()))
        if self.only_kept:
            return None
        found = run()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(asdict(found)))
        return found


def computed(folder: Folder, scenes: list[Scene], kinds: Iterable[str]) -> None:
    """Put all that is wanted into the folder, telling of each."""
    for kind in kinds:
        for scene in scenes:
            if kind == "references":
                print(f"scene {scene.number}: {folder.known(scene)}", flush=True)
            elif kind == "fixed":
                for setting, step in GIVEN.items():
                    if scene.number % step == 0:
                        print(f"{folder.with_setting(scene, setting)}", flush=True)
            else:
                for accuracy in TARGETS:
                    print(f"{folder.by_accuracy(scene, accuracy)}", flush=True)


def missing(found: dict[float, Compared], references: dict[int, Known]) -> str:
    """What has not been computed, or has no reference that is sure, in words."""
    without = sorted(set(range(COUNT)) - set(references))
    lacking = [f"references of {_listed(without)}"] if without else []
    for accuracy, each in found.items():
        if left := sorted(set(references) - {run.number for run in each.runs}):
            lacking.append(f"at {accuracy:g}, {_listed(left)}")
    return f"Not computed or not sure: {'; '.join(lacking)}." if lacking else ""


def _listed(numbers: list[int]) -> str:
    return ", ".join(str(number) for number in numbers)


def elsewhere(references: dict[int, Known]) -> str:
    """Scenes in which a downward sweep, or disturbed starts, find a higher peak, in words."""
    found = [
        f"by {100 * (known['down']['amplitude'] / known['amplitude'] - 1):.0f} % in scene {number}"
        + (" (a branch that no sweep meets, from disturbed starts)" if number in BESIDE else "")
        for number, known in references.items()
        if known["down"] and known["down"]["amplitude"] > known["amplitude"]
    ]
    return "sweeping down, " + ", ".join(found) if found else "in none of these scenes"


def every(step: int, scenes: Iterable[Scene]) -> list[Scene]:
    """Those whose number is a multiple of `step`."""
    return [scene for scene in scenes if scene.number % step == 0]


def report(folder: Folder, scenes: list[Scene], docs: Path | None) -> list[str]:
    """All tables; pictures into `docs` if that is given."""
    told = {scene.number: folder.known(scene) for scene in scenes}
    references = {number: known for number, known in told.items() if known is not None}
    scenes = [scene for scene in scenes if scene.number in references]
    dofs = {scene.number: Models(scene, folder.path).dofs for scene in scenes}

    def of(
        name: str,
        run: Callable[[Scene], Outcome | None],
        chosen: Iterable[Scene],
        doubt: float = np.inf,
    ) -> Compared:
        sure = {number: known for number, known in references.items() if known["doubt"] < doubt}
        runs = [run(scene) for scene in chosen if scene.number in sure]
        return compared(name, [found for found in runs if found is not None], sure)

    found = {
        accuracy: of(
            f"{accuracy:g}",
            partial(folder.by_accuracy, accuracy=accuracy),
            scenes,
            SURE * accuracy,
        )
        for accuracy in TARGETS
    }
    others = {
        setting: of(
            setting.name, partial(folder.with_setting, setting=setting), every(step, scenes)
        )
        for setting, step in GIVEN.items()
    }
    found = {accuracy: each for accuracy, each in found.items() if each.runs}
    others = {setting: each for setting, each in others.items() if each.runs}
    unit = others[DEFAULT].cost
    doubt = max(each["doubt"] for each in references.values())
    if docs:
        errors(found, docs / "accuracy_errors.png")
        costs(found, others, unit, docs / "accuracy_costs.png")
    sections = [
        ("Achieved", ASKED, asked_table(found)),
        ("What it took", SIZES, size_table(found, dofs, unit)),
        ("Against fixed settings", FIXED, fixed_table(others, unit)),
        ("", "", ratio_table(found, others)),
        ("Stated errors", ESTIMATES, estimate_table(found)),
        ("Beyond what was asked", BEYOND, beyond_table(found)),
        ("Scenes", SCENES, scene_table(references, found)),
    ]
    words_of = {
        "doubt": doubt,
        "unit": unit,
        "sure": SURE,
        "higher": elsewhere(references),
        "missing": missing(found, references),
    }
    lines = [INTRODUCTION.format(**words_of)]
    for title, words, table in sections:
        lines += [*([f"## {title}", ""] if title else []), *([words, ""] if words else [])]
        lines += [*table, ""]
    return lines[:-1]


def main() -> None:
    """Compute what is wanted and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder that keeps what was computed")
    parser.add_argument("--scenes", type=int, nargs="+", default=list(range(COUNT)))
    parser.add_argument("--only", choices=KINDS, nargs="+", help="compute these and stop")
    parser.add_argument("--kept", action="store_true", help="compute nothing")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    path = options.data or Path(tempfile.gettempdir()) / "vanelock_accuracy_scenes"
    folder = Folder(path, options.kept)
    scenes = [draw(number) for number in options.scenes]
    with threadpool_limits(1):
        if not options.kept:
            computed(folder, scenes, options.only or KINDS)
        if options.only:
            return
        lines = report(folder, scenes, FOLDER if options.write else None)
    print("\n".join(lines))
    page("accuracy", "Accuracy asked for and achieved", lines, options.write)


if __name__ == "__main__":
    main()
