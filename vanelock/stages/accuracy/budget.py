"""An accuracy split into shares where it is cheapest.

Making the error of a source i smaller than s costs about c_i s^(-a_i). Of all shares s_i that sum
up to the accuracy, the total cost is least where

    a_i c_i s_i^(-a_i - 1) = λ        for all i: s_i is proportional to a_i cost_i(s_i).

The constants are measured (`COSTS`); the split depends on them weakly, so that constants wrong by
two cost a few per cent of time.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import NamedTuple

from vanelock.input.schema.study import Study
from vanelock.mesh.geometry.dimensions import CasingDimensions, VaneDimensions

SOURCES = ("mesh", "modes", "harmonics", "frequencies")
"""What an error of the largest response can come from."""


class _Cost(NamedTuple):
    """Cost c s^(-a) of an error s, of what grows with it: `scale` c, CPU seconds, and `power` a."""

    scale: float
    power: float


COSTS = {
    # docs/benchmarks/mesh_study.md, tetra10: 0.42 units at 7.8 % to 4.38 at 2.0 %; the joined parts
    # at 1 % take about 60 s from mesh to system (docs/benchmarks/reduction_cost.md, "paper").
    "mesh": _Cost(scale=0.025, power=1.7),
    # docs/benchmarks/speed-against-error.md, rom.accuracy from 1e-4 to 1e-6: 0.3 to 1.0 of a run
    # of 12 s more than at 1e-2.
    "modes": _Cost(scale=0.25, power=0.27),
    # There, response.harmonics 3 to 7: error 1e-3 to 9e-5 at 0.45 to 1.10 of it.
    "harmonics": _Cost(scale=0.3, power=0.39),
    # A cubic between points with their slopes: the error falls with the fourth power of their
    # distance; 25 points within 1e-2 take about 0.05 of a run.
    "frequencies": _Cost(scale=0.2, power=0.25),
}
"""Evidence beside each; for the example's scene, which others resemble in ratio."""

ON_FINE_MESHES = _Cost(scale=3.0, power=0.39)
"""Of harmonics, where the mesh is chosen too: each costs the casing's reduction at its nodal
diameter, 12 s on the 165,000 degrees of freedom that 3 % take, 1 s on the coarse mesh."""

LEAST = 0.25
"""Of the accuracy, what is shared out though pinned settings take more than the rest."""


LOWEST = 0.02
"""Of the accuracy, the least share: power laws do not hold far from where they were measured."""


@dataclass(frozen=True)
class Budget:
    """What each source may contribute to the error."""

    accuracy: float
    """Relative error allowed in all."""
    shares: dict[str, float]
    """By source, of those that adapt."""
    pinned: dict[str, str]
    """Sources whose settings the study sets, and those settings."""

    @property
    def later(self) -> list[str]:
        """Sources that adapt while the response is solved, when mesh and modes are known."""
        return [source for source in self.shares if source not in ("mesh", "modes")]

    @property
    def bearable(self) -> float:
        """Error of the mesh that is not worth another one: its share, half of the later ones'."""
        return self.shares["mesh"] + sum(self.shares[source] for source in self.later) / 2

    def meshed(self, error: float) -> "Budget":
        """The budget where the mesh is known to have an error; the later sources get the rest."""
        together = sum(self.shares[source] for source in self.later)
        factor = 1 + (self.shares["mesh"] - error) / together if self.later else 1.0
        later = {source: factor * self.shares[source] for source in self.later}
        return replace(self, shares={**self.shares, **later, "mesh": error})


def budget(study: Study, spent: float = 0.0) -> Budget:
    """Split the accuracy of a study among the sources whose settings it leaves open."""
    assert study.accuracy is not None
    pinned = pins(study)
    open_to = [source for source in SOURCES if source not in pinned]
    left = max(study.accuracy - spent, LEAST * study.accuracy)
    return Budget(study.accuracy, _split(left, open_to), pinned)


def pins(study: Study) -> dict[str, str]:
    """Sources whose settings a study sets, with those settings' keys."""
    found: dict[str, str] = {}

    def given(source: str, table: str, *names: str) -> None:
        chosen = getattr(study, table)
        for name in names:
            if name in chosen.model_fields_set and getattr(chosen, name) is not None:
                found.setdefault(source, f"{table}.{name}")

    given("mesh", "mesh", "size", "face_nodes")
    for name, own in (("vane", VaneDimensions), ("casing", CasingDimensions)):
        if not isinstance(getattr(study, name), own):
            found.setdefault("mesh", f"{name}.mesh")
    given("modes", "rom", "accuracy", "modes")
    given("harmonics", "response", "harmonics")
    given("frequencies", "response", "points", "frequencies")
    given("samples", "response", "samples")
    return found


def _costs_of(sources: Collection[str]) -> dict[str, _Cost]:
    """What the errors of some sources cost where all of them are open."""
    return COSTS | ({"harmonics": ON_FINE_MESHES} if "mesh" in sources else {})


def _split(accuracy: float, sources: Collection[str]) -> dict[str, float]:
    """Shares that sum up to the accuracy, at the least total cost."""
    if not sources:
        return {}
    floor = LOWEST * accuracy
    costs = _costs_of(sources)

    def shares(logarithm: float) -> dict[str, float]:
        """Those at which the last bit of accuracy costs λ, none below the floor."""
        found = {}
        for source in sources:
            cost = costs[source]
            rate = cost.power * cost.scale * math.exp(-logarithm)
            found[source] = max(rate ** (1 / (cost.power + 1)), floor)
        return found

    low, high = -80.0, 80.0  # logarithm of λ: the larger, the smaller the shares
    for _ in range(100):
        middle = (low + high) / 2
        if sum(shares(middle).values()) > accuracy:
            low = middle
        else:
            high = middle
    return shares(high)
