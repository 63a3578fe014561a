"""Table of the study file on damped nonlinear modes, and on the air that drives them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import BeforeValidator, Field

from vanelock.common.checked import Check
from vanelock.input.schema.structure.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.study import Study

Number = Annotated[int, Field(ge=1, le=40, description="number of a mode")]
Diameter = Annotated[int, Field(ge=-500, le=500, description="nodal diameter")]
Coefficient = Annotated[
    tuple[
        Annotated[int, Field(ge=-500, le=500, description="segment")],
        Annotated[float, Field(description="real part of an influence coefficient [1/s^2]")],
        Annotated[float, Field(description="imaginary part of an influence coefficient [1/s^2]")],
    ],
    BeforeValidator(sequence),
]


class DampedModeKeys(KeyTable):
    """Natural frequency and damping ratio against amplitude, from stuck to gross slip."""

    modes: Annotated[tuple[Number, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=1, max_length=40, description="modes"
    )
    nodal_diameters: Annotated[tuple[Diameter, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=1, max_length=1000, description="nodal diameters"
    )
    influence: Annotated[tuple[Coefficient, ...], BeforeValidator(sequence)] | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="aerodynamic influence coefficients",
    )

    def _distinct(self) -> Iterator[str]:
        for name in ("modes", "nodal_diameters"):
            given = getattr(self, name)
            if given is not None and len(set(given)) < len(given):
                yield f"{name} = {list(given)}: must differ from each other"

    @property
    def air(self) -> dict[int, complex] | None:
        """Influence coefficients by segment, 1/s²; None where none are given."""
        if self.influence is None:
            return None
        return {m: complex(real, imaginary) for m, real, imaginary in self.influence}

    checks: ClassVar[tuple[Check, ...]] = (_distinct,)


def can_be_damped(study: "Study") -> Iterator[str]:
    """What keeps damped modes from being of the study's ring."""
    if (keys := study.damped_modes) is None:
        return
    N = study.ring.sectors
    for k in keys.nodal_diameters or ():
        if 2 * abs(k) > N:
            yield (
                f"damped_modes.nodal_diameters: given {k}: of {N} segments allowed are "
                f"{-(N // 2)} to {N // 2}"
            )
    segments = [m % N for m, *_ in keys.influence or ()]
    if len(set(segments)) < len(segments):
        yield f"damped_modes.influence: of {N} segments one is given twice"
