"""Runs that were not made, of cases whose peaks and curves are given."""

from types import SimpleNamespace
from typing import Any

from tests.vanelock.pipeline.test_progress import summary
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.run_result import RunResult
from vanelock.stages.response.monitor import Monitor

MONITOR = Monitor("vane output 1, radial", 0, 0)


def run_of(study, planned, peaks=(), curves=None, stages=None, output_files=None) -> RunResult:
    """A run of some planned cases with peaks, None where there is none."""
    stages, output_files = stages or SimpleNamespace(), output_files or SimpleNamespace()
    run = RunResult(study, stages, MONITOR, output_files)
    for i, each in enumerate(planned):
        name = each.case.name
        found = summary(case=name, harmonics=None, peak=peaks[i] if i < len(peaks) else None)
        drawn: dict[str, Any] = {"": curves[i]} if curves else {}
        run.cases[name] = CaseResult(each, stages, MONITOR, found, drawn)
    return run
