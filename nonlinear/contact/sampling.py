"""On how many samples of a period the contact law may be evaluated."""

FRICTIONS = ("orthogonal", "isotropic")


def least_samples(harmonics: int) -> int:
    """Fewest samples of a period that H harmonics need."""
    return 4 * harmonics + 4
