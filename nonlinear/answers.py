"""What the answers consist of that a journal keeps of a response."""

from vanelock.nonlinear.compressed import Basis
from vanelock.nonlinear.law import Deviation
from vanelock.nonlinear.linearised import Kept
from vanelock.nonlinear.newton import Solution
from vanelock.nonlinear.replay import Journal, Replay


def replaying(journal: Journal | None, *more: type) -> Replay:
    """What asks for solutions, or dataclasses that consist of them, `more`, with a journal."""
    return Replay(journal, shared=(Kept, Basis), known=(Solution, Deviation, *more))
