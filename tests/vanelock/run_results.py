"""Runs that were not made, of cases whose products, peaks and curves are given."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.vanelock.pipeline.test_display import summary
from vanelock.quantities.case_result import CaseResult
from vanelock.quantities.products import Curves, Products
from vanelock.quantities.run_result import RunResult
from vanelock.stages.response.responses import Monitor

MONITOR = Monitor("vane output 1, radial", 0, 0)


class MadeProducts(Products):
    """Products by place; a key is the place's name unless the product has one."""

    def __init__(self, products: dict[str, Any]) -> None:
        super().__init__({})
        self.products = products

    def __contains__(self, place: str) -> bool:
        return place in self.products

    def get(self, place: str) -> Any:
        """The product of a place."""
        return self.products[place]

    def key(self, place: str) -> str:
        """Its key."""
        return str(getattr(self.products.get(place), "key", place))

    def expect(self, place: str, response: Any, of: str) -> None:
        """Nothing is."""
        raise NotImplementedError


def case_of(name, values=None, products=(), curve=None, **known) -> CaseResult:
    """A case with some products, its curve (frequency, amplitude, converged) among them."""
    made = dict(products)
    if curve is not None:
        made["curves"] = Curves(("",), {0: np.array(curve, float)})
    own: dict[str, Any] = {"problem": None, "summary": summary(case=name), **known}
    return CaseResult(
        name=name, values=values or {}, monitor=MONITOR, products=MadeProducts(made), **own
    )


def run_of(study, cases, peaks=(), curves=None, products=(), output_files=None, **known):
    """A run of some cases with peaks, None where there is none."""
    files: Any = output_files or SimpleNamespace()
    run = RunResult(study, MONITOR, files)
    for i, each in enumerate(cases):
        peak = peaks[i] if i < len(peaks) else None
        run.cases[each.name] = case_of(
            each.name,
            each.values,
            products[i] if products else (),
            curves[i] if curves else None,
            problem=each.problem,
            summary=summary(case=each.name, harmonics=None, peak=peak),
            **known,
        )
    return run
