"""What an accuracy settles before the response: contacts on areas, reduction, element size.

The mesh is refined from the coarsest on, until its estimated error is within its share. Errors fall
about as the element size does (docs/benchmarks/mesh_study.md: sharp re-entrant edges), so the next
size follows from the last ones, and is estimated in turn.
"""

import math
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from vanelock.common.errors import InputError
from vanelock.input.cases.values import with_values
from vanelock.input.schema.structure.own_mesh import OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.mesh.geometry.element_size import SIZES, SMALLEST, element_size
from vanelock.pipeline.step import Stages
from vanelock.stages.accuracy.amplitude_errors import amplitude_error, amplitude_errors_step
from vanelock.stages.accuracy.budget import Budget, budget, pins
from vanelock.stages.accuracy.mesh_errors import mesh_errors_step
from vanelock.stages.accuracy.mesh_sizes import DOFS, most_dofs, unknowns
from vanelock.stages.parts.components import (
    PARTS,
    casing_step,
    diameter_of,
    model_step,
    reference_step,
)
from vanelock.stages.parts.meshes import mesh_step
from vanelock.stages.parts.nodal_diameters import linear_steps
from vanelock.stages.parts.systems import united_step
from vanelock.stages.response.limits import Limits

ORDER = 0.93
"""Order at which errors fall with the element size, from the coarse mesh on: that of the example
from 30 to 7.6 mm. Two meshes give their own."""
BETWEEN = (0.5, 1.1)
"""Orders that are believed of two meshes."""
AIM = 0.9
"""Of its share, the error that the next mesh is to have."""
ROUNDS = 6
LEAP, CLOSE = 0.4, 0.9
"""Smallest and largest size of the next mesh over the last one's: orders do not hold further on,
and a closer one is not worth it."""
COARSE = "the mesh is too coarse"
"""What a reduction says of patches that its mesh cannot tell apart."""
ROUGHEST = 1e-2
"""Largest `rom.accuracy` chosen: rougher reductions cost as much."""


@dataclass(frozen=True)
class Round:
    """A mesh that was tried: its size in words, dofs of both parts, and estimated errors.

    Of the frequency of the mode of interest, and of the amplitude of the peak.
    """

    size: str
    dofs: int
    error: float
    amplitude: float

    @property
    def largest(self) -> float:
        """The larger of both errors."""
        return max(self.error, self.amplitude)


@dataclass(frozen=True)
class MeshChoice:
    """A case with its accuracy's choices made, as far as they precede the response.

    Attributes
    ----------
    study : Study
        The study with them.
    given : Study
        The study as it was.
    budget : Budget
        What each source may contribute.
    rounds : tuple of Round
        Meshes tried; the last one is used.
    short : str
        Why the mesh is not as fine as its share asks for, "" where it is.
    """

    study: Study
    given: Study
    budget: Budget
    rounds: tuple[Round, ...]
    short: str


def choose_mesh(study: Study, stages: Stages, most: float | None = None) -> MeshChoice:
    """Make the choices of a case with an accuracy."""
    if isinstance(study.vane, OwnVane):
        refuse_without_areas(study, stages.get(mesh_step(study, "vane")))
    chosen = study
    shares = budget(study)
    modes = shares.shares.get("modes")
    if modes is not None:
        chosen = with_values(chosen, {"rom.accuracy": min(modes, ROUGHEST)})
    if "mesh" in shares.pinned:
        tried, limits = _tried(chosen, stages)
        rounds, short = [tried], ""
    else:
        chosen, rounds, short, limits = _meshed(
            chosen, shares, stages, most_dofs() if most is None else most
        )
    if modes is None:  # what the study pins takes its own error off
        own = (limits.free_error[limits.free_mode], limits.stuck_error[limits.stuck_mode])
        shares = budget(study, max(float(each) for each in own))
    if "mesh" in shares.shares and not short:
        shares = shares.meshed(min(rounds[-1].largest, shares.bearable))
    stages.drop(model(chosen, "vane").key for model in (model_step, reference_step))
    return MeshChoice(chosen, study, shares, tuple(rounds), short)


def _meshed(
    study: Study, shares: Budget, stages: Stages, most: float
) -> tuple[Study, list[Round], str, Limits]:
    """The coarsest mesh whose estimated error can be borne, from the coarse one on."""
    share, size, finest = shares.shares["mesh"], _coarsest(study), _finest(study, most)
    rounds: list[Round] = []
    lengths: list[float] = []
    while True:
        chosen = with_values(study, {"mesh.size": size})
        length = element_size(size, "vane")
        try:
            tried, limits = _tried(chosen, stages)
        except InputError as refused:
            if COARSE not in str(refused) or length <= finest:
                raise
            size = float(f"{max(length / 2**0.5, finest):.3g}")
            continue
        rounds.append(tried)
        if tried.largest <= shares.bearable:
            return chosen, rounds, "", limits
        lengths.append(length)
        order = _order(lengths, [each.largest for each in rounds])
        factor = (AIM * share / tried.largest) ** (1 / order)
        smaller = length * min(max(factor, LEAP), CLOSE)
        size = float(f"{max(smaller, finest):.3g}")
        if size >= length or len(rounds) == ROUNDS:
            return chosen, rounds, _short(tried, share, most), limits
        stages.keep(())  # the factors of this mesh


def _order(lengths: list[float], errors: list[float]) -> float:
    """Order at which errors fall, by the last two meshes if there are two."""
    if len(lengths) < 2:
        return ORDER
    seen = math.log(errors[-2] / errors[-1]) / math.log(lengths[-2] / lengths[-1])
    return min(max(seen, BETWEEN[0]), BETWEEN[1])


def _short(last: Round, share: float, most: float) -> str:
    chosen = "are chosen" if most >= DOFS else "fit the memory"
    return (
        f"mesh: estimated error {last.largest:.1e} at {last.size} ({last.dofs:,} degrees of "
        f"freedom; none larger than {most:,.0f} {chosen}), {share:.1e} was its share"
    )


def _coarsest(study: Study) -> Any:
    """The coarse mesh, or the largest elements that hold fillets and bosses."""
    size: Any = "coarse"
    while True:
        try:
            with_values(study, {"mesh.size": size})
        except ValidationError as error:
            smaller = element_size(size, "vane") / 2**0.5
            if smaller < SMALLEST:
                raise InputError(str(error.errors()[0]["msg"])) from None
            size = float(f"{smaller:.3g}")
        else:
            return size


def _finest(study: Study, most: float) -> float:
    """Smallest elements that keep both meshes within so many degrees of freedom, m."""
    size = SIZES["coarse"]["vane"]
    while size > SMALLEST and unknowns(study, smaller := size * 0.97) <= most:
        size = smaller
    return size


def _tried(study: Study, stages: Stages) -> tuple[Round, Limits]:
    """A study's mesh with its estimated errors, and the modes by it."""
    steps = linear_steps(study)
    casings = [casing_step(study, k) for k in sorted({0, diameter_of(study, 1)})]
    own = amplitude_errors_step(study, united_step(study, 1), steps.limits, steps.vane, casings)
    errors, limits = stages.get(mesh_errors_step(study, steps.limits)), stages.get(steps.limits)
    size = study.mesh.size
    shown = size if isinstance(size, str) else f"{1e3 * size:.3g} mm"
    if "mesh" in pins(study) and pins(study)["mesh"].endswith(".mesh"):
        shown = "as given"
    dofs = sum(3 * len(stages.get(mesh_step(study, part)).points) for part in PARTS)
    amplitude = amplitude_error(stages.get(own), errors.interest)
    return Round(shown, dofs, errors.interest, amplitude), limits
