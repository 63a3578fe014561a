"""What of a sweep's cases, and of other jobs, is still to compute, in tasks.

Products that the same jobs need go together: those of one case into its task, a mesh and what
follows from it that some cases share into one of theirs, which these then wait for. What all jobs
need is not a task but computed before them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from vanelock.analyses.solved_case import with_analyses
from vanelock.input.cases.sweep import Case
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Step
from vanelock.pipeline.tasks import Task
from vanelock.stages.accuracy.choose_mesh import MeshChoice
from vanelock.stages.plan import Planned, plan
from vanelock.stages.response.limits import LIMITS


@dataclass(frozen=True)
class _CaseWork:
    """The steps of a case as given, planned anew wherever it is computed.

    Beside it what an accuracy chose for it, and the case `monitoring`, whose linear response says
    what is monitored; None: its own does.
    """

    case: Case
    choice: MeshChoice | None
    monitoring: "_CaseWork | None"

    def steps(self) -> list[Step[Any]]:
        """All whose products a run shows."""
        works = [self] if self.monitoring is None else [self.monitoring, self]
        found = plan([work.case for work in works], choices=[work.choice for work in works])
        planned = with_analyses(found[-1], found[0])
        return [*steps_of(planned), *planned.pieces]


class _Job(NamedTuple):
    """Steps whose products are wanted together, how lists call that, and whether it counts."""

    name: str
    steps: Sequence[Step[Any]]
    work: _CaseWork
    counts: bool = True


def steps_of(planned: Planned) -> list[Step[Any]]:
    """Steps of a case that a run asks for, in its order."""
    return [*parts_of(planned), planned.preload, *planned.responses, *planned.analysed]


def parts_of(planned: Planned) -> list[Step[Any]]:
    """Those before preload and response."""
    found: list[Step[Any]] = [*planned.meshes.values()]
    found += planned.structure.reduced(planned.diameters)
    found += [planned.linear.limits, *(planned.linear.responses[which] for which in LIMITS)]
    if planned.gauges is not None:
        found.append(planned.gauges)
    return found


def _jobs(planned: Sequence[Planned]) -> list[_Job]:
    """Of each case what a run shows, and what its analyses need; their pieces by themselves."""
    found, first = list[_Job](), None
    for each in planned:
        work = _CaseWork(each.case, each.choice, first)
        first, pieces = first or work, {*each.pieces}
        needs = (need for step in (*each.analysed, *each.pieces) for need in step.needs)
        steps = [need for need in needs if need not in pieces]
        steps += [step for step in steps_of(each) if step.is_kept]
        found.append(_Job(each.case.name, steps, work))
        found += [_Job(piece.name, (piece,), work, counts=False) for piece in each.pieces]
    return found


def bundle(planned: Sequence[Planned], cache: Cache) -> tuple[list[Step[Any]], list[Task]]:
    """What all jobs of cases need and is not in the cache, in order, and the tasks after it."""
    held, jobs = cache.held(), _jobs(planned)
    nodes: dict[str, Step[Any]] = {}
    users: dict[str, list[int]] = {}

    def visit(step: Step[Any], i: int, seen: set[str]) -> None:
        if step.key in seen:
            return
        seen.add(step.key)
        if step.is_kept and held(step.stage, step.key):
            return
        if not step.pulls:  # else it is not known what it needs
            for need in step.needs:
                visit(need, i, seen)
        if step.is_kept:
            nodes.setdefault(step.key, step)
            users.setdefault(step.key, []).append(i)

    for i, each in enumerate(jobs):
        seen: set[str] = set()
        for step in each.steps:
            visit(step, i, seen)
    groups: dict[tuple[int, ...], list[Step[Any]]] = {}
    for key, step in nodes.items():
        groups.setdefault(tuple(users[key]), []).append(step)
    shared = groups.pop(tuple(range(len(jobs))), [])
    tasks = []
    for members, steps in groups.items():
        leader, others = jobs[members[0]], len(members) - 1
        keys = tuple(step.key for step in steps)
        tasks.append(
            Task(
                name=f"{leader.name} and {others} more" if others else leader.name,
                work=leader.work.steps,
                keys=keys,
                users=frozenset(members),
                counts=leader.counts and leader.steps[-1].key in keys,
            )
        )
    return shared, tasks
