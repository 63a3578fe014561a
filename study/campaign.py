"""The table `[campaign]` of a study file: which values the published study's figures take here."""

import itertools
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from vanelock.quantities import Length
from vanelock.study.structure import Table, sequence


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


class Campaign(Table):
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

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        """Every list ascends, and the reference is one of those drawn."""
        for name, value in self:
            if isinstance(value, tuple) and not _ascending(*value):
                raise ValueError(f"{name} = {list(value)}: must ascend")
        if self.reference_mu not in self.mu:
            raise ValueError(
                f"reference_mu = {self.reference_mu:g}: must be one of mu = {list(self.mu)}"
            )
        return self


def check_campaign(study: Any) -> None:
    """Refuse what a campaign, which chooses its cases itself around one scene, cannot have."""
    if study.campaign is None:
        return
    own_mesh = bool(getattr(study.vane, "mesh", None)) and bool(study.campaign.slants)
    refused = {
        "sweep": bool(study.sweep),
        "accuracy": study.accuracy is not None,
        "excitation.engine_orders": study.excitation.engine_orders is not None,
        "response.frequencies": study.response.frequencies is not None,
        "response.samples": study.response.samples is not None,
        'joints.friction = "isotropic"': study.joints.friction != "orthogonal",
        "joints.interlock.enabled = false": not study.joints.interlock.enabled,
        "vane.mesh, unless campaign.slants = []": own_mesh,
    }
    for what, given in refused.items():
        if given:
            raise ValueError(f"campaign: cannot be combined with {what}")
