"""Laws of nonlinear elements by name: what each holds against displacement and velocity.

Each is a function as `Element.force` describes it; a law of one's own is written the same way.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from vanelock.common.arrays import Floats


def cubic_spring(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = k u³."""
    out[0] = p[0] * u[0] ** 3


def stop(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = k max(u - gap, 0)."""
    out[0] = p[0] * max(u[0] - p[1], 0.0)


def quadratic_damper(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = c |u̇| u̇."""
    out[0] = p[0] * abs(rate[0]) * rate[0]


def tanh_friction(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = F tanh(u̇/ε): Coulomb friction of the limit F, smooth within the velocity ε."""
    out[0] = p[0] * math.tanh(rate[0] / p[1])


def jenkins(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """Σ of sliders, each a spring k in series with friction of the limit F; p = (k, F, k, F, ...).

    Several in parallel, their limits spread, are Iwan's model. State of a slider: its place.
    """
    out[0] = 0.0
    for i in range(len(state)):
        k, limit = p[2 * i], p[2 * i + 1]
        force = k * (u[0] - state[i])
        if abs(force) > limit:
            force = math.copysign(limit, force)
            state[i] = u[0] - force / k
        out[0] += force


@dataclass(frozen=True)
class ElementLaw:
    """A law, what it is given and how much it remembers.

    Attributes
    ----------
    force : callable
    parameters : tuple of str
        With their units.
    memory : int
        Length of the state, for each set of parameters where they may repeat.
    repeats : bool
        Whether parameters may be given several times over, one set after another.
    """

    force: Callable[[Floats, Floats, Floats, Floats, Floats], None]
    parameters: tuple[str, ...]
    memory: int = 0
    repeats: bool = False


LAWS = {
    "cubic_spring": ElementLaw(cubic_spring, ("k (N/m3)",)),
    "stop": ElementLaw(stop, ("k (N/m)", "gap (m)")),
    "quadratic_damper": ElementLaw(quadratic_damper, ("c (N s2/m2)",)),
    "tanh_friction": ElementLaw(tanh_friction, ("limit (N)", "velocity (m/s)")),
    "jenkins": ElementLaw(jenkins, ("k (N/m)", "limit (N)"), memory=1, repeats=True),
}
