"""From reduced coordinates to the displacement, strain and stress of every node of any sector.

Sector j moves as sector 0 turned by 2πj/N about the engine axis and later by the phase j φ,
φ = 2π ND/N: u_j = R_z(2πj/N) u_0 e^{-ijφ}, and so do strain and stress. A functional that is
attached to the part, such as a strain gauge, turns with it and takes the phase alone.
"""

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from vanelock import fem
from vanelock.common.arrays import Array, Complex
from vanelock.common.cyclic import phase_factor, turn
from vanelock.common.errors import InputError
from vanelock.common.process import latest
from vanelock.fem import Model, factorise
from vanelock.rom.component import Component
from vanelock.rom.fixed_interface.held import Solve
from vanelock.rom.routes.condensed import Condensed, condensed
from vanelock.rom.routes.problem import Problem, problem
from vanelock.rom.system.system import Matrix

_KEPT = 2  # nodal diameters whose factors of the faces are kept: that of rest and another


@dataclass(frozen=True)
class _Statics:
    """How a part follows its masters statically at a nodal diameter."""

    solve: Solve  # K_ss⁻¹ b
    K_sm: sp.csr_array  # (s, m), stiffness between slaves and masters
    masters: sp.csr_array  # (n, m)
    slaves: sp.csr_array  # (n, s)


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
    _statics: dict[int, _Statics] = field(default_factory=dict, repr=False)
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
            The sector, see `vanelock.rom.full_fields`; coordinates are those of sector 0.
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
        sectors = self.model.part.sectors
        phase = phase_factor(nodal_diameter * sector, sectors)
        return np.asarray(np.einsum("ij,nj...->ni...", turn(sectors, sector) * phase, u))

    def strain(self, coordinates: Complex, nodal_diameter: int, sector: int = 0) -> Complex:
        """Strain at the nodes, (nodes, 6) or (nodes, 6, k), see `fem.strain`.

        On the faces that neighbouring sectors share, the neighbour's elements count as well.
        """
        found = self._strain(coordinates, nodal_diameter)
        return self._turned(found, nodal_diameter, sector, shear=2.0)

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
        elastic = self._strain(coordinates, nodal_diameter, growth)
        found = fem.hooke(self.model.material, elastic)
        return self._turned(found, nodal_diameter, sector, shear=1.0)

    def rows(self, functional: Any, nodal_diameter: int, sector: int = 0) -> Complex:
        """Rows (g, n) such that rows @ coordinates are functionals (g, 3·nodes), such as gauges.

        One solve a functional serves every point of a response.
        """
        part, G = self.statics(nodal_diameter), _on_free_dofs(self.model, functional)
        if self.problem.means is not None:
            G = sp.csr_array(G @ self.problem.means)
        g_s = (G @ part.slaves).toarray()
        follow = part.solve(g_s.conj().T).conj().T
        row_m = (G @ part.masters).toarray() - follow @ part.K_sm
        rows = np.hstack([row_m, g_s @ self._vectors(nodal_diameter)])
        basis = self.component.at(nodal_diameter).basis
        phase = phase_factor(nodal_diameter * sector, self.model.part.sectors)
        return np.asarray(phase * (rows if basis is None else rows @ basis))

    def _strain(
        self, coordinates: Complex, nodal_diameter: int, growth: ArrayLike | None = None
    ) -> Complex:
        part = self.model.part
        u = self.displacement(coordinates, nodal_diameter)
        total, volume = fem.strain_sums(part, u, growth)
        if self.component.cyclic:
            # right[i] of this sector is left[i] of the next, where the field is turned and delayed.
            left, right = part.nodes("left"), part.nodes("right")
            off_axis = left != right
            left, right = left[off_axis], right[off_axis]
            phase = phase_factor(nodal_diameter, part.sectors)
            ahead, behind = turn(part.sectors), turn(part.sectors, -1)
            at_left = total[left] + fem.turned(total[right], behind, shear=2.0) / phase
            total[right] = fem.turned(at_left, ahead, shear=2.0) * phase
            total[left] = at_left
            volume[left] = volume[right] = volume[left] + volume[right]
        return np.asarray(total / volume.reshape(-1, *(1,) * (total.ndim - 1)))

    def _turned(self, tensors: Complex, nodal_diameter: int, sector: int, shear: float) -> Complex:
        sectors = self.model.part.sectors
        phase = phase_factor(nodal_diameter * sector, sectors)
        return np.asarray(phase * fem.turned(tensors, turn(sectors, sector), shear))

    def statics(self, nodal_diameter: int) -> _Statics:
        """The part at a nodal diameter, its masters held."""
        cyclic = self.component.route == "cyclic"
        k = nodal_diameter % self.model.part.sectors if cyclic else 0
        made = partial(self._sector, k) if cyclic else self._piece
        return latest(self._statics, k, made, _KEPT)

    def _vectors(self, nodal_diameter: int) -> Matrix:
        found = self.component.at(nodal_diameter).vectors
        found = self.component.vectors if found is None else found
        if found is None:
            raise InputError(f"{self.component.masters.part}: it holds no fixed-interface vectors")
        return found

    def _piece(self) -> _Statics:
        """The part by itself; its cyclic faces are masters where it has them."""
        given, n = self.problem, self.problem.K.shape[0]
        m = given.boundary_rows
        s = np.setdiff1d(np.arange(n), m)
        K_s = given.K[s]
        unit = sp.eye_array(n, format="csc")
        factor = self._shared[0].interior if self._shared else factorise(K_s[:, s].tocsc())
        return _Statics(factor.solve, K_s[:, m].tocsr(), unit[:, m].tocsr(), unit[:, s].tocsr())

    def _sector(self, nodal_diameter: int) -> _Statics:
        """The sector at a nodal diameter, its right face following the left one."""
        if not self._shared:
            self._shared.append(condensed(self.problem))
        (shared,) = self._shared
        given = self.problem
        T = shared.transform(nodal_diameter)
        unit = sp.eye_array(given.K.shape[0], format="csc")
        K_sm = sp.csr_array(T.conj().T @ given.K[:, given.rows])
        held = shared.held(nodal_diameter)
        return _Statics(held.solve, K_sm, unit[:, given.rows].tocsr(), T.tocsr())


def _on_free_dofs(model: Model, functional: Any) -> sp.csr_array:
    """Rows (g, 3·nodes) on all nodes' displacements as rows on a model's free dofs, (g, free)."""
    dofs = model.dofs.ravel()
    free = np.flatnonzero(dofs >= 0)
    spread = sp.csr_array(
        (np.ones(len(free)), (free, dofs[free])), shape=(len(dofs), model.K.shape[0])
    )
    return sp.csr_array(sp.csr_array(functional) @ spread)


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
