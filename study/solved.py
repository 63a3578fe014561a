"""One point of a response as it was solved."""

from dataclasses import replace

from vanelock.nonlinear import Response


def as_solved(response: Response, point: int) -> Response:
    """A point alone, with the harmonics that it was solved with and no more.

    A response to an accuracy has at every point as many as the most demanding one; what is above a
    point's own is zero there, which the contact law would not say.
    """
    found = response.at([point])
    if found.estimates is None:
        return found
    H = int(found.estimates.harmonics[0])
    kept = slice(H + 1)
    return replace(
        found,
        x={h: x for h, x in found.x.items() if h <= H},
        contact=found.contact[:, kept],
        force=found.force[:, kept],
        output=found.output[:, kept],
        harmonic_diameters=found.harmonic_diameters[kept],
    )
