"""How the static balance and the dynamic one depend on each other.

Coupled, all harmonics are solved together. Otherwise the static problem is solved first, with
friction and lift-off, and its mean displacement is held while the others vibrate about it:

    n(t) = max(n₀ + kn ṽ, 0)     uncoupled,
    n(t) = n₀ + kn ṽ             with constant load, friction bounded by μ n₀ for good,

and a contact that is open at rest stays open under constant load. What friction and the normal
springs do to the mean in either case is not put back into the static balance: harmonic 0 of the
response is the static problem's.
"""

from collections.abc import Callable
from dataclasses import replace

from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Structure
from vanelock.nonlinear.contact.law import Law
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.newton.newton import TOLERANCE, Solution

COUPLINGS = ("coupled", "uncoupled", "constant-load")


def at_rest(
    structure: Structure, law: Callable[[int], Law], tolerance: float = TOLERANCE
) -> Solution:
    """The static state that vibration is referred to, m = 1 coefficient."""
    force = structure.system.force.get(0)
    if force is not None and force.omega_power and force.vector.any():
        raise InputError(
            "coupling: the system's force/0 grows with the frequency: only 'coupled' is possible"
        )
    return from_nothing(static_part(structure).balance(0.0), law, tolerance)


def static_part(structure: Structure) -> Structure:
    """The same structure with harmonic 0 alone."""
    return replace(structure, harmonics=0, nodal_diameters=structure.nodal_diameters[:1])


def with_static_mean(solution: Solution, rest: Solution) -> Solution:
    """A solution about a state of rest, its harmonic 0 that of the static problem."""
    w, u = solution.w.copy(), solution.u.copy()
    w[:, :, 0], u[:, :, 0] = rest.w[:, :, 0], rest.u[:, :, 0]
    return replace(
        solution,
        w=w,
        u=u,
        residual=max(solution.residual, rest.residual),
        converged=solution.converged and rest.converged,
    )
