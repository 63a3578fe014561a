"""Tran's reduction of the cyclic face: a few interface modes instead of its dofs.

D.-M. Tran, Component mode synthesis methods using interface modes. Application to structures with
cyclic symmetry, Computers & Structures 79 (2001) 209-222.

With b the face dofs and t the retained masters of the cyclic Craig-Bampton matrices:

- "published": modes of the part reduced statically to its faces (Guyan, all other masters
  condensed), x_b = Φ_cs η_cs;
- "followed": face modes with the other masters held, and the faces' static answer to those masters,
  x_b = Φ_cs η_cs - K_bb⁻¹ K_bt x_t.
"""

from typing import Literal

import numpy as np
import scipy.linalg as sl

from vanelock.common.errors import InputError
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.system.system import Matrix

Interface = Literal["published", "followed"]


def interface_basis(
    K: Matrix,
    M: Matrix,
    faces: int,
    masters: int,
    count: int,
    interface: Interface = "published",
) -> Matrix:
    """W_Tran in (x_b, x_t, η) = W_Tran (η_cs, x_t, η)."""
    b, t = slice(0, faces), slice(faces, faces + masters)
    lowest = [0, count - 1]
    follow = np.zeros((faces, masters), K.dtype)
    if interface == "published":
        # Static answer of the other masters to the faces; the modal amplitudes stay zero in it.
        X = -np.linalg.solve(K[t, t], K[t, b]) if masters else np.zeros((0, faces), K.dtype)
        S = K[b, b] + K[b, t] @ X
        M_aux = M[b, b] + M[b, t] @ X + X.conj().T @ (M[t, b] + M[t, t] @ X)
        modes = sl.eigh(hermitian(S), hermitian(M_aux), subset_by_index=lowest)[1]
    else:
        modes = sl.eigh(hermitian(K[b, b]), hermitian(M[b, b]), subset_by_index=lowest)[1]
        follow = -np.linalg.solve(K[b, b], K[b, t])
    fixed = len(K) - faces - masters
    W = np.zeros((len(K), count + masters + fixed), K.dtype)
    W[b, :count] = modes
    W[b, count : count + masters] = follow
    W[faces:, count:] = np.eye(masters + fixed)
    return W


def check_count(count: int, faces: int) -> None:
    """Refuse a number of interface modes that a face of that many dofs has not."""
    if not 1 <= count <= faces:
        raise InputError(f"interface_modes = {count}: allowed are 1 to {faces}, the dofs of a face")
