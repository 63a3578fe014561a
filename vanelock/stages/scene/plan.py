"""A case of a scene and the steps to its response."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from vanelock.input.cases.scene_cases import SceneCase
from vanelock.nonlinear import Response
from vanelock.pipeline.step import Step
from vanelock.rom import System
from vanelock.stages.response.responses import preload_step, silent_progress, stuck_modes_step
from vanelock.stages.scene.gather import gathered
from vanelock.stages.scene.modes import SceneModes
from vanelock.stages.scene.piece import Piece
from vanelock.stages.scene.steps import (
    LIMITS,
    linear_step,
    modes_step,
    piece_step,
    response_step,
    system_step,
)
from vanelock.stages.sweep.graph import Wanted


@dataclass(frozen=True)
class PlannedScene:
    """Steps of a case.

    Attributes
    ----------
    case : SceneCase
        Which.
    pieces : tuple of Step
        Its components.
    system, modes, preload, response : Step
        The system, its linear limits, its state at rest and its nonlinear response.
    linear : tuple of Step
        Linear responses with all contacts open and all stuck.
    apart : tuple of str
        A line for each component that nothing joins to another.
    other : Step or None
        The response in the other direction, where both are wanted.
    """

    case: SceneCase
    pieces: tuple[Step[Piece], ...]
    system: Step[System]
    modes: Step[SceneModes]
    linear: tuple[Step[Response], ...]
    preload: Step[Response]
    response: Step[Response]
    apart: tuple[str, ...] = ()
    other: Step[Response] | None = None

    @property
    def responses(self) -> tuple[Step[Response], ...]:
        """Its nonlinear responses, in one direction or both."""
        return (self.response,) if self.other is None else (self.response, self.other)

    @property
    def steps(self) -> list[Step[Any]]:
        """All whose products a run shows, in its order."""
        return [*self.pieces, self.modes, *self.linear, self.preload, *self.responses]

    def wanted(self) -> Wanted:
        """What other processes are asked for."""
        return Wanted(self.case.name, self.steps, self.response, SceneWork(self.case))


@dataclass(frozen=True)
class SceneWork:
    """The steps of a case, planned anew where it is computed; its files are read there too."""

    case: SceneCase

    def steps(self) -> Sequence[Step[Any]]:
        """All whose products a run shows."""
        return planned(self.case, silent_progress).steps


def planned(case: SceneCase, progress: Callable[[int, int, float, float], None]) -> PlannedScene:
    """The steps of a case; `progress` is told of each point."""
    scene = case.scene
    given = gathered(scene)
    system, bare = (system_step(scene, each, given) for each in (False, True))
    modes = modes_step(scene, bare)
    stuck = stuck_modes_step(bare, scene.response.harmonics)
    swept = partial(response_step, case.name, scene, system, modes, stuck, progress)
    return PlannedScene(
        case=case,
        pieces=tuple(piece_step(scene, name, given) for name in scene.components),
        system=system,
        modes=modes,
        linear=tuple(linear_step(scene, which, bare, modes) for which in LIMITS),
        preload=preload_step(scene.response.friction, system),
        response=swept(),
        other=swept("down") if scene.response.direction == "both" else None,
        apart=tuple(given.apart()),
    )
