"""What an accuracy settles before the response: contacts on areas, reduction, element size.

The mesh is refined from the coarsest on, until its estimated error is within its share. Errors fall
about as the element size does (docs/benchmarks/mesh_study.md: sharp re-entrant edges), so the next
sizes follow from the last ones, and are estimated in turn. Each part is refined as far as least
work asks for: with errors e_p and dofs d_p of both, and sizes f_p times the last ones,

    minimise  sum w_p d_p f_p^-RISE   where   sum e_p f_p^q_p = aim:
    f_p^(q_p + RISE) ~ w_p d_p RISE / (q_p e_p).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.input.cases.values import with_values
from vanelock.input.schema.structure.own_mesh import OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.mesh.element_size import SMALLEST, element_size, words_of
from vanelock.pipeline.step import Stages
from vanelock.stages.accuracy.budget import Budget, budget, pins
from vanelock.stages.accuracy.mesh_errors import (
    amplitude_error,
    amplitude_errors_step,
    mesh_errors_step,
)
from vanelock.stages.accuracy.mesh_sizes import DOFS, most_dofs, unknowns
from vanelock.stages.parts.components import PARTS, mesh_step, model_step
from vanelock.stages.parts.segment import StudyStructure
from vanelock.stages.response.limits import Limits
from vanelock.stages.structure import linear_of

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
RISE, WORK = 2.2, np.array([1.0, 4.0])
"""Power of 1/size with which dofs rise where walls are a few elements thick, and work a dof of each
part, mesh to stress: a casing is reduced at each nodal diameter (docs/benchmarks/memory.md)."""
TINY = 1e-12
TOO_COARSE = "the mesh is too coarse"
"""What a reduction says of patches that its mesh cannot tell apart."""
ROUGHEST = 1e-2
"""Largest `rom.accuracy` chosen: rougher reductions cost as much."""


@dataclass(frozen=True)
class Round:
    """A mesh that was tried: its size in words, dofs of each part, and estimated errors.

    Of the frequency of the mode of interest, and of the amplitude of the peak; and the vane's share
    of the larger one.
    """

    size: str
    parts: tuple[int, int]
    error: float
    amplitude: float
    vane_share: float = 0.5

    @property
    def dofs(self) -> int:
        """Of both parts."""
        return sum(self.parts)

    @property
    def largest(self) -> float:
        """The larger of both errors."""
        return max(self.error, self.amplitude)

    @property
    def errors(self) -> Floats:
        """(2,) of the larger error, by the vane and by the casing."""
        return self.largest * np.array([self.vane_share, 1 - self.vane_share])


@dataclass(frozen=True)
class MeshChoice:
    """A study with all choices made that its accuracy asks for before the response is solved."""

    study: Study
    """The study with them."""
    budget: Budget
    """What each source may contribute."""
    rounds: tuple[Round, ...]
    """Meshes tried; the last one is used."""
    short: str
    """Why the mesh is not as fine as its share asks for, "" where it is."""


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
    stages.drop(model_step(chosen, "vane", each).key for each in (False, True))
    return MeshChoice(chosen, shares, tuple(rounds), short)


def _meshed(
    study: Study, shares: Budget, stages: Stages, most: float
) -> tuple[Study, list[Round], str, Limits]:
    """The coarsest mesh whose estimated error can be borne, from the coarse one on."""
    share, size = shares.shares["mesh"], _coarsest(study)
    rounds: list[Round] = []
    tried_sizes: list[Floats] = []
    while True:
        chosen = with_values(study, {"mesh.size": size})
        lengths = np.array([element_size(size, part) for part in PARTS])
        try:
            tried, limits = _tried(chosen, stages)
        except InputError as refused:
            finer = _fitting(study, lengths, lengths / 2**0.5, most)
            if TOO_COARSE not in str(refused) or np.all(finer >= lengths):
                raise
            size = tuple(finer.tolist())
            continue
        rounds.append(tried)
        if tried.largest <= shares.bearable:
            return chosen, rounds, "", limits
        tried_sizes.append(lengths)
        order = _order(tried_sizes, [each.errors for each in rounds])
        factors = _factors(np.array(tried.parts), tried.errors, order, AIM * share)
        finer = _fitting(study, lengths, lengths * factors, most)
        size = tuple(finer.tolist())
        if np.all(finer >= lengths) or len(rounds) == ROUNDS:
            return chosen, rounds, _short(tried, share, most), limits
        stages.retain(())  # the factors of this mesh


def _order(lengths: list[Floats], errors: list[Floats]) -> Floats:
    """(2,) orders at which the parts' errors fall, by the last two meshes if there are two."""
    order = np.full(len(PARTS), ORDER)
    if len(lengths) > 1:
        finer = np.log(lengths[-2] / lengths[-1])
        lower = np.log(np.maximum(errors[-2], TINY) / np.maximum(errors[-1], TINY))
        np.divide(lower, finer, out=order, where=finer > 0)
    return np.asarray(np.clip(order, *BETWEEN))


def _factors(dofs: Floats, errors: Floats, order: Floats, aim: float) -> Floats:
    """(2,) next sizes over the last ones by which the errors add up to an aim at least work."""
    worth = WORK * dofs * RISE / (order * np.maximum(errors, TINY))

    def factors(price: float) -> Floats:
        return np.asarray(np.clip((worth / price) ** (1 / (order + RISE)), LEAP, 1.0))

    prices = np.geomspace(worth.min(), worth.max() / LEAP ** (BETWEEN[1] + RISE), 1000)
    left = np.array([errors @ factors(price) ** order for price in prices])
    chosen = factors(prices[np.argmax(left <= aim)] if np.any(left <= aim) else prices[-1])
    return np.asarray(chosen * min(CLOSE / chosen.min(), 1.0))


def _fitting(study: Study, lengths: Floats, smaller: Floats, most: float) -> Floats:
    """(2,) sizes as wanted, or larger up to the last ones so that both meshes may be chosen, m."""
    while True:
        sizes = np.minimum(np.maximum(smaller, SMALLEST), lengths)
        rounded = np.array([float(f"{each:.3g}") for each in sizes])
        if np.all(sizes >= lengths) or unknowns(study, tuple(rounded.tolist())) <= most:
            return rounded
        smaller = sizes / 0.97


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


def _tried(study: Study, stages: Stages) -> tuple[Round, Limits]:
    """A study's mesh with its estimated errors, and the modes by it."""
    structure = StudyStructure(study)
    linear = linear_of(structure)
    own = amplitude_errors_step(structure, structure.system(structure.loaded), linear.limits)
    errors = stages.get(mesh_errors_step(study, linear.system, linear.limits))
    limits = stages.get(linear.limits)
    shown = words_of(study.mesh.size)
    if "mesh" in pins(study) and pins(study)["mesh"].endswith(".mesh"):
        shown = "as given"
    vane, casing = (3 * len(stages.get(mesh_step(study, part)).points) for part in PARTS)
    peak = stages.get(own)
    amplitude = amplitude_error(peak, errors.interest)
    vane_share = peak.vane_share if amplitude > errors.interest else np.nan
    if np.isnan(vane_share):
        vane_share = errors.vane_share
    return Round(shown, (vane, casing), errors.interest, amplitude, float(vane_share)), limits
