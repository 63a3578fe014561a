"""What every solver behind `factorise` takes and returns."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import scipy.sparse as sp
from numpy.typing import NDArray

Matrix = NDArray[Any]
Sparse = sp.sparray | sp.spmatrix
Solve = Callable[[Matrix], Matrix]


@dataclass(frozen=True)
class Numeric:
    """A numerical factorisation.

    Attributes
    ----------
    solve : callable
        A⁻¹ b for a dense (n, k) array b of A's kind in Fortran order.
    negative : int or None
        Number of negative eigenvalues of A (Sylvester's law of inertia), where the pivots give it.
    nonzeros : int or None
        Entries stored in the factors, where the solver counts them.
    analysis : object
        What a later factorisation with the same pattern may begin from; None if nothing.
    """

    solve: Solve
    negative: int | None = None
    nonzeros: int | None = None
    analysis: Any = None


class BreakdownError(Exception):
    """A pivot that is zero, or negative where none may be."""
