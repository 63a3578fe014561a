"""Runs of the scenes, with settings given or by accuracy: what each cost and found."""

import time
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.models import Models, Prepared, prepared
from benchmarks.accuracy.scenes import Scene
from vanelock.input.cases.values import diameter_of
from vanelock.nonlinear import Options, Response, frequency_response

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Setting:
    """A fixed setting.

    Attributes
    ----------
    accuracy : float
        Of the reduced model, `rom.accuracy`.
    harmonics : int
        `response.harmonics`.
    parts : int
        Of the range, each of them swept upwards and downwards as a range of its own; 0: all of it
        upwards, as a study does by default.
    """

    accuracy: float
    harmonics: int
    parts: int = 0

    @property
    def name(self) -> str:
        """Short, for files."""
        parts = f"_{self.parts}" if self.parts else ""
        return f"{self.accuracy:.0e}_{self.harmonics}{parts}"

    @property
    def words(self) -> str:
        """For tables."""
        parts = f", {self.parts} parts up and down" if self.parts else ""
        return f"rom.accuracy {self.accuracy:g}, {self.harmonics} harmonics{parts}"


@dataclass(frozen=True)
class Outcome:
    """What a run found and cost.

    Attributes
    ----------
    number : int
        The scene.
    name : str
        The setting, or the accuracy asked for.
    amplitude, frequency : float
        The peak: m, Hz; nan where there is none.
    amplitude_estimate, frequency_estimate : float
        Relative errors of both that the run itself states; nan where it does not.
    rom, response : float
        CPU seconds of reducing both parts, and of the response.
    size : int
        Coordinates of the reduced model.
    diameters : int
        Nodal diameters reduced.
    harmonics : int
        The most at any point.
    mean_harmonics : float
    points, lost : int
        Frequencies, and those not converged.
    sources : dict of str to float
        Estimated relative error of the peak amplitude by source; empty for fixed settings.
    """

    number: int
    name: str
    amplitude: float
    frequency: float
    amplitude_estimate: float
    frequency_estimate: float
    rom: float
    response: float
    size: int
    diameters: int
    harmonics: int
    mean_harmonics: float
    points: int
    lost: int
    sources: dict[str, float]

    @property
    def cost(self) -> float:
        """CPU seconds of all that the settings decide."""
        return self.rom + self.response


def fixed(scene: Scene, models: Models, setting: Setting) -> Outcome:
    """Run a scene with a fixed setting, else as a study does by default."""
    reduction = models.reduced(setting.accuracy)
    given = prepared(scene, reduction)
    study = scene.study()
    begin = time.process_time()
    found = [
        frequency_response(
            given.system,
            ends,
            Options(
                setting.harmonics,
                coupling=study.response.coupling,
                friction=study.response.friction,
                direction=direction,
            ),
        )
        for ends in pairwise(np.linspace(*given.range, max(setting.parts, 1) + 1).tolist())
        for direction in (("up", "down") if setting.parts else ("up",))
    ]
    seconds = time.process_time() - begin
    count = len(diameters(scene, setting.harmonics))
    cost = {"rom": reduction.cost(count), "response": seconds, "diameters": count}
    runs = [
        outcome(scene, setting.name, given, each, np.full(each.points, setting.harmonics), **cost)
        for each in found
    ]
    best = max(runs, key=lambda run: np.nan_to_num(run.amplitude))
    points, lost = (sum(getattr(run, name) for run in runs) for name in ("points", "lost"))
    return replace(best, points=points, lost=lost)


def outcome(
    scene: Scene, name: str, given: Prepared, solved: Response, kept: Floats, **other: Any
) -> Outcome:
    """Put together what a response says of its peak."""
    amplitude = given.monitor.amplitude(solved)
    known = np.where(np.isfinite(amplitude), amplitude, -np.inf)
    top = int(known.argmax())
    found = np.isfinite(known[top])
    size = len(given.system.at(given.system.nodal_diameter(1)).K)
    told: dict[str, Any] = {
        "amplitude_estimate": float("nan"),
        "frequency_estimate": float("nan"),
        "sources": {},
    }
    return Outcome(
        number=scene.number,
        name=name,
        amplitude=float(known[top]) if found else float("nan"),
        frequency=float(solved.frequency[top]) if found else float("nan"),
        size=size,
        harmonics=int(kept.max()),
        mean_harmonics=float(kept.mean()),
        points=solved.points,
        lost=int(np.sum(~solved.converged)),
        **{**told, **other},
    )


def diameters(scene: Scene, harmonics: int) -> set[int]:
    """Nodal diameters of the harmonics 0 to H, k and N - k once."""
    study = scene.study()
    return {diameter_of(study, h) for h in range(harmonics + 1)}
