"""The pictures of a run, in the order in which they are drawn and shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from vanelock.study.board import Board, Shown
from vanelock.study.campbell_exhibits import campbells
from vanelock.study.contact_exhibits import contacts
from vanelock.study.curve_exhibits import curves
from vanelock.study.easel import Easel
from vanelock.study.exhibit import Exhibit
from vanelock.study.loop_exhibits import loops
from vanelock.study.model import Study
from vanelock.study.plan import Planned
from vanelock.study.preload_exhibits import preloads
from vanelock.study.progress import Notice
from vanelock.study.shape_exhibits import DETAILED, all_modes, mesh, response, stress
from vanelock.study.steps import Stages

__all__ = ["Gallery", "Shown"]


@dataclass
class Gallery:
    """All pictures of a run."""

    study: Study
    planned: Sequence[Planned]
    stages: Stages
    shown: Shown
    easel: Easel

    @cached_property
    def board(self) -> Board:
        """What they are drawn from."""
        return Board(self.study, self.planned, self.stages, self.shown, self.easel)

    def draw(self) -> list[Exhibit]:
        """Draw what is not there yet, and remove what earlier runs drew and this one does not."""
        board = self.board
        made = [curves(board), *campbells(board), *preloads(board)]
        detailed = self._detailed()
        if self.study.outputs.loops:
            made += [found for each in detailed for found in loops(board, each)]
        if self.study.outputs.shapes:
            modes = all_modes(board)
            made.append(mesh(board, self.planned[0], modes[0].data if modes else ()))
            made += modes
            made += [found for each in detailed for found in response(board, each)]
            made += [stress(board, each) for each in detailed]
            made += [contacts(board, each) for each in detailed]
        self.easel.tidy()
        return made

    def _detailed(self) -> list[Planned]:
        """Cases with pictures of their own."""
        cases = [each for each in self.planned if each.case.name in self.shown.top]
        if len(cases) <= DETAILED:
            return cases
        told = f"pictures of loops and shapes for the first and the last of {len(cases)} cases"
        self.easel.listener(Notice(told))
        return [cases[0], cases[-1]]
