"""The reduced matrices of a part in its masters and fixed-interface vectors.

    K = [ K_mm      ]      M = [ M_mm  LᴴB ]
        [       Ω²  ]          [ BᴴL    1  ]

and what they leave out (`rom.errors.frequency_errors`), from r = K B η - θ (L x_m + M B η):

    G₀ = [ 0     ]    G₁ = [ 0    LᴴB ]    G₂ = [ LᴴY   YᴴMB      ]
         [    Ω² ]         [ BᴴL   2  ]         [ BᴴMY  BᴴMK⁻¹MB  ]      Y = K_ss⁻¹ L

All follow from products that need no solve beyond those by which the vectors were chosen.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Floats
from vanelock.rom.component import Reduced
from vanelock.rom.fixed_interface.candidates import Candidates
from vanelock.rom.fixed_interface.held import HeldPart, hermitian
from vanelock.rom.system.system import Matrix


@dataclass(frozen=True)
class Projected:
    """A part's products with its candidate vectors B, a of them.

    Attributes
    ----------
    candidates : Candidates
        The vectors.
    K_mm, M_mm : (m, m)
        Guyan's matrices.
    inertia, answer : (m, a)
        LᴴB and YᴴMB, B the modes and the Ritz vectors of what is kept beside them.
    compliance : (m, m)
        LᴴY.
    second : (a, a)
        BᴴMK⁻¹MB.
    ritz : (v, v)
        Those Ritz vectors in the vectors kept.
    omega_squared : (a,) float
        ω² of B, rad²/s².
    """

    candidates: Candidates
    K_mm: Matrix
    M_mm: Matrix
    inertia: Matrix
    answer: Matrix
    compliance: Matrix
    second: Matrix
    ritz: Matrix
    omega_squared: Floats

    def vectors(self) -> Matrix:
        """(s, a) fixed-interface vectors of the reduced model."""
        given = self.candidates
        return np.hstack([given.modes.vectors, given.vectors @ self.ritz])

    def reduced(self, vectors: Matrix | None = None) -> Reduced:
        """Reduced matrices."""
        count, m, squared = len(self.omega_squared), len(self.K_mm), self.omega_squared
        LB, YMB = self.inertia, self.answer
        G0 = sl.block_diag(np.zeros((m, m)), np.diag(squared))
        G1 = np.block([[np.zeros((m, m)), LB], [LB.conj().T, 2 * np.eye(count)]])
        G2 = np.block([[self.compliance, YMB], [YMB.conj().T, self.second]])
        return Reduced(
            K=sl.block_diag(self.K_mm, np.diag(squared)),
            M=np.block([[self.M_mm, LB], [LB.conj().T, np.eye(count)]]),
            vectors=vectors,
            neglected=np.array([G0.astype(G2.dtype), G1, G2]),
            complete=self.candidates.modes.complete / (2 * np.pi),
        )


def projected(part: HeldPart, candidates: Candidates) -> Projected:
    """Products of a part with the vectors that it keeps; K⁻¹M of a mode is the mode over ω²."""
    squared, Phi, W = candidates.modes.omega_squared, candidates.modes.vectors, candidates.vectors
    V, of_ritz = candidates.ritz()
    of_modes = part.inertia.gather(Phi)
    second = (part.M_ss @ W).conj().T @ candidates.answers
    return Projected(
        candidates,
        part.K_mm,
        part.M_mm,
        inertia=np.hstack([of_modes, part.inertia.gather(W) @ V]),
        answer=np.hstack([of_modes / squared, part.inertia.gather(candidates.answers) @ V]),
        compliance=part.compliance,
        second=sl.block_diag(np.diag(1 / squared), hermitian(V.conj().T @ second @ V)),
        ritz=V,
        omega_squared=np.concatenate([squared, of_ritz]),
    )
