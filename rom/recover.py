"""From reduced coordinates back to the displacement of every node."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.fem import Factor, Model, factorise
from vanelock.rom.component import Component
from vanelock.rom.craig_bampton import partition


@dataclass(frozen=True)
class Recovery:
    """Displacement fields of one part, computed when asked for.

    Constraint modes are not stored: a field costs one solve with the part's stiffness, its masters
    held, which is factorised once, here.

    Attributes
    ----------
    component : Component
        The reduced part.
    model : fem.Model
        The model that was reduced.
    factor : fem.Factor
        Factors of K_ss.
    masters, slaves : int arrays
        The model's dofs.
    """

    component: Component
    model: Model
    factor: Factor
    masters: NDArray[np.int64]
    slaves: NDArray[np.int64]

    def displacement(
        self, coordinates: NDArray[np.complex128], nodal_diameter: int
    ) -> NDArray[np.complex128]:
        """Cartesian displacement of each node of sector 0, (nodes, 3) or (nodes, 3, k), m.

        Parameters
        ----------
        coordinates : (n,) or (n, k)
            Reduced coordinates, in columns.
        nodal_diameter : int
            The diameter at which they are.
        """
        q = np.asarray(coordinates)
        name, size = self.component.masters.part, self.component.size
        if len(q) != size:
            raise InputError(f"{name}: {len(q)} coordinates given, it has {size}")
        columns = q.reshape(len(q), -1)
        basis = self.component.at(nodal_diameter).basis
        x = columns if basis is None else basis @ columns
        x_m, eta = x[: len(self.masters)], x[len(self.masters) :]
        K_sm = self.model.K.tocsc()[self.slaves][:, self.masters]
        field = np.zeros((self.model.K.shape[0], columns.shape[1]), complex)
        field[self.masters] = x_m
        field[self.slaves] = self.component.fixed_modes @ eta - self._solve(K_sm @ x_m)
        shape = (*self.model.dofs.shape, columns.shape[1])
        clamped = self.model.dofs < 0
        u = np.where(clamped[..., None], 0.0, field[self.model.dofs.ravel()].reshape(shape))
        return u.reshape(*self.model.dofs.shape, *q.shape[1:])

    def _solve(self, b: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """K_ss⁻¹ b by one real solve."""
        k = b.shape[1]
        x = self.factor.solve(np.hstack([b.real, np.imag(b)]))
        return np.asarray(x[:, :k] + 1j * x[:, k:])


def recovery(component: Component, model: Model) -> Recovery:
    """Prepare the recovery of a part's displacement fields: one factorisation."""
    masters, slaves = partition(model, component.boundary_nodes)
    K_ss = model.K.tocsc()[slaves][:, slaves]
    return Recovery(component, model, factorise(K_ss), masters, slaves)
