"""Tran's reduction of the cyclic face: a few interface modes instead of its dofs.

D.-M. Tran, Component mode synthesis methods using interface modes. Application to structures with
cyclic symmetry, Computers & Structures 79 (2001) 209-222.

With b the face dofs of the cyclic Craig-Bampton matrices and t the retained masters,
x_b = Φ_cs η_cs, Φ_cs modes of the part reduced statically to its faces (Guyan, all other masters
condensed).
"""

import numpy as np
import scipy.linalg as sl

from vanelock.common.errors import InputError
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.system.system import Matrix


def interface_basis(K: Matrix, M: Matrix, faces: int, masters: int, count: int) -> Matrix:
    """W_Tran in (x_b, x_t, η) = W_Tran (η_cs, x_t, η)."""
    b, t = slice(0, faces), slice(faces, faces + masters)
    # Static answer of the other masters to the faces; the modal amplitudes stay zero in it.
    X = -np.linalg.solve(K[t, t], K[t, b]) if masters else np.zeros((0, faces), K.dtype)
    S = K[b, b] + K[b, t] @ X
    M_aux = M[b, b] + M[b, t] @ X + X.conj().T @ (M[t, b] + M[t, t] @ X)
    modes = sl.eigh(hermitian(S), hermitian(M_aux), subset_by_index=[0, count - 1])[1]
    fixed = len(K) - faces - masters
    W = np.zeros((len(K), count + masters + fixed), K.dtype)
    W[b, :count] = modes
    W[faces:, count:] = np.eye(masters + fixed)
    return W


def check_count(count: int, faces: int) -> None:
    """Refuse a number of interface modes that a face of that many dofs has not."""
    if not 1 <= count <= faces:
        raise InputError(f"interface_modes = {count}: allowed are 1 to {faces}, the dofs of a face")
