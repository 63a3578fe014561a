"""A-posteriori errors of a reduced model, from residuals, without a reference solution.

A reduced part answers its masters' static loads exactly, so for reduced coordinates q = (x_m, η) at
the eigenvalue θ = ω² (of a mode, or of a forced response) the residual lies on the slaves alone,

    r = K B η - θ (L x_m + M B η),

and the strain energy of its static answer,

    ε(q, θ) = rᴴ K_ss⁻¹ r = qᴴ (G₀ - θ G₁ + θ² G₂) q,

is what the slaves would still give way by. Three dense matrices of the part's own hold it for
every structure that the part is joined to: no sparse matrix is touched again. For a Ritz pair of
unit mass the eigenvalue is too large by ε/(1 - θ/Ω²), Ω the first fixed-interface frequency that
may be left out, up to terms of higher order; pairs that lie close act on one another by the same
form. For the displacement aᴴx under a load f, with z the reduced answer to the load a, the error is
the form between the two, zᴴ(...)q.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.rom.component import Component, Reduced
from vanelock.rom.errors.neglected import Neglected
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.joining.linear_modes import linear_damping, linear_modes, linear_stiffness
from vanelock.rom.joining.vane_and_casing import joined_dofs
from vanelock.rom.system.system import Matrix, System

BEYOND = 5
"""Modes beyond those asked for that may act on them."""
ROUND_OFF = 1e-13
"""Of the largest ratio of a coordinate's stiffness to its mass: an ω² below it is zero."""


@dataclass(frozen=True)
class FrequencyErrors:
    """Frequencies of a joined model and their estimated errors.

    Attributes
    ----------
    frequency : (count,) float
        Hz, ascending; each too high.
    vane, casing : (count,) float
        Relative error that each part's reduction causes; infinite above the frequency up to which
        it keeps all fixed-interface modes.
    """

    frequency: NDArray[np.float64]
    vane: NDArray[np.float64]
    casing: NDArray[np.float64]

    @property
    def total(self) -> NDArray[np.float64]:
        """(count,) relative error."""
        return self.vane + self.casing


def frequency_errors(
    system: System,
    vane: Component,
    casing: Component,
    nodal_diameter: int,
    count: int,
    closed: NDArray[np.bool_] | None = None,
) -> FrequencyErrors:
    """Estimated errors of the lowest natural frequencies.

    Parameters
    ----------
    system : System
        The joined parts.
    vane, casing : Component
        The parts that were joined.
    nodal_diameter, count, closed
        As for `linear_modes`.

    Raises
    ------
    InputError
        If a part was reduced by a route that gives no estimate of what it leaves out.
    """
    matrices = system.at(nodal_diameter)
    n = len(matrices.K)
    if not 1 <= count <= n:
        raise InputError(f"{count} modes of a system of {n} coordinates")
    beyond = min(n, count + BEYOND)
    frequency, shapes = linear_modes(system, nodal_diameter, beyond, closed)
    squared = (2 * np.pi * frequency) ** 2
    highest = np.max(np.diagonal(matrices.K).real / np.diagonal(matrices.M).real)
    squared[squared < ROUND_OFF * highest] = 0  # rigid-body motions, which every part has exactly
    shares, lowered = np.zeros((2, count)), np.zeros(count)
    for j in range(count):
        if squared[j] == 0:
            continue
        missing = []
        for part, dofs in _places(vane, casing):
            reduced, q = part.at(nodal_diameter), shapes[dofs]
            form = q.conj().T @ (_form(part, reduced, squared[j]) @ q)
            if reduced.complete and frequency[j] < reduced.complete:
                missing.append(form / (1 - (frequency[j] / reduced.complete) ** 2))
            else:  # a mode below this one may be left out
                missing.append(np.full_like(form, np.inf))
        shares[:, j] = [max(form[j, j].real, 0.0) for form in missing]
        lowered[j] = _lowered(squared, np.sum(missing, axis=0), j)
    errors = np.zeros((2, count))
    for i in np.flatnonzero(squared[:count]):
        alone = shares[:, i] / (2 * squared[i])
        together = max((squared[i] - lowered[i]) / (2 * squared[i]), 0.0)
        finite = 0 < alone.sum() < np.inf
        errors[:, i] = alone / alone.sum() * together if finite else alone
    return FrequencyErrors(frequency[:count], *errors)


def _lowered(squared: NDArray[np.float64], missing: Matrix, j: int) -> float:
    """Eigenvalue j of the modes' stiffness without what gives way; close modes act together."""
    if not np.all(np.isfinite(missing)):
        return -np.inf
    return float(sl.eigvalsh(np.diag(squared) - hermitian(missing))[j])


def response_errors(
    system: System,
    vane: Component,
    casing: Component,
    frequencies: NDArray[np.float64],
    closed: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Linear response of the first harmonic at the outputs, and its estimated error.

    Parameters
    ----------
    system, vane, casing, closed
        As for `frequency_errors`.
    frequencies : (p,) float
        Hz.

    Returns
    -------
    output, error : (p, o, 3) complex
        Displacements of the output nodes, m, and by how much each is in error: the true one is
        about output + error.
    """
    k = system.nodal_diameter(1)
    matrices = system.at(k)
    if matrices.output is None:
        raise InputError("response_errors: the system has no output nodes")
    n = len(matrices.K)
    C = linear_damping(system, k)
    K, outputs = linear_stiffness(system, k, closed), matrices.output.reshape(-1, n)
    found, errors = [], []
    for omega in 2 * np.pi * np.asarray(frequencies):
        D = K - omega**2 * matrices.M + 1j * omega * C
        factor = sl.lu_factor(D)
        x = sl.lu_solve(factor, system.force[1].at(omega))
        z = sl.lu_solve(factor, outputs.conj().T, trans=2)
        error = np.zeros(len(outputs), complex)
        for part, dofs in _places(vane, casing):
            reduced = part.at(k)
            error += z[dofs].conj().T @ (_form(part, reduced, omega**2) @ x[dofs])
        found.append(outputs @ x)
        errors.append(error)
    shape = (len(found), *matrices.output.shape[:2])
    return np.array(found).reshape(shape), np.array(errors).reshape(shape)


def neglected_forms(vane: Component, casing: Component, nodal_diameter: int) -> Neglected:
    """What the reductions of two parts leave out of the model that they are joined to.

    Raises
    ------
    InputError
        If a part was reduced by a route that gives no estimate of what it leaves out.
    """
    parts = []
    for part, dofs in _places(vane, casing):
        reduced = part.at(nodal_diameter)
        _form(part, reduced, 0.0)
        assert reduced.neglected is not None
        parts.append((dofs, reduced.neglected, 2 * np.pi * (reduced.complete or 0.0)))
    return Neglected(tuple(parts))


def _places(
    vane: Component, casing: Component
) -> tuple[tuple[Component, NDArray[np.int64]], tuple[Component, NDArray[np.int64]]]:
    """Each part and its place among the joined coordinates."""
    return (vane, joined_dofs(vane, casing)), (casing, np.arange(casing.size))


def _form(part: Component, reduced: Reduced, squared: float) -> Matrix:
    """G₀ - θ G₁ + θ² G₂."""
    if reduced.neglected is None:
        raise InputError(
            f'{part.masters.part}: reduced by the route "{part.route}", which gives no estimate '
            'of what it leaves out: reduce by the route "cyclic"'
        )
    G0, G1, G2 = reduced.neglected
    return np.asarray(G0 - squared * G1 + squared**2 * G2)
