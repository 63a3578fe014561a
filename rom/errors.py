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

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.linalg as sl

from vanelock.common.arrays import Booleans, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.rom.component import Reduced
from vanelock.rom.fixed_interface.held import hermitian
from vanelock.rom.joining.linear_modes import linear_damping, linear_modes, linear_stiffness
from vanelock.rom.system.system import Matrix, System

_BEYOND = 5  # modes beyond those asked for that may act on them
_ROUND_OFF = 1e-13
"""Of the largest ratio of a coordinate's stiffness to its mass: an ω² below it is zero."""


@dataclass(frozen=True)
class Neglected:
    """By how much a joined model at one nodal diameter is too stiff, see `errors.frequency_errors`.

    Attributes
    ----------
    parts : tuple of ((m,) int, (3, m, m), float)
        For each part its place among the joined coordinates, its forms G, and the circular
        frequency up to which it keeps all fixed-interface modes, rad/s.
    """

    parts: tuple[tuple[Integers, Matrix, float], ...]

    def force(self, omega: float, x: Matrix) -> Matrix:
        """Forces (n,) that the missing compliance amounts to at the joined coordinates (n,), N.

        Beyond a part's own limit the estimate is a guess: the nearest ten per cent stand for it.
        """
        total = np.zeros(len(x), complex)
        for dofs, (G0, G1, G2), complete in self.parts:
            q = x[dofs]
            pushed = G0 @ q - omega**2 * (G1 @ q) + omega**4 * (G2 @ q)
            near = max(abs(1 - (omega / complete) ** 2), _NEAR) if complete else _NEAR
            total[dofs] += pushed / near
        return total


class ReducedPart(Protocol):
    """What has matrices by nodal diameter, such as a `Component`."""

    def at(self, nodal_diameter: int) -> Reduced:
        """Those of one."""
        ...


@dataclass(frozen=True)
class FrequencyErrors:
    """Frequencies of a joined model and their estimated errors.

    Attributes
    ----------
    frequency : (count,) float
        Hz, ascending; each too high.
    parts : dict of str to (count,) float
        Relative error that each part's reduction causes; infinite above the frequency up to which
        it keeps all fixed-interface modes.
    """

    frequency: Floats
    parts: dict[str, Floats]

    @property
    def total(self) -> Floats:
        """(count,) relative error."""
        return np.asarray(sum(self.parts.values(), np.zeros(len(self.frequency))))


def frequency_errors(
    system: System,
    parts: Mapping[str, ReducedPart],
    nodal_diameter: int,
    count: int,
    closed: Booleans | None = None,
) -> FrequencyErrors:
    """Estimated errors of the lowest natural frequencies.

    Parameters
    ----------
    system : System
        The joined parts.
    parts : dict of str to Component
        Those of the parts that were joined whose reduction leaves something out.
    nodal_diameter, count, closed
        As for `linear_modes`.

    Raises
    ------
    InputError
        If a part was reduced by a route that gives no estimate of what it leaves out.
    """
    matrices = system.at(nodal_diameter)
    estimated = ((name, _estimated(name, part, nodal_diameter)) for name, part in parts.items())
    left_out = [(reduced, matrices.parts[name]) for name, reduced in estimated]
    n = len(matrices.K)
    if not 1 <= count <= n:
        raise InputError(f"{count} modes of a system of {n} coordinates")
    beyond = min(n, count + _BEYOND)
    frequency, shapes = linear_modes(system, nodal_diameter, beyond, closed)
    squared = (2 * np.pi * frequency) ** 2
    highest = np.max(np.diagonal(matrices.K).real / np.diagonal(matrices.M).real)
    squared[squared < _ROUND_OFF * highest] = 0  # rigid-body motions, which every part has exactly
    shares, lowered = np.zeros((len(parts), count)), np.zeros(count)
    for j in range(count):
        if squared[j] == 0:
            continue
        missing = []
        for reduced, dofs in left_out:
            q = shapes[dofs]
            form = q.conj().T @ (_form(reduced, squared[j]) @ q)
            if reduced.complete and frequency[j] < reduced.complete:
                missing.append(form / (1 - (frequency[j] / reduced.complete) ** 2))
            else:  # a mode below this one may be left out
                missing.append(np.full_like(form, np.inf))
        shares[:, j] = [max(form[j, j].real, 0.0) for form in missing]
        lowered[j] = _lowered(squared, np.sum(missing, axis=0), j)
    errors = np.zeros((len(parts), count))
    for i in np.flatnonzero(squared[:count]):
        alone = shares[:, i] / (2 * squared[i])
        together = max((squared[i] - lowered[i]) / (2 * squared[i]), 0.0)
        finite = 0 < alone.sum() < np.inf
        errors[:, i] = alone / alone.sum() * together if finite else alone
    return FrequencyErrors(frequency[:count], dict(zip(parts, errors, strict=True)))


def _lowered(squared: Floats, missing: Matrix, j: int) -> float:
    """Eigenvalue j of the modes' stiffness without what gives way; close modes act together."""
    if not np.all(np.isfinite(missing)):
        return -np.inf
    return float(sl.eigvalsh(np.diag(squared) - hermitian(missing))[j])


def response_errors(
    system: System,
    parts: Mapping[str, ReducedPart],
    frequencies: Floats,
    closed: Booleans | None = None,
) -> tuple[Complex, Complex]:
    """Linear response of the first harmonic at the outputs, and its estimated error.

    Parameters
    ----------
    system, parts, closed
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
        for name, part in parts.items():
            dofs = matrices.parts[name]
            error += z[dofs].conj().T @ (_form(_estimated(name, part, k), omega**2) @ x[dofs])
        found.append(outputs @ x)
        errors.append(error)
    shape = (len(found), *matrices.output.shape[:2])
    return np.array(found).reshape(shape), np.array(errors).reshape(shape)


def neglected_forms(
    system: System, parts: Mapping[str, ReducedPart], nodal_diameter: int
) -> Neglected:
    """What the reductions of some parts leave out of the system that they are joined to.

    Raises
    ------
    InputError
        If a part was reduced by a route that gives no estimate of what it leaves out.
    """
    found, places = [], system.at(nodal_diameter).parts
    for name, part in parts.items():
        reduced = _estimated(name, part, nodal_diameter)
        assert reduced.neglected is not None
        found.append((places[name], reduced.neglected, 2 * np.pi * (reduced.complete or 0.0)))
    return Neglected(tuple(found))


def _estimated(name: str, part: ReducedPart, nodal_diameter: int) -> Reduced:
    """A part's matrices, if it is known what they leave out."""
    reduced = part.at(nodal_diameter)
    if reduced.neglected is None:
        raise InputError(
            f"{name}: reduced by a route that gives no estimate of what it leaves out: reduce by "
            'the route "cyclic"'
        )
    return reduced


def _form(reduced: Reduced, squared: float) -> Matrix:
    """G₀ - θ G₁ + θ² G₂."""
    assert reduced.neglected is not None
    G0, G1, G2 = reduced.neglected
    return np.asarray(G0 - squared * G1 + squared**2 * G2)


_NEAR = 0.1  # least distance 1 - θ/Ω² from a left-out mode that estimates count with
