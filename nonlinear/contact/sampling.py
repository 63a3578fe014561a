"""On how many samples of a period the contact law may be evaluated."""

from vanelock.common.errors import InputError

FRICTIONS = ("orthogonal", "isotropic")


def least_samples(harmonics: int, friction: str) -> int:
    """Fewest samples of a period that H harmonics need."""
    return max(32, 16 * harmonics) if friction == "isotropic" else 4 * harmonics + 4


def checked_samples(
    samples: int | None, harmonics: int, friction: str = "orthogonal"
) -> int | None:
    """The samples to evaluate the law on; None where events are located."""
    least = least_samples(harmonics, friction)
    if samples is not None and samples < least:
        raise InputError(f"samples: given {samples}: needs at least {least}")
    return samples
