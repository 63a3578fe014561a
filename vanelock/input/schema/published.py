"""The table `[campaign]` of a study file: which values the published study's figures take here."""

import itertools
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.common.quantities import Length
from vanelock.input.schema.structure.structure import KeyTable, sequence


def _ascending(*values: float) -> bool:
    return all(a < b for a, b in itertools.pairwise(values))


Friction = Annotated[float, Field(gt=0, le=1000, description="friction coefficient")]
Interference = Annotated[Length, Field(gt=0, le=1e-3, description="interference [m]")]
Order = Annotated[int, Field(ge=1, le=99, description="highest harmonic")]
Ratio = Annotated[float, Field(gt=0, le=1e6, description="factor of the load")]
Slant = Annotated[float, Field(ge=0, le=60, description="slant of the interlock faces [deg]")]


Frictions = Annotated[tuple[Friction, ...], BeforeValidator(sequence)]
Interferences = Annotated[tuple[Interference, ...], BeforeValidator(sequence)]
Orders = Annotated[tuple[Order, ...], BeforeValidator(sequence)]
Ratios = Annotated[tuple[Ratio, ...], BeforeValidator(sequence)]
Slants = Annotated[tuple[Slant, ...], BeforeValidator(sequence)]


class Campaign(KeyTable):
    """Values of the figures and of the maps; the study's own ones are those in between."""

    mu: Frictions = Field(
        default=(0.1, 0.15, 0.3, 0.5), min_length=2, description="friction coefficient"
    )
    reference_mu: Friction = Field(default=0.3, description="friction coefficient")
    interference: Interferences = Field(
        default=(0.5e-6, 1e-6, 2e-6), min_length=2, description="interference [m]"
    )
    harmonics: Orders = Field(default=(1, 3, 5), min_length=2, description="highest harmonic")
    map_mu: Frictions = Field(
        default=(0.05, 0.1, 0.2, 0.35, 0.6, 1.0), description="friction coefficient"
    )
    map_interference: Interferences = Field(
        default=(0.5e-6, 1e-6, 2e-6, 4e-6, 8e-6, 16e-6), description="interference [m]"
    )
    map_load: Ratios = Field(
        default=(0.125, 0.25, 0.5, 1.0, 2.0, 4.0), description="factor of the load"
    )
    slants: Slants = Field(
        default=(0.0, 15.0, 25.0, 45.0),
        max_length=10,
        description="slant of the interlock faces [deg]",
    )

    def _ascends(self) -> Iterator[str]:
        for name, value in self:
            if isinstance(value, tuple) and not _ascending(*value):
                yield f"{name} = {list(value)}: must ascend"

    def _draws_the_reference(self) -> Iterator[str]:
        if self.reference_mu not in self.mu:
            yield f"reference_mu = {self.reference_mu:g}: must be one of mu = {list(self.mu)}"

    checks: ClassVar[tuple[Check, ...]] = (_ascends, _draws_the_reference)


_APART: dict[str, Callable[[Any], bool]] = {
    "sweep": lambda study: bool(study.sweep),
    "accuracy": lambda study: study.accuracy is not None,
    "excitation.engine_orders": lambda study: study.excitation.engine_orders is not None,
    "response.frequencies": lambda study: study.response.frequencies is not None,
    "response.samples": lambda study: study.response.samples is not None,
    'response.direction, unless "up"': lambda study: study.response.direction != "up",
    'response.friction = "isotropic"': lambda study: study.response.friction != "orthogonal",
    "joints.interlock.enabled = false": lambda study: not study.joints.interlock.enabled,
    "vane.mesh, unless campaign.slants = []": lambda study: (
        bool(getattr(study.vane, "mesh", None)) and bool(study.campaign.slants)
    ),
}
"""What a campaign, which chooses its cases itself around one scene, cannot have."""


def _apart(what: str, given: Callable[[Any], bool]) -> Check:
    def check(study: Any) -> Iterator[str]:
        if study.campaign is not None and given(study):
            yield f"campaign: cannot be combined with {what}"

    return check


CAMPAIGN_CHECKS: tuple[Check, ...] = tuple(_apart(*each) for each in _APART.items())
"""Of a `Study`."""
