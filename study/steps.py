"""A step of a study: a product, what it needs, and the hash of all that it depends on.

All keys of a study are known before anything is computed, and a product that is in the cache saves
everything upstream of it.
"""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from vanelock.product import Product
from vanelock.study.cache import Cache, key_of
from vanelock.study.progress import Begun, Done, Listener

P = TypeVar("P", bound=Product)


@dataclass(frozen=True)
class Step(Generic[P]):
    """One stage of one study.

    Attributes
    ----------
    name : str
        What the progress display calls it.
    key : str
        Hash of all that its product depends on.
    kind : type
        The product's class.
    needs : tuple of Step
        Steps whose products it takes.
    compute : callable
        From those products to its own.
    kept : bool
        Whether the product goes into the cache; one that takes longer to read than to make
        does not.
    quick : bool
        Whether it is done before anyone could read its name.
    """

    name: str
    key: str
    kind: type[P]
    needs: tuple["Step[Any]", ...]
    compute: Callable[..., P]
    kept: bool = True
    quick: bool = False


def step(
    name: str,
    package: str,
    inputs: Mapping[str, Any],
    kind: type[P],
    needs: tuple[Step[Any], ...],
    compute: Callable[..., P],
    kept: bool = True,
    quick: bool = False,
) -> Step[P]:
    """A step whose key follows from its inputs, what it needs and the code of `package`."""
    key = key_of(name, package, inputs, tuple(need.key for need in needs))
    return Step(name, key, kind, needs, compute, kept, quick)


@dataclass
class Stages:
    """Runs steps: from memory, from the cache, or by computing them.

    Attributes
    ----------
    cache : Cache
        Where products are kept between runs.
    listener : callable
        Told about each stage.
    done : dict of str to Done
        The steps so far by key, in order.
    """

    cache: Cache
    listener: Listener
    done: dict[str, Done] = field(default_factory=dict)
    _products: dict[str, Product] = field(default_factory=dict)

    def get(self, step: Step[P]) -> P:
        """Product of a step."""
        if step.key in self._products:
            return self._products[step.key]  # type: ignore[return-value]
        entry = self.cache.load(step.name, step.key, step.kind) if step.kept else None
        if entry is not None:
            product, seconds = entry.product, entry.seconds
        else:
            product, seconds = self._computed(step)
        if step.key not in self.done:
            self.done[step.key] = Done(step.name, seconds, entry is not None)
            if not step.quick:
                self.listener(self.done[step.key])
        self._products[step.key] = product
        return product

    def retain(self, steps: Iterable[Step[Any]]) -> None:
        """Drop from memory what none of the steps, nor any that they need, produces."""
        wanted: set[str] = set()
        waiting = list(steps)
        while waiting:
            step = waiting.pop()
            if step.key not in wanted:
                wanted.add(step.key)
                waiting += step.needs
        self._products = {k: v for k, v in self._products.items() if k in wanted}

    def _computed(self, step: Step[P]) -> tuple[P, float]:
        given = [self.get(need) for need in step.needs]
        if not step.quick and step.key not in self.done:
            self.listener(Begun(step.name))
        began = time.perf_counter()
        product = step.compute(*given)
        seconds = time.perf_counter() - began
        if step.kept:
            self.cache.store(step.name, step.key, product, seconds)
        return product, seconds
