"""The reduced matrices of a part in its masters and fixed-interface vectors.

    K = [ K_mm      ]      M = [ M_mm  LᴴB ]
        [       Ω²  ]          [ BᴴL    1  ]

and what they leave out (`rom.errors.frequency_errors`), from r = K B η - θ (L x_m + M B η):

    G₀ = [ 0     ]    G₁ = [ 0    LᴴB ]    G₂ = [ LᴴY   YᴴMB      ]
         [    Ω² ]         [ BᴴL   2  ]         [ BᴴMY  BᴴMK⁻¹MB  ]      Y = K_ss⁻¹ L

All follow from products with every candidate vector, so that how many of them are kept may be
decided later, without the large matrices.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl

from vanelock.rom.component import Reduced
from vanelock.rom.fixed_interface.held import HeldPart, hermitian
from vanelock.rom.fixed_interface.vectors import Candidates
from vanelock.rom.system import Matrix


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
        LᴴB and YᴴMB.
    compliance : (m, m)
        LᴴY.
    second : (a, a)
        BᴴMK⁻¹MB.
    """

    candidates: Candidates
    K_mm: Matrix
    M_mm: Matrix
    inertia: Matrix
    answer: Matrix
    compliance: Matrix
    second: Matrix

    def vectors(self, count: int) -> Matrix:
        """(s, count) fixed-interface vectors of the reduced model."""
        return self.candidates.all(count) @ self.candidates.first(count)[0]

    def reduced(self, count: int, vectors: Matrix | None = None) -> Reduced:
        """Reduced matrices with `count` fixed-interface vectors."""
        V, squared = self.candidates.first(count)
        used = slice(len(V))
        LB, YMB = self.inertia[:, used] @ V, self.answer[:, used] @ V
        second = hermitian(V.conj().T @ self.second[used, used] @ V)
        m = len(self.K_mm)
        G0 = sl.block_diag(np.zeros((m, m)), np.diag(squared))
        G1 = np.block([[np.zeros((m, m)), LB], [LB.conj().T, 2 * np.eye(count)]])
        G2 = np.block([[self.compliance, YMB], [YMB.conj().T, second]])
        return Reduced(
            K=sl.block_diag(self.K_mm, np.diag(squared)),
            M=np.block([[self.M_mm, LB], [LB.conj().T, np.eye(count)]]),
            vectors=vectors,
            neglected=np.array([G0.astype(G2.dtype), G1, G2]),
            complete=self.candidates.modes.complete / (2 * np.pi),
        )


def projected(part: HeldPart, candidates: Candidates) -> Projected:
    """Products of a part with candidate vectors: a solve for each of these."""
    B = candidates.all()
    MB = part.M_ss @ B
    answers = part.held.solve(MB)
    return Projected(
        candidates,
        part.K_mm,
        part.M_mm,
        inertia=part.inertia.conj().T @ B,
        answer=part.inertia.conj().T @ answers,
        compliance=part.compliance,
        second=hermitian(MB.conj().T @ answers),
    )
