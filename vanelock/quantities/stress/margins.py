"""How far the stress of a case is from what its parts bear: the worst places, by part."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Booleans
from vanelock.input.schema.study import Study
from vanelock.quantities.stress.fatigue import Cycle
from vanelock.quantities.stress.fields import NodalFields
from vanelock.quantities.stress.locations import SurfaceLocations
from vanelock.stages.parts.components import PARTS

_ALIKE = 1e-9
"""Reserves that differ by round-off, as of mates on the cyclic faces: the first node counts."""


@dataclass(frozen=True)
class _Strength:
    """What a material bears: fatigue limit at no mean stress and tensile strength, Pa."""

    limit: float
    tensile: float

    def reserve(self, amplitude: ArrayLike, mean: ArrayLike) -> Any:
        """Safety factor n on both stresses; infinite where there are none."""
        used = np.asarray(amplitude) / self.limit + np.maximum(mean, 0.0) / self.tensile
        return np.divide(1.0, used, out=np.full(used.shape, np.inf), where=used > 0)[()]

    def growth(self, amplitude: ArrayLike, mean: ArrayLike) -> Any:
        """Vibratory stress margin: the factor on the vibration; 0 where the mean breaks it."""
        left = self.limit * (1 - np.maximum(mean, 0.0) / self.tensile)
        a = np.asarray(amplitude, float)
        return np.divide(left.clip(0), a, out=np.full(a.shape, np.inf), where=a > 0)[()]


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
    strength: _Strength

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
    study: Study,
    cycles: NodalFields,
    locations: dict[str, SurfaceLocations],
    gauges: tuple[str, ...],
) -> Margins:
    """Margins of a study's parts; its `gauges` by their names."""
    worst, features = {}, {}
    for part in PARTS:
        own = getattr(study.material, part)
        strength = _Strength(own.fatigue_limit, own.tensile_strength)
        places = _Places(part, locations[part], getattr(cycles, part), strength)
        worst[part], features[part] = places.groups(), places.features()
        if part == "vane" and cycles.gauges is not None:
            read = replace(places, cycle=cycles.gauges)
            named = enumerate(gauges)
            worst[part] += tuple(read.margin(f"gauge {i + 1}", i, None, name) for i, name in named)
    return Margins(cycles, locations, worst, features)


@dataclass(frozen=True)
class _Places:
    """Places of a part, their stress cycles, and what they bear."""

    part: str
    locations: SurfaceLocations
    cycle: Cycle
    strength: _Strength

    def margin(self, what: str, i: int, node: int | None, where: str, doubt: str = "") -> Margin:
        """That of the i-th cycle."""
        of = self.cycle
        a, m, mises, chord = (float(x[i]) for x in (of.amplitude, of.mean, of.mean_mises, of.chord))
        return Margin(self.part, what, node, where, doubt, a, m, mises, chord, self.strength)

    def worst(self, what: str, chosen: Booleans) -> list[Margin]:
        """The worst of some nodes, if there are any."""
        nodes = np.flatnonzero(chosen)
        if not len(nodes):
            return []
        n = self.strength.reserve(self.cycle.amplitude[nodes], self.cycle.mean[nodes])
        node = int(nodes[np.argmax(n <= n.min() + _ALIKE * abs(n.min()))])
        where, doubt = self.locations.words(node), self.locations.doubt(node)
        return [self.margin(what, node, node, where, doubt)]

    def groups(self) -> tuple[Margin, ...]:
        """The worst anywhere, clear of corners and point forces, and of aerofoils."""
        aerofoil = np.char.startswith(self.locations.feature, "aerofoil")
        groups = {
            "all nodes": np.ones(len(aerofoil), bool),
            "clear of corners and point forces": self.locations.clear,
            "aerofoils with their roots": aerofoil,
            "aerofoils, clear": aerofoil & self.locations.clear,
        }
        return tuple(m for what, chosen in groups.items() for m in self.worst(what, chosen))

    def features(self) -> tuple[Margin, ...]:
        """The worst clear place of each feature, the worst first."""
        clear, feature = self.locations.clear, self.locations.feature
        names = dict.fromkeys(sorted(feature.tolist()))
        made = (m for name in names for m in self.worst(name, clear & (feature == name)))
        return tuple(sorted(made, key=lambda m: m.reserve))
