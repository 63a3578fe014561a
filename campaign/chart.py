"""All maps and ridges of a campaign as steps, planned alike in every process."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vanelock.campaign import maps
from vanelock.campaign.optimum import Ridge
from vanelock.campaign.plane import Plane
from vanelock.study.bundles import CaseWork
from vanelock.study.forced import silent_progress
from vanelock.study.model import Study
from vanelock.study.plan import fixed
from vanelock.study.steps import Step

RIDGES = (1, 3)
"""Harmonics of the ridges, as far as the campaign has them."""


@dataclass(frozen=True)
class Charted:
    """Steps: planes by name, planes of other slants by degree, ridges."""

    planes: Mapping[str, Step[Plane]]
    slants: Mapping[float, Step[Plane]]
    ridges: tuple[Step[Ridge], ...]

    def steps(self) -> list[Step[Any]]:
        """All of them, those that take long first."""
        longest, *others = self.planes.values()
        return [longest, *self.slants.values(), *others, *self.ridges]


@dataclass(frozen=True)
class Chart:
    """What the maps and ridges of a campaign follow from; can be sent to another process.

    Attributes
    ----------
    study : Study
        With a campaign.
    reference : CaseWork
        The case whose system the study's own planes and ridges are about.
    output : (int, int)
        Output node and direction.
    node : str
        The output node's name.
    band : float or None
        Band of the reference's vane, Hz.
    """

    study: Study
    reference: CaseWork
    output: tuple[int, int]
    node: str
    band: float | None

    def steps(self) -> list[Step[Any]]:
        """All maps and ridges."""
        return self.charted(lambda *_: None).steps()

    def charted(self, told: maps.Told) -> Charted:
        """The same by kind; `told` hears points done, points in all and the last peak, m."""
        study, campaign = self.study, self.study.campaign
        assert campaign is not None
        planned = fixed(self.reference.case, self.reference.diameters, silent_progress)
        own, every = (planned.system, planned.linear.limits), maps.methods(study)
        planes = {
            other: maps.plane_step(
                f"friction, {other}", study, *own, other, methods, self.output, told
            )
            for other, methods in (("interference", every), ("load", every[:3]))
        }
        slants = {
            slant: maps.plane_step(
                f"slant {slant:g}",
                study,
                *maps.slanted(study, slant, self.band),
                "interference",
                maps.few_methods(study),
                self.output,
                told,
                every=2,
            )
            for slant in campaign.slants
            if slant != getattr(study.vane, "interlock_slant", None)
        }
        ridges = tuple(
            maps.ridge_step(study, *own, name, h, (self.node, self.output[1]))
            for h in RIDGES
            if h in campaign.harmonics
            for name in ("mu", "interference")
        )
        return Charted(planes, slants, ridges)
