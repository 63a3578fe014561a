"""Only what a scene needs: what a response does without, and the evidence that it may."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vanelock import nonlinear
from vanelock.common.arrays import Floats
from vanelock.common.tables import Column, Table, heads
from vanelock.nonlinear import Response


@dataclass(frozen=True)
class LeftOut:
    """Something that a case does without, or was asked to and keeps, and the evidence."""

    kind: str
    what: str
    evidence: str


def left_out(
    response: Response,
    joints: Sequence[str],
    diameters: tuple[Sequence[int], Sequence[int]],
    energy: dict[str, float],
    outputs: tuple[int, str],
    above: dict[str, float],
    modes_error: float,
) -> list[LeftOut]:
    """What a response does without."""
    used, never = diameters
    found = [*_joints(response, joints)]
    assert response.estimates is not None
    H, needed = response.harmonics, response.estimates.harmonics
    harmonics = response.estimates.sources.index("harmonics")
    worst = float(np.nanmax(response.estimates.error[:, harmonics], initial=0.0))
    top = int(np.nanargmax(np.where(response.converged, response.estimates.amplitude, -np.inf)))
    at_peak = float(response.estimates.error[top, harmonics])
    found.append(
        LeftOut(
            "harmonics",
            f"above {H}; above {needed[top]} at the peak",
            f"estimated {at_peak:.0e} of the amplitude at the peak, {worst:.0e} at worst; "
            f"{int((needed < H).sum())} of {response.points} points took fewer than {H}",
        )
    )
    if never:
        found.append(
            LeftOut(
                "nodal diameters",
                _listed_harmonics(never),
                f"never reduced: harmonics 0 to {response.estimates.tried}, kept or tried, have "
                f"nodal diameters {_listed_harmonics(used)}",
            )
        )
    for part, hertz in above.items():
        if np.isfinite(hertz):
            found.append(
                LeftOut(
                    "modes",
                    f"{part}: fixed-interface modes above {hertz:.0f} Hz, but their static part",
                    f"estimated {modes_error:.0e} of the peak, both parts together",
                )
            )
    for name, share in energy.items():
        evidence = f"holds {100 * share:.2g} % of the strain energy of the mode of interest"
        found.append(LeftOut("parts", f"{name}: kept", evidence))
    count, watched = outputs
    if count > 1:
        what = f"{count - 1} of {count} output nodes"
        found.append(LeftOut("outputs", what, f"nothing was refined for them, only for {watched}"))
    return found


def _joints(response: Response, joints: Sequence[str]) -> list[LeftOut]:
    """Contacts that stick at all points: they bring no unknowns."""
    stuck = np.all(response.state[response.converged] == nonlinear.STUCK, axis=0)
    used = utilisation(response)[response.converged].max(axis=0, initial=0.0)
    found = []
    for joint in dict.fromkeys(joints):
        own = np.array([each == joint for each in joints])
        count, sticking = int(own.sum()), int((own & stuck).sum())
        if sticking == 0:
            continue
        largest = float(used[own & stuck].max())
        whole = sticking == count
        found.append(
            LeftOut(
                "joints" if whole else "contacts",
                f"{joint}: friction of {'all ' if whole else ''}{sticking}"
                + (" pairs" if whole else f" of {count} pairs"),
                f"stuck at every point, largest |t| / (mu n) {largest:.3g}: no unknowns",
            )
        )
    return found


def utilisation(response: Response, samples: int = 64) -> Floats:
    """(p, c) largest friction force over its bound in a period; 0 where there is no friction."""
    H = response.harmonics
    angle = 2 * np.pi * np.arange(samples) / samples
    waves = np.exp(1j * np.outer(np.arange(H + 1), angle))
    history = np.einsum("phcd,hs->pscd", response.force, waves).real
    bound = response.mu * np.maximum(history[..., 0], 0.0)
    friction = np.abs(history[..., 1:])
    t = (
        np.hypot(*np.moveaxis(friction, -1, 0))
        if response.friction == "isotropic"
        else friction.max(-1)
    )
    ratio = np.divide(t, bound, out=np.zeros_like(t), where=bound > 1e-9 * bound.max(initial=0.0))
    return np.asarray(ratio.max(axis=1))


def left_out_table(case: str, found: Sequence[LeftOut]) -> Table:
    """What a case does without, and why that is right."""
    columns = (Column("left out", key="kind"), *heads("what", "evidence"))
    rows = [(each.kind, each.what, each.evidence) for each in found]
    title = "Left out, or kept, and why" + ("" if case == "nominal" else f", {case}")
    return Table(title, columns, rows, key="left_out")


def _listed_harmonics(numbers: Sequence[int]) -> str:
    """Whole numbers in words: "0, 1, 4 to 8"."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [", ".join(map(str, run)) if len(run) < 3 else f"{run[0]} to {run[-1]}" for run in runs]
    return ", ".join(texts)
