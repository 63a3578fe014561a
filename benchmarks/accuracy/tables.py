"""Tables of the scenes' errors and costs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.runs import Outcome, Setting
from benchmarks.accuracy.scenes import draw

Floats = NDArray[np.float64]
Known = dict[str, Any]
"""A reference as it is kept."""

TARGETS = (3e-2, 1e-2, 1e-3)
WASTE = 30
"""Factor below the asked accuracy beyond which an error was not worth what it cost."""
SHARE = 0.95
"""Of the scenes, that shall be within an accuracy."""


@dataclass(frozen=True)
class Compared:
    """Runs of one setting or accuracy, scene by scene, with their true errors.

    Attributes
    ----------
    name : str
    runs : list of Outcome
    amplitude, frequency : (n,) float
        Relative errors of the peak; infinite where a run has none.
    """

    name: str
    runs: list[Outcome]
    amplitude: Floats
    frequency: Floats

    def of(self, other: "Compared") -> "Compared":
        """Those of the scenes that another one has too."""
        numbers = {run.number for run in other.runs}
        kept = [i for i, run in enumerate(self.runs) if run.number in numbers]
        runs = [self.runs[i] for i in kept]
        return Compared(self.name, runs, self.amplitude[kept], self.frequency[kept])

    @property
    def worst(self) -> Floats:
        """(n,) the larger of both errors."""
        return np.maximum(self.amplitude, self.frequency)

    def within(self, accuracy: float) -> float:
        """Share of the scenes with both errors below."""
        return float(np.mean(self.worst < accuracy))

    def reaches(self, share: float) -> float:
        """The error that this share of the scenes stays within."""
        ordered = np.sort(self.worst)
        return float(ordered[int(np.ceil(share * len(ordered))) - 1])

    def mean(self, of: Callable[[Outcome], float]) -> float:
        """Mean over the scenes."""
        return float(np.mean([of(run) for run in self.runs]))

    @property
    def cost(self) -> float:
        """Mean CPU seconds."""
        return self.mean(lambda run: run.cost)


def compared(name: str, runs: Sequence[Outcome], references: dict[int, Known]) -> Compared:
    """Errors of runs of the same kind against the references."""
    chosen = [run for run in runs if run.number in references]

    pairs = [errors(run, references[run.number]) for run in chosen]
    amplitude, frequency = np.array(pairs, float).reshape(-1, 2).T
    return Compared(name, chosen, amplitude, frequency)


def errors(run: Outcome, known: Known) -> tuple[float, float]:
    """Relative errors of the peak; of that of a second branch where that is higher and nearer."""
    found = []
    for branch in (known, known.get("down")):
        if branch and branch["amplitude"] >= known["amplitude"]:
            pair = [getattr(run, key) / branch[key] - 1 for key in ("amplitude", "frequency")]
            amplitude, frequency = np.nan_to_num(np.abs(pair), nan=np.inf).tolist()
            found.append((amplitude, frequency))
    return min(found, key=max)


def asked_table(asked: dict[float, Compared]) -> list[str]:
    """What asking for an accuracy gave."""
    lines = [
        "| accuracy | scenes | both errors below it | and not 30 times below | median | 95 % below "
        "| worst | worst of frequency |",
        "|---:|" + "---:|" * 7,
    ]
    for accuracy, found in asked.items():
        useful = np.mean((found.worst < accuracy) & (found.worst > accuracy / WASTE))
        lines.append(
            f"| {accuracy:g} | {len(found.runs)} | {100 * found.within(accuracy):.1f} % "
            f"| {100 * useful:.0f} % | {np.median(found.worst):.1e} | {found.reaches(SHARE):.1e} "
            f"| {found.worst.max():.1e} | {found.frequency.max():.1e} |"
        )
    return lines


def size_table(asked: dict[float, Compared], dofs: dict[int, int], unit: float) -> list[str]:
    """What it took; times in units."""
    lines = [
        "| accuracy | time | of it reduction | response | dofs | coordinates | nodal diameters "
        "| harmonics, mean of points | most, mean of scenes | most | points | lost |",
        "|---:|" + "---:|" * 11,
    ]
    for accuracy, found in asked.items():
        lines.append(
            f"| {accuracy:g} | {found.cost / unit:.2f} "
            f"| {found.mean(lambda run: run.rom) / unit:.2f} "
            f"| {found.mean(lambda run: run.response) / unit:.2f} "
            f"| {np.mean([dofs[run.number] for run in found.runs]):.0f} "
            f"| {found.mean(lambda run: run.size):.0f} "
            f"| {found.mean(lambda run: run.diameters):.1f} "
            f"| {found.mean(lambda run: run.mean_harmonics):.1f} "
            f"| {found.mean(lambda run: run.harmonics):.1f} "
            f"| {max(run.harmonics for run in found.runs)} "
            f"| {found.mean(lambda run: run.points):.0f} "
            f"| {sum(run.lost for run in found.runs)} |"
        )
    return lines


def estimate_table(asked: dict[float, Compared]) -> list[str]:
    """Stated errors over true ones."""
    lines = [
        "| accuracy | stated / true error of the peak's amplitude: median | 5 % below | 95 % below "
        "| stated below true |",
        "|---:|" + "---:|" * 4,
    ]
    for accuracy, found in asked.items():
        stated = np.array([run.amplitude_estimate for run in found.runs])
        known = np.isfinite(stated) & np.isfinite(found.amplitude) & (found.amplitude > 0)
        if not known.any():
            continue
        ratio = stated[known] / found.amplitude[known]
        low, middle, high = np.quantile(ratio, [0.05, 0.5, 0.95])
        lines.append(
            f"| {accuracy:g} | {middle:.1f} | {low:.2g} | {high:.1f} "
            f"| {100 * np.mean(ratio < 1):.0f} % |"
        )
    return lines


def fixed_table(fixed: dict[Setting, Compared], unit: float) -> list[str]:
    """What fixed settings cost and give."""
    lines = [
        "| setting | scenes | time | of it reduction | points | within 0.03 | 0.01 | 0.001 "
        "| 95 % below | worst |",
        "|---|" + "---:|" * 9,
    ]
    for setting, found in fixed.items():
        within = " | ".join(f"{100 * found.within(target):.1f} %" for target in TARGETS)
        lines.append(
            f"| {setting.words} | {len(found.runs)} "
            f"| {found.cost / unit:.2f} | {found.mean(lambda run: run.rom) / unit:.2f} "
            f"| {found.mean(lambda run: run.points):.0f} | {within} "
            f"| {found.reaches(SHARE):.1e} | {found.worst.max():.1e} |"
        )
    return lines


def cheapest(
    fixed: dict[Setting, Compared], accuracy: float, share: float
) -> tuple[Setting, Compared] | None:
    """The cheapest fixed setting that is within an accuracy in a share of the scenes."""
    safe = [(s, c) for s, c in fixed.items() if c.within(accuracy) >= share]
    return min(safe, key=lambda each: each[1].cost, default=None)


def ratio_table(asked: dict[float, Compared], fixed: dict[Setting, Compared]) -> list[str]:
    """Time by accuracy over that of the cheapest fixed setting that is safe, in the same scenes."""
    lines = [
        "| accuracy | safe in all scenes | time by accuracy over it | safe in 95 % "
        "| time by accuracy over it |",
        "|---:|---|---:|---|---:|",
    ]
    for accuracy, found in asked.items():
        cells = []
        for share in (1.0, SHARE):
            safe = cheapest(fixed, accuracy, share)
            setting, other = safe or min(fixed.items(), key=lambda each: each[1].reaches(share))
            words = setting.words if safe else f"none; nearest to it: {setting.words}"
            cells += [words, f"{found.of(other).cost / other.cost:.2f}"]
        lines.append(f"| {accuracy:g} | " + " | ".join(cells) + " |")
    return lines


def beyond_table(asked: dict[float, Compared]) -> list[str]:
    """The scenes where the true error exceeds what was asked for."""
    lines = [
        "| accuracy | scene | what is special | error of amplitude | stated | error of frequency "
        "| harmonics | points |",
        "|---:|---:|---|" + "---:|" * 5,
    ]
    for accuracy, found in asked.items():
        for run, amplitude, frequency in zip(
            found.runs, found.amplitude, found.frequency, strict=True
        ):
            if max(amplitude, frequency) >= accuracy:
                lines.append(
                    f"| {accuracy:g} | {run.number} | {draw(run.number).kind} | {amplitude:.1e} "
                    f"| {run.amplitude_estimate:.1e} | {frequency:.1e} | {run.harmonics} "
                    f"| {run.points} |"
                )
    return lines if len(lines) > 2 else ["None."]


def scene_table(references: dict[int, Known], asked: dict[float, Compared]) -> list[str]:
    """Every scene: what it is, its peak, and its errors."""
    lines = [
        "| scene | what is special | N | EO | force N | μ | interference μm | ζ % | peak μm "
        "| at Hz | slip, open | doubt | " + " | ".join(f"{a:g}" for a in asked) + " |",
        "|---:|---|" + "---:|" * (10 + len(asked)),
    ]
    for number, known in sorted(references.items()):
        scene = draw(number)
        joints, load = scene.values["joints"], scene.values["excitation"]
        joint = joints["interlock"] or joints["hook"]
        slips, opens = zip(*known["state"].values(), strict=True)
        errors = []
        for found in asked.values():
            own = [
                e for run, e in zip(found.runs, found.worst, strict=True) if run.number == number
            ]
            errors.append(f"{own[0]:.0e}" if own else "")
        lines.append(
            f"| {number} | {scene.kind} | {scene.values['ring']['sectors']} "
            f"| {load['engine_order']} | {load['force']:.1f} | {joint['mu']:.2f} "
            f"| {1e6 * joint['interference']:.1f} | {100 * scene.values['damping']['ratio']:.2f} "
            f"| {1e6 * known['amplitude']:.2f} | {known['frequency']:.2f} "
            f"| {max(slips):.1f}, {max(opens):.1f} | {known['doubt']:.0e} | "
            + " | ".join(errors)
            + " |"
        )
    return lines
