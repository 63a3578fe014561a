"""Nonlinear elements between coordinates, by a law that has a name or one's own.

A law is a function as `Element.force` describes it.
"""

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NoReturn, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arguments import OfKind
from vanelock.common.arrays import Array, Floats, as_array
from vanelock.common.errors import InputError


def _cubic_spring(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = k u³."""
    out[0] = p[0] * u[0] ** 3


def _stop(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = k max(u - gap, 0)."""
    out[0] = p[0] * max(u[0] - p[1], 0.0)


def _quadratic_damper(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = c |u̇| u̇."""
    out[0] = p[0] * abs(rate[0]) * rate[0]


def _tanh_friction(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """F = F tanh(u̇/ε): Coulomb friction of the limit F, smooth within the velocity ε."""
    out[0] = p[0] * math.tanh(rate[0] / p[1])


def _jenkins(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
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
class _ElementLaw:
    """A law, what it is given and how much it remembers."""

    force: Callable[[Floats, Floats, Floats, Floats, Floats], None]
    parameters: tuple[str, ...]  # with their units
    memory: int = 0  # length of the state, for each set of parameters where they may repeat
    repeats: bool = False


_LAWS = {
    "cubic_spring": _ElementLaw(_cubic_spring, ("k (N/m3)",)),
    "stop": _ElementLaw(_stop, ("k (N/m)", "gap (m)")),
    "quadratic_damper": _ElementLaw(_quadratic_damper, ("c (N s2/m2)",)),
    "tanh_friction": _ElementLaw(_tanh_friction, ("limit (N)", "velocity (m/s)")),
    "jenkins": _ElementLaw(_jenkins, ("k (N/m)", "limit (N)"), memory=1, repeats=True),
}


Place: TypeAlias = int | tuple[int | None, int | None] | Array
"""A displacement: see `Contact`."""
Force: TypeAlias = Callable[[Floats, Floats, Floats, Floats, Floats], None]
"""See `Element.force`."""

_TRIALS = 0.0, 1e-6, -1e-6, 1.0, -1.0
"""Displacements, m, and velocities, m/s, at which a law is tried."""
_MOST = 1000  # a memory that a law is tried with where it uses more than it says


@dataclass(frozen=True, kw_only=True)
class Element(OfKind):
    """A nonlinear element between coordinates of given matrices, for `System.from_matrices`.

    Attributes
    ----------
    force : callable or str
        force(u, rate, state, parameters, out): puts into `out` (d,) the forces, N, that the element
        holds against displacements u (d,), m, and velocities rate (d,), m/s. With a memory, state
        (n,) is what the last instant left, zeros at first, and the function puts in what this one
        leaves. It is compiled by Numba. Or the name of one in `rom.element_laws`.
    places : sequence of place
        The displacements u, one to three, each as in `Contact`.
    parameters : (k,) array_like
        Handed to the function.
    memory : int
        n, the length of `state`; 0: the force depends on this instant alone. Of a named law it is
        known.
    stiffness : float, optional
        N/m: the balance is solved around linear springs of that size in place of the element. What
        it is makes no difference to the answer; by default the structure's own at these places.
    name : str

    Raises
    ------
    InputError
        If the law or a number is impossible.
    """

    force: Force | str
    places: Sequence[Place]
    parameters: ArrayLike = ()
    memory: int = 0
    stiffness: float | None = None
    name: str = "element"

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        super().__post_init__()
        places = self.places
        if not 1 <= len(places) <= 3:
            self._refuse(f"places = {places!r}: needs a list of one to three")
        values = as_array(self.parameters, f"Element {self.name!r}: parameters")
        if values.ndim != 1 or not np.isfinite(values).all():
            self._refuse(f"parameters = {self.parameters!r}: needs a list of numbers")
        object.__setattr__(self, "parameters", np.ascontiguousarray(values, float))
        object.__setattr__(self, "memory", operator.index(self.memory))
        if self.memory < 0:
            self._refuse(f"memory = {self.memory}: must be >= 0")
        if self.stiffness is not None and not 0 < self.stiffness < np.inf:
            self._refuse(f"stiffness = {self.stiffness}: must be > 0")
        if isinstance(self.force, str):
            self._take(self.force)
        else:
            self._try(self.memory)

    def _take(self, law: str) -> None:
        """Check what a named law is given."""
        if law not in _LAWS:
            self._refuse(f"force = {law!r}: allowed: {', '.join(_LAWS)}")
        known, given = _LAWS[law], np.asarray(self.parameters)
        wanted = ", ".join(known.parameters)
        repeats = known.repeats and len(given) % len(known.parameters) == 0 and len(given)
        if len(given) != len(known.parameters) and not repeats:
            self._refuse(f"parameters = {given.tolist()}: {law} needs {wanted}")
        if len(self.places) != 1:
            self._refuse(f"places: given {len(self.places)}: {law} needs one")
        pairs = len(given) // len(known.parameters)
        object.__setattr__(self, "memory", known.memory * pairs)

    def _try(self, memory: int) -> None:
        """Call the law as it is written: compiled, it would read and write beyond its arrays."""
        d = len(self.places)
        for size in _TRIALS:
            u, state = np.full(d, size), np.zeros(memory)
            try:
                with np.errstate(all="ignore"):
                    self.function(u, u.copy(), state, np.asarray(self.parameters), np.zeros(d))
            except IndexError as error:
                if memory == self.memory:
                    self._try(_MOST)  # refuses what is not of the memory
                    self._refuse(f"memory = {memory}: force uses more of state ({error})")
                self._refuse(f"force reads or writes beyond what it is given ({error})")
            except Exception:  # no number there, or what the compiler says
                continue

    def _refuse(self, why: str) -> NoReturn:
        raise InputError(f"Element {self.name!r}: {why}")

    @property
    def function(self) -> Force:
        """The law, not compiled."""
        if isinstance(self.force, str):
            return _LAWS[self.force].force
        # What Numba has compiled already is compiled once more, with the types that it meets here.
        function: Force = getattr(self.force, "py_func", self.force)
        return function


def spring_along(row: Array, K: Array, M: Array) -> float:
    """The structure's own stiffness along a displacement, N/m; if free, inertia at 1 rad/s."""
    own, inertia = ((row.conj() @ A @ row).real for A in (K, M))
    return float(own if own > 0 else inertia) / (float(np.vdot(row, row).real) ** 2 or 1.0)
