"""Tables on rings of unlike segments: by how much they differ, and how many rings."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field, field_validator

from vanelock.common.checked import Check
from vanelock.common.quantities import Frequency
from vanelock.input.schema.structure.structure import KeyTable, sequence

if TYPE_CHECKING:
    from vanelock.input.schema.scene import Scene
    from vanelock.input.schema.study import Study


def _deviation(value: object) -> object:
    """A standard deviation, or deviations of all segments, relative."""
    each = value if isinstance(value, list | tuple) else (value,)
    if not each or any(isinstance(v, bool) or not isinstance(v, int | float) for v in each):
        raise ValueError("expected a number, such as 0.01 for 1 %, or a list with one a segment")
    if isinstance(value, list | tuple):
        if not all(-1 < v <= 10 for v in each):
            raise ValueError("relative deviations of segments must be > -1 and <= 10")
        return tuple(float(v) for v in each)
    if not 0 <= each[0] <= 1:
        raise ValueError("a relative standard deviation must be >= 0 and <= 1")
    return float(each[0])


Deviation = Annotated[Any, BeforeValidator(_deviation)]


class JointDeviations(KeyTable):
    """By how much the segments of a ring differ in a joint, relative to the joint's own values."""

    interference: Deviation | None = Field(default=None, description="deviation of interference")
    mu: Deviation | None = Field(default=None, description="deviation of the friction coefficient")
    kn: Deviation | None = Field(default=None, description="deviation of the normal stiffness")
    kt: Deviation | None = Field(default=None, description="deviation of the tangential stiffness")
    slider: Annotated[float, Field(ge=0, le=1)] | None = Field(
        default=None, description="deviation of static friction, of its limit"
    )


class JointUnlikeKeys(KeyTable):
    """How much more some segment vibrates where the segments of a ring are not alike."""

    rings: int = Field(default=20, ge=1, le=10_000, description="number of rings drawn")
    seed: int = Field(default=1, ge=0, le=2**31 - 1, description="seed")
    range: Annotated[tuple[Frequency, ...], BeforeValidator(sequence)] | None = Field(
        default=None, min_length=2, max_length=2, description="[low, high] frequency [Hz]"
    )
    joints: dict[str, JointDeviations] = Field(default={}, description="deviations by joint")

    @field_validator("range")
    @classmethod
    def _low_high(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if value is not None and not 0 < value[0] < value[1]:
            raise ValueError("must be [low, high] with 0 < low < high")
        return value

    def _deviates(self) -> Iterator[str]:
        if not self.given:
            yield "nothing deviates: give unlike.joints.<joint>.mu, or another deviation"

    checks: ClassVar[tuple[Check, ...]] = (_deviates,)

    @property
    def given(self) -> dict[str, Any]:
        """What deviates, by key below the table."""
        return {
            f"joints.{joint}.{name}": value
            for joint, keys in self.joints.items()
            for name in JointDeviations.model_fields
            if (value := getattr(keys, name)) is not None
        }

    @property
    def count(self) -> int:
        """Rings: as many as are drawn, or the one that is given."""
        drawn = any(isinstance(value, float) for value in self.given.values())
        return self.rings if drawn else 1


class UnlikeKeys(JointUnlikeKeys):
    """The same of a study, whose vanes may differ by themselves."""

    frequency: Deviation | None = Field(
        default=None, description="deviation of the natural frequencies of a vane alone"
    )
    modes: int = Field(default=5, ge=1, le=50, description="number of modes of a vane alone")

    @property
    def given(self) -> dict[str, Any]:
        """What deviates, by key below the table."""
        found = super().given
        return found if self.frequency is None else {**found, "frequency": self.frequency}


def can_be_unlike(given: "Study | Scene") -> Iterator[str]:
    """What keeps segments from differing."""
    if (keys := given.unlike) is None:
        return
    sectors, known = given.ring.sectors, given.joint_names
    ready = getattr(given, "system", None) is not None  # whose file says how many
    if sectors == 1 and not ready:
        yield "unlike: needs a ring of several segments: ring.sectors = 1"
    for name in keys.joints:
        if known and name not in known:
            yield f'unlike.joints: given "{name}": allowed are {", ".join(known)}'
    for name, value in keys.given.items():
        if isinstance(value, tuple) and not ready and len(value) != sectors:
            yield f"unlike.{name}: given {len(value)} numbers: needs 1, or one a segment: {sectors}"
    if "rings" in keys.model_fields_set and keys.count != keys.rings:
        yield f"unlike.rings = {keys.rings}: all deviations are given by segment: one ring"
