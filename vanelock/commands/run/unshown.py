"""Cases that are solved when a run ends early, but were not shown yet: they are results, too."""

from collections.abc import Sequence
from dataclasses import replace

from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.quantities.case_result import CaseResult
from vanelock.results.figures.pictures import Shown
from vanelock.results.record import Record
from vanelock.stages.plan import Planned
from vanelock.stages.response.responses import LIMITS
from vanelock.stages.response.rest import undetermined
from vanelock.stages.response.summary import Peak, by_height, peak_of, summarise, sweep_of
from vanelock.stages.sweep.retries import Solved


def write_unshown(planned: Sequence[Planned], shown: Shown, cache: Cache, record: Record) -> None:
    """Write cases whose responses the cache holds, without what would have followed on them."""
    held, stages, monitor = cache.held(), Stages(cache, silent), shown.monitor
    for each in planned:
        steps = (*each.responses, each.preload)
        if each.case.name in shown.harmonics or not all(
            held(step.stage, step.key) for step in steps
        ):
            continue
        found = by_height([stages.get(step) for step in each.responses], monitor)
        turned = found[0] is not stages.get(each.responses[0])
        case = (each.turned(()) if turned else each).solved(found[0])
        case = replace(case, analyses={})
        system, static = stages.get(case.system), stages.get(case.preload)
        linear: dict[str, Peak | None] = {}
        for which in LIMITS:
            response = stages.get(case.linear.responses[which])
            linear[which] = peak_of(response, monitor.amplitude(response))
        summary = summarise(
            case.case,
            system.contacts,
            found[0],
            peak_of(found[0], monitor.amplitude(found[0])),
            stages.get(case.linear.limits),
            linear,
            float(found[0].seconds.sum()),
            undetermined(system, static),
        )
        sweeps = tuple(sweep_of(one, monitor.amplitude(one)) for one in found)
        other = found[1] if len(found) > 1 else None
        solved = Solved(case, static, found[0], None, None, None, other)
        result = CaseResult(case, stages, monitor, replace(summary, sweeps=sweeps))
        record.case(solved, result, ())
