"""What a study or a scene is excited with, in words: directions as they act, and resultants."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vanelock.common.arrays import Floats, unit_vectors
from vanelock.common.tables import counted
from vanelock.input.cases.values import Problem, ring_of
from vanelock.input.schema.scene import Scene

if TYPE_CHECKING:
    from vanelock.stages.matrices.gather import Gathered

UNIT = 1e-9
"""Difference of a vector's length from 1 that is rounding."""


def load_lines(
    problem: Problem, nodes: int | None, lists: "Gathered | None" = None
) -> Iterator[str]:
    """A line for each load."""
    sectors, _ = ring_of(problem)
    if not isinstance(problem, Scene):
        if (force := problem.excitation.force_per_node) and nodes:
            yield f"excitation: {_each(force, nodes, sectors)}, radial"
        return
    if lists is None:
        return
    tables = {f"loads[{i}]": keys for i, keys in enumerate(problem.loads)}
    for load in lists.loads:
        keys = tables[load.where]
        direction = np.array(keys.direction, float)
        text = f"{load.where}: {_each(keys.amplitude or 0.0, len(load.nodes), sectors)}, along "
        text += _vector(unit_vectors(direction, load.where))
        if abs(np.linalg.norm(direction) - 1) > UNIT:
            text += f", the direction {_vector(direction)} at length 1"
        yield text
    for each in lists.forces:
        total = abs(each.factor) * each.forces.sum(axis=0)
        yield f"{each.where}: forces on {counted(len(each.nodes), 'node')}, sum {_vector(total)} N"


def _vector(values: Floats) -> str:
    return f"[{', '.join(f'{value:.4g}' for value in values.tolist())}]"


def _each(force: float, nodes: int, sectors: int) -> str:
    """A force on each of some nodes, and what it comes to."""
    text = f"{force:,.6g} N on {'each of ' if nodes > 1 else ''}{counted(nodes, 'node')}"
    if nodes > 1:
        text += f", {force * nodes:,.6g} N together"
    return text if sectors == 1 else f"{text}, {force * nodes * sectors:,.6g} N around the ring"
