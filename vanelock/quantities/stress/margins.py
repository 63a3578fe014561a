"""How far the stress of a case is from what its parts bear: the worst places, by part."""

from dataclasses import dataclass

import numpy as np

from vanelock.common.arrays import Booleans
from vanelock.input.schema.study import Study
from vanelock.quantities.stress.fatigue import Cycle, Strength
from vanelock.quantities.stress.fields import NodalFields
from vanelock.quantities.stress.locations import SurfaceLocations
from vanelock.stages.parts.components import PARTS

_ALIKE = 1e-9
"""Reserves that differ by round-off, as of mates on the cyclic faces: the first node counts."""


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
    study: Study,
    cycles: NodalFields,
    locations: dict[str, SurfaceLocations],
    gauges: tuple[str, ...],
) -> Margins:
    """Margins of a study's parts; its `gauges` by their names."""
    worst, features = {}, {}
    for part in PARTS:
        of = part, locations[part], getattr(cycles, part), _strength(study, part)
        worst[part], features[part] = _margins(*of), _features(*of)
    if cycles.gauges is not None:
        bears = _strength(study, "vane")
        worst["vane"] += tuple(
            _margin("vane", f"gauge {i + 1}", None, name, "", cycles.gauges, i, bears)
            for i, name in enumerate(gauges)
        )
    return Margins(cycles, locations, worst, features)


def _strength(study: Study, part: str) -> Strength:
    """What a part of a study bears."""
    own = getattr(study.material, part)
    return Strength(own.fatigue_limit, own.tensile_strength)


def _margin(
    part: str,
    what: str,
    node: int | None,
    where: str,
    doubt: str,
    cycle: Cycle,
    i: int,
    bears: Strength,
) -> Margin:
    stresses = cycle.amplitude, cycle.mean, cycle.mean_mises, cycle.chord
    amplitude, mean, mean_mises, chord = (float(each[i]) for each in stresses)
    return Margin(part, what, node, where, doubt, amplitude, mean, mean_mises, chord, bears)


def _worst(
    part: str,
    locations: SurfaceLocations,
    cycle: Cycle,
    bears: Strength,
    what: str,
    chosen: Booleans,
) -> list[Margin]:
    """The worst of some nodes, if there are any."""
    nodes = np.flatnonzero(chosen)
    if not len(nodes):
        return []
    n = bears.reserve(cycle.amplitude[nodes], cycle.mean[nodes])
    node = int(nodes[np.argmax(n <= n.min() + _ALIKE * abs(n.min()))])
    return [
        _margin(part, what, node, locations.words(node), locations.doubt(node), cycle, node, bears)
    ]


def _margins(
    part: str, locations: SurfaceLocations, cycle: Cycle, bears: Strength
) -> tuple[Margin, ...]:
    aerofoil = np.char.startswith(locations.feature, "aerofoil")
    groups = {
        "all nodes": np.ones(len(aerofoil), bool),
        "clear of corners and point forces": locations.clear,
        "aerofoils with their roots": aerofoil,
        "aerofoils, clear": aerofoil & locations.clear,
    }
    return tuple(
        m for what in groups for m in _worst(part, locations, cycle, bears, what, groups[what])
    )


def _features(
    part: str, locations: SurfaceLocations, cycle: Cycle, bears: Strength
) -> tuple[Margin, ...]:
    """The worst clear place of each feature, the worst first."""
    made: list[Margin] = []
    for name in dict.fromkeys(sorted(locations.feature.tolist())):
        made += _worst(
            part, locations, cycle, bears, name, locations.clear & (locations.feature == name)
        )
    return tuple(sorted(made, key=lambda m: m.reserve))
