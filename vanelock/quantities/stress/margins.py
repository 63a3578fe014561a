"""How far the stress of a case is from what its parts bear: the worst places, by part."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.input.schema.study import Study
from vanelock.quantities.stress.fatigue import Cycle, Strength
from vanelock.quantities.stress.fields import NodalFields
from vanelock.quantities.stress.locations import SurfaceLocations
from vanelock.stages.parts.components import PARTS


@dataclass(frozen=True)
class Margin:
    """How far a place is from the Goodman line.

    Attributes
    ----------
    part, what : str
        Of which part, and of what in it, this is the worst place.
    node : int or None
        Of the part; None for a gauge.
    where, doubt : str
        The place in words, and why its stress may mean nothing, "" if it does.
    amplitude, mean, mean_mises, chord : float
        As of `fatigue.Cycle`, Pa.
    strength : Strength
    """

    part: str
    what: str
    node: int | None
    where: str
    doubt: str
    amplitude: float
    mean: float
    mean_mises: float
    chord: float
    strength: Strength

    @property
    def reserve(self) -> float:
        """Goodman's factor n on both stresses, by Sines."""
        return float(self.strength.reserve(self.amplitude, self.mean))

    @property
    def reserve_mises(self) -> float:
        """The same with the signed von Mises stress of the mean."""
        return float(self.strength.reserve(self.amplitude, self.mean_mises))

    @property
    def growth(self) -> float:
        """Vibratory stress margin: the factor on the vibration alone."""
        return float(self.strength.growth(self.amplitude, self.mean))


@dataclass(frozen=True)
class Margins:
    """Stress at the peak of a case, and what it leaves.

    Attributes
    ----------
    cycles : NodalFields
        Stress of every node and gauge.
    locations : dict of str to SurfaceLocations
        Places of each part's nodes.
    worst : dict of str to tuple of Margin
        By part: anywhere, clear of corners and point forces, aerofoils, gauges.
    features : dict of str to tuple of Margin
        By part: the worst clear place of each feature.
    """

    cycles: NodalFields
    locations: dict[str, SurfaceLocations]
    worst: dict[str, tuple[Margin, ...]]
    features: dict[str, tuple[Margin, ...]]

    @property
    def governing(self) -> Margin:
        """The worst place of both parts whose stress means something."""
        every = [m for part in PARTS for m in self.worst[part]]
        clear = [m for m in every if not m.doubt and m.node is not None]
        return min(clear or every, key=lambda m: m.reserve)

    @property
    def least_growth(self) -> Margin:
        """Of the worst clear places of all features that of the least vibratory stress margin."""
        every = [m for part in PARTS for m in self.features[part]]
        return min([self.governing, *every], key=lambda m: m.growth)

    @property
    def gauges(self) -> list[Margin]:
        """Those of the strain gauges."""
        return [each for each in self.worst["vane"] if each.node is None]


def margins(
    study: Study, cycles: NodalFields, at: dict[str, SurfaceLocations], gauges: tuple[str, ...] = ()
) -> Margins:
    """Margins of a study's parts; its `gauges` by their names."""
    worst = {
        part: _margins(at[part], part, getattr(cycles, part), strength(study, part))
        for part in PARTS
    }
    if cycles.gauges is not None:
        found = (
            _margin(
                "vane", f"gauge {g + 1}", None, name, "", cycles.gauges, g, strength(study, "vane")
            )
            for g, name in enumerate(gauges)
        )
        worst["vane"] = (*worst["vane"], *found)
    features = {
        part: _features(at[part], part, getattr(cycles, part), strength(study, part))
        for part in PARTS
    }
    return Margins(cycles, at, worst, features)


def strength(study: Study, part: str) -> Strength:
    """What a part of a study bears."""
    own = getattr(study.material, part)
    return Strength(own.fatigue_limit, own.tensile_strength)


def _margin(
    part: str,
    what: str,
    node: int | None,
    where: str,
    doubt: str,
    found: Cycle,
    i: int,
    bears: Strength,
) -> Margin:
    return Margin(
        part=part,
        what=what,
        node=node,
        where=where,
        doubt=doubt,
        amplitude=float(found.amplitude[i]),
        mean=float(found.mean[i]),
        mean_mises=float(found.mean_mises[i]),
        chord=float(found.chord[i]),
        strength=bears,
    )


def _worst(
    part: str,
    what: str,
    at: SurfaceLocations,
    found: Cycle,
    bears: Strength,
    chosen: NDArray[np.bool_],
) -> list[Margin]:
    """The worst of some nodes, if there are any."""
    nodes = np.flatnonzero(chosen)
    if not len(nodes):
        return []
    n = bears.reserve(found.amplitude[nodes], found.mean[nodes])
    node = int(nodes[int(np.argmin(n))])
    return [_margin(part, what, node, at.words(node), at.doubt(node), found, node, bears)]


def _margins(at: SurfaceLocations, part: str, found: Cycle, bears: Strength) -> tuple[Margin, ...]:
    aerofoil = np.char.startswith(at.feature, "aerofoil")
    every = np.ones(len(aerofoil), bool)
    return (
        *_worst(part, "all nodes", at, found, bears, every),
        *_worst(part, "clear of corners and point forces", at, found, bears, at.clear),
        *_worst(part, "aerofoils with their roots", at, found, bears, aerofoil),
        *_worst(part, "aerofoils, clear", at, found, bears, aerofoil & at.clear),
    )


def _features(at: SurfaceLocations, part: str, found: Cycle, bears: Strength) -> tuple[Margin, ...]:
    """The worst clear place of each feature, the worst first."""
    made: list[Margin] = []
    for name in dict.fromkeys(sorted(at.feature.tolist())):
        made += _worst(part, name, at, found, bears, at.clear & (at.feature == name))
    return tuple(sorted(made, key=lambda m: m.reserve))
