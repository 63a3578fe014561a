"""What is drawn of a case's responses, and between which curves these may lie."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Floats
from vanelock.common.product import Product
from vanelock.stages.response.solved import drawn

if TYPE_CHECKING:
    from vanelock.quantities.case_result import CaseResult
    from vanelock.quantities.products import StepProducts

Drawn: TypeAlias = tuple[Floats, Floats, NDArray[np.bool_]]
"""Frequencies, Hz, amplitudes, m, and which of them converged."""


@dataclass(frozen=True)
class Curves(Product):
    """What is drawn of a case's responses, that with the higher peak first.

    Attributes
    ----------
    names : tuple of str
        Directions, "" where there is but one.
    curve : dict of int to (3, p) float
        Frequency, Hz, amplitude, m, and whether it converged, in the order of the names.
    verdict : dict of int to (p,) int
        STABLE, UNSTABLE, UNDECIDED, or -1 where nothing is known.
    ends : dict of int to (3, p) float
        Curves between which it may lie.
    """

    names: tuple[str, ...]
    curve: Mapping[int, Floats]
    verdict: Mapping[int, NDArray[np.int64]] = field(default_factory=dict)
    ends: Mapping[int, Floats] = field(default_factory=dict)


def as_drawn(rows: Floats) -> Drawn:
    """A curve from its rows."""
    frequency, amplitude, converged = rows
    return frequency, amplitude, converged.astype(bool)


def with_curves(case: "CaseResult", products: "StepProducts") -> "CaseResult":
    """A case with its curves, and what its analyses have to say of them and of its summary."""
    responses = case.responses
    made = [case.curve(each) for each in responses]
    if case.given.response.frequencies is None:
        made[0] = drawn(responses[0], made[0][1])
    names = [""]
    if len(responses) > 1:
        names = [f"sweeping {each.direction or 'up'}" for each in responses]
    verdicts: dict[int, NDArray[np.int64]] = {}
    ends: list[Drawn] = []
    for analysis in case.analyses:
        if not (found := case.found(analysis.key)):
            continue
        case = replace(case, summary=analysis.summarise(case.summary, found))
        lines = analysis.lines(found)
        ends += map(case.curve, lines.ends)
        for i, known in enumerate(lines.verdicts):
            verdicts[i] = np.array([known.get(f, -1) for f in made[i][0].tolist()])
    curves = Curves(
        tuple(names),
        {i: np.array(each, float) for i, each in enumerate(made)},
        verdicts,
        {i: np.array(each, float) for i, each in enumerate(ends)},
    )
    products.put("curves", curves)
    return case
