"""A ring followed in time twice, from a wave and from that wave kicked: how the two part.

While both are near the wave, their difference is a sum of motions that a period multiplies. It is
looked at N times a period, each time from the next sector, to which the wave has come: so a
motion of nodal diameter n and exponent λ = sω is multiplied by e^{2π(s - in)/N} from look to look.
The same linear map takes each look to the next; its eigenvalues are found by least squares in the
space of the looks (dynamic mode decomposition: P. J. Schmid, J. Fluid Mech. 656 (2010) 5-28).
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.response import assemble_response
from vanelock.nonlinear.fourier import TURN, one_thread, resized, to_real
from vanelock.nonlinear.newton.newton import solve
from vanelock.nonlinear.transient.full_ring import ring
from vanelock.nonlinear.transient.integration import integrator
from vanelock.nonlinear.transient.time_response import departure as departure_of
from vanelock.nonlinear.transient.time_response import output_history

KICK = 1e-6
"""Of the modes' velocities, relative to those that the wave gives them."""
LEAST = 1e-5
"""Of singular values of the looks, relative to the largest, that still count as a direction."""


@dataclass(frozen=True)
class Parting:
    """Two motions of a ring, by period.

    Attributes
    ----------
    departure : (P,) float
        As `time_response` gives it, of the motion that is further from the wave.
    difference : (P, N, d) float
        Of the contacts' displacements, in N looks a period.
    unsolved : int
        Steps that were not solved.
    """

    departure: np.ndarray
    difference: np.ndarray
    unsolved: int

    @property
    def size(self):
        """(P,) of the difference."""
        return la.norm(self.difference, axis=(1, 2))

    @one_thread
    def eigenvalues(self, begin):
        """Eigenvalues, from look to look, of what parts the two from a period on."""
        looks = np.concatenate(self.difference[begin:])
        size = la.norm(looks[:-1], axis=1)[:, None]
        before, after = (looks[:-1] / size).T, (looks[1:] / size).T
        left, stretch, right = la.svd(before, full_matrices=False)
        kept = stretch > LEAST * stretch[0]
        left, right = left[:, kept], right[kept].T / stretch[kept]
        return la.eigvals(left.T @ (after @ right))


@one_thread
def refined(system, response, point, harmonics):
    """A point of a response with more harmonics, solved from where it is.

    From anywhere else another wave may be found: some frequencies have several.
    """
    given = structure(system, harmonics)
    omega = TURN * float(response.frequency[point])
    law = contact_law(system.contacts, harmonics)
    begin = contact_law(system.contacts, response.harmonics)(to_real(response.contact[point])).w
    found = solve(fixed(given.balance(omega), law), resized(begin, harmonics), 0.0)
    return assemble_response(given, [found])


@one_thread
def parting(system, response, periods, steps, modes, far, seed=0):
    """Follow a ring and a kicked one from the wave of a response, until one is `far` from it."""
    assert system.engine_order == 1
    assert response.converged.all()
    stepped = integrator(ring(system), 2 * np.pi * response.frequency[0], steps, modes)
    both = [stepped.balanced(response, 0) for _ in range(2)]
    rates, travels = both[1].state[:, 1], stepped.ring.weight[:, None] == 2
    rng = np.random.default_rng(seed)
    push = rng.standard_normal(rates.shape) + 1j * travels * rng.standard_normal(rates.shape)
    rates += KICK * push * np.abs(rates[1])
    departure: list[float] = []
    difference, unsolved = [], 0
    while len(departure) < periods and max(departure, default=0) < far:
        found = [stepped.period(motion) for motion in both]
        outputs = [output_history(stepped, each) for each in found]
        departure.append(
            max(
                departure_of(stepped, each, output, response, 0)
                for each, output in zip(found, outputs, strict=True)
            )
        )
        unsolved += sum(each.unsolved for each in found)
        parted = (found[1].u - found[0].u)[steps // system.sectors - 1 :: steps // system.sectors]
        looks = [np.roll(look, -i - 1, axis=0).ravel() for i, look in enumerate(parted)]
        difference.append(looks)
    return Parting(np.array(departure), np.array(difference), unsolved)
