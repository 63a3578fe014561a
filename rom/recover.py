"""From reduced coordinates back to the displacement, strain and stress of every node."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.errors import InputError
from vanelock.fem import Factor, Model, factorise
from vanelock.rom import fields
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
        self, coordinates: NDArray[np.complex128], nodal_diameter: int, sector: int = 0
    ) -> NDArray[np.complex128]:
        """Cartesian displacement of each node of a sector, (nodes, 3) or (nodes, 3, k), m.

        Parameters
        ----------
        coordinates : (n,) or (n, k)
            Reduced coordinates, in columns.
        nodal_diameter : int
            The diameter at which they are.
        sector : int
            The sector, see `vanelock.rom.fields`; coordinates are those of sector 0.
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
        u = u.reshape(*self.model.dofs.shape, *q.shape[1:])
        return fields.in_sector(u, nodal_diameter, self.model.part.sectors, sector)

    def adjoint(self, functional: Any, nodal_diameter: int) -> NDArray[np.complex128]:
        """Rows (g, n) in reduced coordinates of linear functionals of sector 0's displacements.

        Parameters
        ----------
        functional : (g, free dofs) sparse
            Rows on the model's free dofs.
        nodal_diameter : int
            The diameter of the coordinates.
        """
        G = sp.csc_array(functional)
        g_m, g_s = G[:, self.masters].toarray(), G[:, self.slaves].toarray()
        K_sm = self.model.K.tocsc()[self.slaves][:, self.masters]
        row_m = g_m - (K_sm.T @ self._solve(g_s.T)).T
        rows = np.hstack([row_m, g_s @ self.component.fixed_modes])
        basis = self.component.at(nodal_diameter).basis
        return np.asarray(rows if basis is None else rows @ basis)

    def strain(
        self, coordinates: NDArray[np.complex128], nodal_diameter: int, sector: int = 0
    ) -> NDArray[np.complex128]:
        """Strain at the nodes, (nodes, 6) or (nodes, 6, k), see `fem.strain`."""
        return fields.strain(self, coordinates, nodal_diameter, sector)

    def stress(
        self, coordinates: NDArray[np.complex128], nodal_diameter: int, sector: int = 0
    ) -> NDArray[np.complex128]:
        """Stress at the nodes, Pa, (nodes, 6) or (nodes, 6, k), see `fem.stress`."""
        return fields.stress(self, coordinates, nodal_diameter, sector)

    def rows(self, functional: Any, nodal_diameter: int, sector: int = 0) -> NDArray[np.complex128]:
        """Rows (g, n) such that rows @ coordinates are functionals (g, 3·nodes), such as gauges.

        One solve a functional serves every point of a response.
        """
        return fields.rows(self, functional, nodal_diameter, sector)

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
