"""From reduced coordinates back to the displacement, strain and stress of every node."""

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Complex
from vanelock.common.errors import InputError
from vanelock.common.process.memory import latest
from vanelock.fem import Model, factorise
from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import Solve
from vanelock.rom.full_fields import fields
from vanelock.rom.routes.condensed import Condensed, condensed
from vanelock.rom.routes.problem import Problem, problem
from vanelock.rom.system.system import Matrix

KEPT = 2
"""Nodal diameters whose factors of the faces are kept: that of rest and another."""


@dataclass(frozen=True)
class Statics:
    """How a part follows its masters statically at a nodal diameter.

    Attributes
    ----------
    solve : callable
        K_ss⁻¹ b.
    K_sm : (s, m) sparse
        Stiffness between slaves and masters.
    masters, slaves : (n, m), (n, s) sparse
        The part's free dofs from those of masters and of slaves.
    """

    solve: Solve
    K_sm: sp.csr_array
    masters: sp.csr_array
    slaves: sp.csr_array


@dataclass(frozen=True)
class Recovery:
    """Displacement fields of one part, computed when asked for.

    Constraint modes are not stored: a field costs one solve with the part's stiffness, its masters
    held, which is factorised once for all nodal diameters, when it is first needed.

    Attributes
    ----------
    component : Component
        The reduced part.
    problem : Problem
        What was reduced.
    """

    component: Component
    problem: Problem
    _statics: dict[int, Statics] = field(default_factory=dict, repr=False)
    _shared: list[Condensed] = field(default_factory=list, repr=False)

    @property
    def model(self) -> Model:
        """The model that was reduced."""
        return self.problem.model

    def displacement(self, coordinates: Array, nodal_diameter: int, sector: int = 0) -> Complex:
        """Cartesian displacement of each node of a sector, (nodes, 3) or (nodes, 3, k), m.

        Parameters
        ----------
        coordinates : (n,) or (n, k)
            Reduced coordinates, in columns.
        nodal_diameter : int
            The diameter at which they are.
        sector : int
            The sector, see `vanelock.rom.full_fields.fields`; coordinates are those of sector 0.
        """
        q = np.asarray(coordinates)
        name, size = self.component.masters.part, self.component.size
        if len(q) != size:
            raise InputError(f"{name}: {len(q)} coordinates given, it has {size}")
        basis = self.component.at(nodal_diameter).basis
        x = q.reshape(size, -1) if basis is None else basis @ q.reshape(size, -1)
        masters = len(x) - self.component.fixed_modes
        part = self.statics(nodal_diameter)
        x_s = self._vectors(nodal_diameter) @ x[masters:] - part.solve(part.K_sm @ x[:masters])
        free = part.masters @ x[:masters] + part.slaves @ x_s
        u = self.problem.field(np.asarray(free, complex)).reshape(
            *self.model.dofs.shape, *q.shape[1:]
        )
        return fields.in_sector(u, nodal_diameter, self.model.part.sectors, sector)

    def adjoint(self, functional: Any, nodal_diameter: int) -> Complex:
        """Rows (g, n) in reduced coordinates of linear functionals of sector 0's displacements.

        Parameters
        ----------
        functional : (g, free dofs) sparse
            Rows on the model's free dofs.
        nodal_diameter : int
            The diameter of the coordinates.
        """
        part, G = self.statics(nodal_diameter), sp.csr_array(functional)
        if self.problem.means is not None:
            G = sp.csr_array(G @ self.problem.means)
        g_s = (G @ part.slaves).toarray()
        follow = part.solve(g_s.conj().T).conj().T
        row_m = (G @ part.masters).toarray() - follow @ part.K_sm
        rows = np.hstack([row_m, g_s @ self._vectors(nodal_diameter)])
        basis = self.component.at(nodal_diameter).basis
        return np.asarray(rows if basis is None else rows @ basis)

    def strain(self, coordinates: Complex, nodal_diameter: int, sector: int = 0) -> Complex:
        """Strain at the nodes, (nodes, 6) or (nodes, 6, k), see `fem.strain`."""
        return fields.strain(self, coordinates, nodal_diameter, sector)

    def stress(
        self,
        coordinates: Complex,
        nodal_diameter: int,
        sector: int = 0,
        growth: ArrayLike | None = None,
    ) -> Complex:
        """Stress at the nodes, Pa, (nodes, 6) or (nodes, 6, k), see `fem.stress`.

        Thermal strain `growth`, one number or (nodes,), is taken off: give it for the motion at
        rest, of which heat is a load.
        """
        return fields.stress(self, coordinates, nodal_diameter, sector, growth)

    def rows(self, functional: Any, nodal_diameter: int, sector: int = 0) -> Complex:
        """Rows (g, n) such that rows @ coordinates are functionals (g, 3·nodes), such as gauges.

        One solve a functional serves every point of a response.
        """
        return fields.rows(self, functional, nodal_diameter, sector)

    def statics(self, nodal_diameter: int) -> Statics:
        """The part at a nodal diameter, its masters held."""
        cyclic = self.component.route == "cyclic"
        k = nodal_diameter % self.model.part.sectors if cyclic else 0
        made = partial(self._sector, k) if cyclic else self._piece
        return latest(self._statics, k, made, KEPT)

    def _vectors(self, nodal_diameter: int) -> Matrix:
        found = self.component.at(nodal_diameter).vectors
        found = self.component.vectors if found is None else found
        if found is None:
            raise InputError(f"{self.component.masters.part}: it holds no fixed-interface vectors")
        return found

    def _piece(self) -> Statics:
        """The part by itself; its cyclic faces are masters where it has them."""
        given, n = self.problem, self.problem.K.shape[0]
        m = given.boundary_rows
        s = np.setdiff1d(np.arange(n), m)
        K_s = given.K[s]
        unit = sp.eye_array(n, format="csc")
        factor = self._shared[0].interior if self._shared else factorise(K_s[:, s].tocsc())
        return Statics(factor.solve, K_s[:, m].tocsr(), unit[:, m].tocsr(), unit[:, s].tocsr())

    def _sector(self, nodal_diameter: int) -> Statics:
        """The sector at a nodal diameter, its right face following the left one."""
        if not self._shared:
            self._shared.append(condensed(self.problem))
        (shared,) = self._shared
        given = self.problem
        T = shared.transform(nodal_diameter)
        unit = sp.eye_array(given.K.shape[0], format="csc")
        K_sm = sp.csr_array(T.conj().T @ given.K[:, given.rows])
        held = shared.held(nodal_diameter)
        return Statics(held.solve, K_sm, unit[:, given.rows].tocsr(), T.tocsr())


def recovery(component: Component, model: Model, prepared: Condensed | None = None) -> Recovery:
    """Prepare the recovery of a part's displacement fields.

    Parameters
    ----------
    component : Component
        The reduced part.
    model : fem.Model
        What was reduced, with the modulus that the component has.
    prepared : Condensed, optional
        What it was reduced from by `rom.prepare`, which is then not computed again.
    """
    if prepared is not None:  # of whatever modulus: how slaves follow does not depend on it
        return Recovery(component, replace(prepared.problem, model=model), _shared=[prepared])
    return Recovery(component, problem(model, component.masters, component.cyclic))
