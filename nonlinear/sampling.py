"""On how many samples of a period the contact law may be evaluated."""

FRICTIONS = ("orthogonal", "isotropic")

ISOTROPIC_SAMPLES = 256
"""Samples of a period for isotropic friction, unless told otherwise."""


def least_samples(harmonics: int, friction: str) -> int:
    """Fewest samples of a period that H harmonics need."""
    return max(32, 16 * harmonics) if friction == "isotropic" else 4 * harmonics + 4
