"""A component as matrices, what every row is and where its nodes are."""

from dataclasses import dataclass

import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.product import Product

GENERALISED = 6
"""Direction of a coordinate that belongs to no node, such as that of a fixed-interface mode."""


@dataclass(frozen=True)
class Matrices(Product):
    """Matrices of a component in SI units, exactly Hermitian.

    Attributes
    ----------
    K : (n, n) sparse
        Stiffness, N/m between displacements, N m between rotations.
    M : (n, n) sparse or None
        Mass, kg and kg m².
    C : (n, n) sparse or None
        Viscous damping, N s/m and N m s.
    node : (n,) int
        The other program's number of each row's node; 0 for generalised coordinates.
    direction : (n,) int
        0, 1, 2: displacement in x, y, z; 3, 4, 5: rotation about them; 6: a generalised coordinate.
    position : (m, 3) float or None
        Where the nodes `position_node` are, m.
    position_node : (m,) int
        Empty where no positions are known.
    """

    K: sp.csc_array
    M: sp.csc_array | None
    C: sp.csc_array | None
    node: Integers
    direction: Integers
    position: Floats | None
    position_node: Integers

    @property
    def size(self) -> int:
        """Number of rows n."""
        return len(self.node)
