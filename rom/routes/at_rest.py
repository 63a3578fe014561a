"""Loads at rest on a part that is reduced: their static answers as further vectors.

With the masters held, a load f has the answer K_ss⁻¹ f_s. Where that is among the vectors, and with

    f_m + Ψᴴ f_s    on the masters,    Bᴴ f_s    on the vectors B,

the reduced part's displacement at rest is the full one's, whatever it is joined to: K has no term
between masters and vectors. The masters' own is exact without further vectors.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.rom.fixed_interface.candidates import Candidates
from vanelock.rom.fixed_interface.held import HeldPart, hermitian
from vanelock.rom.fixed_interface.projection import Projected
from vanelock.rom.routes.condensed import Condensed, Sector
from vanelock.rom.routes.problem import Problem
from vanelock.rom.system.system import Matrix

Loads = Mapping[str, Floats]


@dataclass(frozen=True)
class HeldLoads:
    """Loads at rest where the masters are held.

    Attributes
    ----------
    names : tuple of str
        Of the loads, l of them.
    masters : (m, l)
        Forces that the part hands on to its masters, N.
    slaves : (s, l)
        On the dofs of the fixed-interface vectors, N.
    """

    names: tuple[str, ...]
    masters: Matrix
    slaves: Matrix

    def answered(self, chosen: Candidates, part: HeldPart) -> tuple[Candidates, Matrix]:
        """The vectors with the answers that they do not hold; the answers (s, l) to the loads."""
        answers = part.held.solve(self.slaves)
        return chosen.answering(part, self.slaves, answers), answers

    def reduced(self, part: HeldPart, products: Projected, answers: Matrix) -> dict[str, Matrix]:
        """(m + a,) of each load in the coordinates of masters and vectors.

        The vectors' shares are Ω² B⁺ K_ss⁻¹ f_s, which is Bᴴ f_s for exact modes, and gives the
        exact answer for those that are exact to a tolerance.
        """
        B = products.vectors()
        MB = part.M_ss @ B
        shares = sl.solve(hermitian(B.conj().T @ MB), MB.conj().T @ answers, assume_a="pos")
        forces = products.omega_squared[:, None] * shares
        found = np.concatenate([self.masters, forces])
        return {name: found[:, i] for i, name in enumerate(self.names)}


def held_loads(shared: Condensed, loads: Loads, sector: Sector | None = None) -> HeldLoads:
    """Loads on the free dofs of a model, for a part in one piece or a sector at a diameter."""
    problem = shared.problem
    f = np.column_stack([_of_dofs(problem, name, load) for name, load in loads.items()])
    slaves = f[shared.slaves]
    carried = f[problem.boundary_rows] + shared.interior.restrict(slaves)
    faces, masters = carried[: shared.faces], carried[shared.faces :]
    if sector is not None:
        masters = masters + sector.moved().conj().T @ faces
        slaves = np.concatenate([sector.follow.conj().T @ f[problem.face_rows], slaves])
    return HeldLoads(tuple(loads), masters, slaves)


def _of_dofs(problem: Problem, name: str, load: Floats) -> Floats:
    """(n,) load on the dofs of a problem from that on the model's."""
    given, n = np.asarray(load, float), problem.model.K.shape[0]
    if given.shape != (n,):
        raise InputError(f"loads[{name!r}]: shape {given.shape}: needed is ({n},), the free dofs")
    if not np.isfinite(given).all():
        raise InputError(f"loads[{name!r}]: must be finite")
    return given if problem.means is None else np.asarray(problem.means.T @ given)
