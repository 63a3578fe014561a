"""Six runs, of the smallest study and of scenes, which tests of tables, pages and files read.

    accuracy      a study to an accuracy, with a strain gauge
    default       a case with all pictures
    sweep         four cases, both directions of the sweep
    lap_joint     a scene of two blocks, with scatter
    shrouded_ring a scene of a sector, its bounds and stability
    everything    a study with every analysis of a case

By the program's public names alone, so that what earlier states of it found is compared, too.
"""

import fcntl
import pickle
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from tests.small_study import SMALL
from vanelock import load_scene, parse_study, run_study

T = TypeVar("T")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
FREQUENCIES = "[250, 254, 256, 258, 259, 260, 264, 268, 272]"

STUDIES = {
    "accuracy": """
name = "accuracy"
accuracy = 0.06
excitation.force = 8
[outputs]
show = ["loops", "report"]
gauges = [{ aerofoil = 2, span = 0.1, chord = 0.5 }]
""",
    "default": f"""
name = "default"
excitation.force = 15
[response]
frequencies = {FREQUENCIES}
""",
    "sweep": f"""
name = "sweep"
[response]
frequencies = {FREQUENCIES}
harmonics = 1
direction = "both"
[sweep]
"joints.interlock.mu" = [0.15, 0.3]
"excitation.force" = [10, 20]
[outputs]
show = ["loops", "report"]
""",
    "everything": """
name = "everything"
joints.interlock.wear_coefficient = 1e-13
excitation.force = 15
[ring]
sectors = 8
[material.vane]
expansion = 1.3e-5
[material.casing]
expansion = 1.3e-5
[temperature]
vane = 605
casing = 600
[loads]
axial = "20 N"
tangential = "-15 N"
[response]
harmonics = 1
range = [260, 275]
points = 16
[outputs]
show = ["loops", "report"]
[bounds]
share = 0
starts = 0
[stability]
[mistuning]
rings = 2
range = [263, 272]
keys.joints.interlock.mu = 0.05
[damped_modes]
nodal_diameters = [1, -1]
influence = [[0, 0, -2e3], [1, -4e4, 0], [-1, 4e4, 0]]
[wear]
dwells = [{ cycles = 2e6 }, { cycles = 1e6, load = 1.2 }]
[campbell]
speeds = [0, 20000]
engine_orders = [1, 2]
modes = 3
""",
}
SCENES = {
    "lap_joint": {
        '"contacts.lap.mu" = [0.01, 0.03, 0.1, 0.3, 1.0]': "",
        "[sweep]": """[outputs]
show = ["report"]  # of contacts alike, one or the other
[scatter]
samples = 6
[scatter.keys]
"contacts.lap.mu" = { uniform = [0.1, 0.5] }""",
    },
    "shrouded_ring": {
        '["0.05 um", "0.25 um", "1 um", "4 um", "16 um"]': '["1 um", "4 um"]',
        "harmonics = 7": """harmonics = 3
[bounds]
starts = 0
[stability]""",
    },
}
"""Of each example the texts that are replaced, and by what."""
NAMES = (*STUDIES, *SCENES)


@dataclass(frozen=True)
class GoldenRun:
    """A run that is there: its folder, what was run, and all that it said."""

    folder: Path
    text: str
    summaries: tuple[Any, ...]
    events: list[Any]

    def table(self, key: str) -> Any:
        """The first table of that name."""
        return next(event for event in self.events if getattr(event, "key", None) == key)

    def rows(self, key: str) -> list[dict[str, Any]]:
        """Rows of the first table of that name, by its columns' keys, in the units shown."""
        found: list[dict[str, Any]] = self.table(key).record()["rows"]
        return found


def made_once(place: Path, make: Callable[[], T]) -> T:
    """What `make` gives, made by the first process that asks for it and kept in that file."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with open(place.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not place.exists():
            place.write_bytes(pickle.dumps(make()))
    found: T = pickle.loads(place.read_bytes())
    return found


def golden_run(name: str, place: Path) -> GoldenRun:
    """The run of that name in a folder."""
    return made_once(place / f"{name}.pickle", lambda: _made(name, place))


def _made(name: str, place: Path) -> GoldenRun:
    events: list[Any] = []
    folder = place / name
    if name in STUDIES:
        text = SMALL + STUDIES[name]
        given: Any = parse_study(text)
    else:
        scene = place / f"{name}_scene"
        shutil.copytree(EXAMPLES / name, scene, dirs_exist_ok=True)
        text = (scene / "scene.toml").read_text()
        for old, new in SCENES[name].items():
            assert old in text
            text = text.replace(old, new)
        (scene / "scene.toml").write_text(text)
        given = load_scene(scene / "scene.toml")
    summaries = run_study(given, folder, events.append, text)
    return GoldenRun(folder, text, summaries, events)
