"""A step of a study: a product, what it needs, and the hash of all that it depends on.

All keys of a study are known before anything is computed, and a product that is in the cache saves
everything upstream of it.
"""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar, cast

import numpy as np

from vanelock.common.arrays import Floats
from vanelock.common.process import raise_dropped
from vanelock.pipeline.cache import Cache, key_of
from vanelock.pipeline.progress import Begun, Done, Listener

P = TypeVar("P")

SHARED = 4096
"""Steps of a kind that are remembered, so that the cases of a sweep share them: those that depend
on nothing but what `lru_cache` is given."""


@dataclass(frozen=True, eq=False, slots=True)
class Step(Generic[P]):
    """One stage of one study, or of several that agree in all that it reads.

    Attributes
    ----------
    stage : str
        What it is: the cache's name for it.
    name : str
        What the progress display calls it: the stage, and of which case where each has its own.
    key : str
        Hash of all that its product depends on, a case's name not among it.
    kind : type
        The product's class; it is saved and loaded only where it is kept.
    needs : tuple of Step
        Steps whose products it takes.
    compute : callable
        From those products to its own.
    kept : bool
        Whether the product goes into the cache; one that takes longer to read than to make
        does not.
    quick : bool
        Whether it is done before anyone could read its name.
    pulls : bool
        Whether `compute` takes, instead of the products of all that it may need, the function that
        gets the product of one of these steps, and calls it for those that turn out to be needed.
    resumes : bool
        Whether `compute` takes a store as its last argument, where it writes down the points that
        it has solved, for a run that goes on after a kill.
    """

    stage: str
    name: str
    key: str
    kind: type[P]
    needs: tuple["Step[Any]", ...]
    compute: Callable[..., P]
    is_kept: bool = True
    quick: bool = False
    pulls: bool = False
    resumes: bool = False


def step(
    stage: str,
    package: str,
    inputs: Mapping[str, Any],
    kind: type[P],
    needs: tuple[Step[Any], ...],
    compute: Callable[..., P],
    stored: bool = True,
    quick: bool = False,
    pulls: bool = False,
    resumes: bool = False,
    of: str = "",
) -> Step[P]:
    """A step whose key follows from its inputs, what it needs and the code of `package`."""
    key = key_of(stage, package, inputs, tuple(need.key for need in needs))
    name = f"{stage} {of}".strip()
    return Step(stage, name, key, kind, needs, compute, stored, quick, pulls, resumes)


@dataclass
class Stages:
    """Runs steps: from memory, from the cache, or by computing them.

    Attributes
    ----------
    cache : Cache
        Where products are kept between runs.
    listener : callable
        Called with each stage.
    done : dict of str to Done
        The steps so far by key, in order.
    cpu : dict of str to float
        What computing each of them took of processor time, now or in an earlier run, s.
    elsewhere : callable, optional
        Waits until others have put the product of a key into the cache; False where nobody will.
    """

    cache: Cache
    listener: Listener
    done: dict[str, Done] = field(default_factory=dict)
    cpu: dict[str, float] = field(default_factory=dict)
    elsewhere: Callable[[str], bool] | None = None
    _products: dict[str, Any] = field(default_factory=dict)
    _pulled: Floats = field(default_factory=lambda: np.zeros(2))
    _shown: str = ""

    def get(self, step: Step[P]) -> P:
        """Product of a step."""
        raise_dropped()
        if step.key in self._products:
            return cast(P, self._products[step.key])
        kind = cast(Any, step.kind)
        made = step.is_kept and self.elsewhere is not None and self.elsewhere(step.key)
        entry = self.cache.load(step.stage, step.key, kind) if step.is_kept else None
        if entry is not None:
            product, seconds, cpu = cast(P, entry.product), *entry[1:]
        else:
            product, seconds, cpu = self._computed(step)
        if step.key not in self.done:
            self.done[step.key] = Done(step.name, seconds, entry is not None and not made)
            self.cpu[step.key] = cpu
            if not step.quick:
                self.listener(self.done[step.key])
                self._shown = ""
        self._products[step.key] = product
        return product

    def drop(self, keys: Iterable[str]) -> None:
        """Drop some products from memory."""
        for key in keys:
            self._products.pop(key, None)

    def retain(self, steps: Iterable[Step[Any]]) -> None:
        """Drop from memory what none of the steps, nor any that they need, produces."""
        keys = {step.key for step in reachable(steps)}
        self._products = {k: v for k, v in self._products.items() if k in keys}

    def _computed(self, step: Step[P]) -> tuple[P, float, float]:
        given = [self._puller(step)] if step.pulls else [self.get(need) for need in step.needs]
        if step.key not in self.done:
            self._show(step)
        outside, self._pulled = self._pulled, np.zeros(2)
        began = _now()
        if step.resumes:
            with self.cache.points(step.stage, step.key) as store:
                product = step.compute(*given, store)
        else:
            product = step.compute(*given)
        seconds, cpu = (max(float(each), 0.0) for each in _now() - began - self._pulled)
        self._pulled = outside
        if step.is_kept:
            entry = self.cache.store(step.stage, step.key, cast(Any, product), seconds, cpu)
            product = cast(P, entry.product)  # as a later run will find it, to the last bit
        return product, seconds, cpu

    def _puller(self, step: Step[Any]) -> Callable[[Step[Any]], Any]:
        """What a step calls for a product that it needs; the display then returns to the step."""

        def get(needed: Step[Any]) -> Any:
            began = _now()
            product = self.get(needed)
            self._pulled = self._pulled + _now() - began
            self._show(step)
            return product

        return get

    def _show(self, step: Step[Any]) -> None:
        """Have the display show the step that is being computed."""
        if not step.quick and self._shown != step.name:
            self.listener(Begun(step.name))
            self._shown = step.name


def reachable(steps: Iterable[Step[Any]]) -> list[Step[Any]]:
    """The steps and all that they need, each once."""
    found: dict[str, Step[Any]] = {}
    waiting = list(steps)
    while waiting:
        step = waiting.pop()
        if step.key not in found:
            found[step.key] = step
            waiting += step.needs
    return list(found.values())


def _now() -> Floats:
    """Time and processor time, s."""
    return np.array([time.perf_counter(), time.process_time()])
