"""How the amplitude of an output at one frequency changes with all that the system is made of.

With w = W(u), u = ũ + R̂ w, J = dW/du and P = I - J R̂, an amplitude A that depends on w by g =
dA/dw changes with ũ by

    dA/dũ = Jᵀ y,      Pᵀ y = g,

one linear solution for all parameters. What pushes the structure with modal forces f_h moves its
motion at fixed w, and ũ with it; together A changes by Re Σ_h p_h f_h. So count

    a load             its modal force,
    a stiffness dK     -dK x of each harmonic's motion x,
    a spring dk        -bᴴ dk (u - w) of the contact with rows b,
    modal damping      -i s (dD) x;  with D M⁻¹ D = 4ζ² K a stiffness adds, in modes of
                       frequencies ω, dD_ij = 2ζ dK_ij / (ω_i + ω_j),
    interference       v₀ of ũ, and -bᴴ K_c v₀; assembled sliders the same with the other sign.

Sliders follow friction through the bound α v, α = μ kn/kt, alone: α dW/dα = (dW/dv) v, whose share
of A is yᵀ dW/dα. Where the static balance is solved first, A follows ũ and α of the state at rest,
too, by a second, small solution.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats
from vanelock.nonlinear.balance.balance import Balance, Structure
from vanelock.nonlinear.balance.stuck_modes import StuckModes
from vanelock.nonlinear.contact.law import STUCK
from vanelock.nonlinear.continuation.families import fixed
from vanelock.nonlinear.forced_response.options import PreparedSystem, options_of, static_part
from vanelock.nonlinear.forced_response.response import Response, check_contacts, extremes
from vanelock.nonlinear.fourier import TURN, to_complex, to_real
from vanelock.nonlinear.newton.linearised import newton_matrix
from vanelock.nonlinear.newton.newton import Solution, active_rows, solve
from vanelock.rom.system.system import System


@dataclass(frozen=True)
class AmplitudeGradient:
    """What moves the amplitude A of an output at a solution, its frequency held.

    Attributes
    ----------
    structure : Structure
    omega : float
        rad/s.
    amplitude : float
        A, half the peak-to-peak, m.
    motion : tuple of (n_h,)
        Modal amplitudes of each harmonic; of harmonic 0, those at rest where that is solved first.
    stretch : (H + 1, c, 3) complex
        u - w of the contacts' springs in each harmonic, m.
    by_push : tuple of (n_h,)
        A changes by the real part of these times modal forces of each harmonic.
    by_linear : (c, 3, 2H + 1) float
        dA/dũ.
    by_bound : (c, 2) float
        α dA/dα, m.
    """

    structure: Structure
    omega: float
    amplitude: float
    motion: tuple[Array, ...]
    stretch: Complex
    by_push: tuple[Array, ...]
    by_linear: Floats
    by_bound: Floats

    def by_force(self) -> float:
        """dA, m, by a factor of the excitation, all harmonics h >= 1 alike."""
        prepared = self.structure
        pushes = ((h, prepared.modal_force(h, self.omega)) for h in range(1, len(self.by_push)))
        return float(sum((self.by_push[h] @ push).real for h, push in pushes))

    def by_rest_force(self) -> float:
        """dA, m, by a factor of the loads at rest."""
        prepared = self.structure
        push = prepared.unit_forces.get(0)
        if push is None:
            return 0.0
        return float(self.by_push[0].real @ push * prepared.growth(0, self.omega))

    def by_damping(self) -> float:
        """dA/dζ, m, by the modal damping ratio of the structure."""
        found = 0.0
        for h in range(1, len(self.by_push)):
            modes = self.structure.at(h)
            each = 2 * np.sqrt(modes.static * modes.compliance) * self.motion[h]
            each[: modes.rigid] = 0.0
            found += h * self.omega * float((self.by_push[h] @ each).imag)
        return found

    def by_interference(self) -> Floats:
        """(c,) dA/dv₀ of each contact's interference, m/m."""
        return self._by_offset[:, 0].copy()

    def by_slider(self) -> Floats:
        """(c, 2) dA/ds of the places at which sliders are assembled, m/m."""
        return -self._by_offset[:, 1:]

    def by_friction(self) -> Floats:
        """(c,) μ dA/dμ of each contact, m; zero without friction."""
        return np.asarray(self.by_bound.sum(axis=1))

    def by_contact_stiffness(self) -> Floats:
        """(c, 3) dA/d(kn, kt1, kt2) of each contact, m²/N; zero of elements with other laws."""
        contacts = self.structure.system.contacts
        found = np.zeros((contacts.count, 3))
        for h, by_push in enumerate(self.by_push):
            modes = self.structure.at(h)
            by_contact = (by_push @ modes.pull).reshape(found.shape)
            found -= (by_contact * self.stretch[h]).real
            if h and self.structure.system.damping_ratio:
                found += self._by_spring_damping(h).reshape(found.shape)
        found[:, 0] += self.by_bound.sum(axis=1) / contacts.kn
        found[:, 1:] -= self.by_bound / contacts.kt
        return np.where(contacts.springs[:, None], found, 0.0)

    def by_stiffness(self, changes: Mapping[int, Array]) -> float:
        """dA, m, by small changes of the stiffness, see `modal_stiffness`."""
        return self.by_modal_stiffness(modal_stiffness(self.structure, changes))

    def by_modal_stiffness(self, modal: Mapping[int, Array]) -> float:
        """dA, m, by small changes of the modal stiffness (n_h, n_h) of each harmonic."""
        found, ratio = 0.0, self.structure.system.damping_ratio or 0.0
        for h, change in modal.items():
            modes, motion = self.structure.at(h), self.motion[h]
            push = change @ motion
            if h and ratio:
                F = modes.added_damping
                each = (change @ (F * motion[:, None])) * F
                push = push + 2j * ratio * h * self.omega * each.sum(axis=1)
            found -= float((self.by_push[h] @ (push if h else push.real)).real)
        return found

    @cached_property
    def _by_offset(self) -> Floats:
        """(c, 3) dA by the offsets v₀ of ũ."""
        prepared = self.structure
        pushed = (self.by_push[0] @ prepared.at(0).pull).real * prepared.stiffness
        return np.asarray(self.by_linear[:, :, 0] - pushed.reshape(-1, 3))

    def _by_spring_damping(self, harmonic: int) -> Floats:
        """(3c,) dA by the modal damping that comes with a contact's spring of 1 N/m."""
        modes = self.structure.at(harmonic)
        F, ratio = modes.added_damping, self.structure.system.damping_ratio or 0.0
        left = modes.pull.T @ (F * self.by_push[harmonic][:, None])
        right = modes.rows @ (F * self.motion[harmonic][:, None])
        found = (left * right).sum(axis=1).imag
        found[modes.opened] = 0.0
        return np.asarray(2 * ratio * harmonic * self.omega * found)


def modal_stiffness(prepared: Structure, changes: Mapping[int, Array]) -> dict[int, Array]:
    """Changes of the stiffness by harmonic, in its modes."""
    found: dict[int, Array] = {}
    known: dict[int, Array] = {}
    for h, k in enumerate(prepared.nodal_diameters):
        change = changes.get(k)
        if change is None and (mirrored := changes.get(-k % prepared.system.sectors)) is not None:
            change = mirrored.conj()
        if change is None:
            continue
        shapes = prepared.at(h).shapes
        if id(shapes) not in known:
            known[id(shapes)] = shapes.conj().T @ (change @ shapes)
        found[h] = known[id(shapes)]
    return found


def amplitude_gradient(
    ready: PreparedSystem, solution: Solution, component: tuple[int, int], held: bool = False
) -> AmplitudeGradient | None:
    """What moves the amplitude of an output at a solution; None where the solutions fold.

    Parameters
    ----------
    ready : PreparedSystem
    solution : Solution
        Converged.
    component : (int, int)
        Output node and direction.
    held : bool
        Whether sliders that stick for good stay, wherever they first slid to, as bounds over
        static friction have it. By themselves they slide on with what first moved them.
    """
    prepared, rest, omega = ready.structure, ready.rest, solution.omega
    balance = ready.solver.family.at(omega)
    motion = prepared.amplitudes(omega, solution.w)
    amplitude, by_motion = _by_motion(prepared, motion, component)
    pushed = [_transposed(prepared.at(h), h * omega, row) for h, row in enumerate(by_motion)]
    form = np.zeros((len(prepared.stiffness), solution.w.shape[2]))
    for h, push in enumerate(pushed):
        if h:  # the mean counts at both extremes
            by_w = (push @ prepared.at(h).pull) * prepared.stiffness
            form[:, 2 * h - 1], form[:, 2 * h] = by_w.real, -by_w.imag
    found = _through_law(balance, solution, form.reshape(solution.w.shape), held)
    if found is None:
        return None
    by_linear, by_bound = found
    stretch = to_complex((solution.u - solution.w).reshape(-1, solution.w.shape[2]))
    if rest is not None:  # what holds the mean depends on ũ at rest
        still = static_part(prepared)
        balance, mean = still.balance(0.0), by_linear[:, :, :1]
        by_rest = balance.columns.all(0).real.T @ mean.reshape(-1)
        at_rest = _through_law(balance, rest, by_rest.reshape(mean.shape), held)
        if at_rest is None:
            return None
        by_linear[:, :, :1] += at_rest[0]
        by_bound = by_bound + at_rest[1]
        motion[0] = still.amplitudes(0.0, rest.w)[0]
        stretch[0] = (rest.u - rest.w).reshape(-1)
    contacts = to_complex(by_linear.reshape(len(prepared.stiffness), -1)).conj()
    by_push = []
    for h, push in enumerate(pushed):
        moved = _transposed(prepared.at(h), h * omega, contacts[h] @ prepared.at(h).rows)
        by_push.append(push + moved if h else moved.real)
    stretch = stretch.reshape(len(motion), -1, 3)
    return AmplitudeGradient(
        prepared, omega, amplitude, tuple(motion), stretch, tuple(by_push), by_linear, by_bound
    )


def _through_law(
    balance: Balance, solution: Solution, form: Floats, held: bool
) -> tuple[Floats, Floats] | None:
    """Jᵀ y, (c, 3, m), and yᵀ α dW/dα, (c, 2), with Pᵀ y = form (c, 3, m); None if singular."""
    deviation, (count, _, m) = solution.deviation, form.shape
    found, by_bound = np.zeros(form.shape), np.zeros((count, 3))
    rows = active_rows(solution.w, deviation)
    if held:
        rows = rows[deviation.state[rows // (3 * m)] != STUCK]
    if not len(rows):
        return found, by_bound[:, 1:]
    try:
        matrix = newton_matrix(balance, deviation, rows)
        y = np.linalg.solve(matrix.T, form.reshape(-1)[rows])
    except np.linalg.LinAlgError:
        return None
    whole = np.zeros(form.size)
    whole[rows] = y
    by_law = np.einsum("cia,ciajb->cijb", whole.reshape(form.shape), deviation.jacobian)
    by_bound = np.einsum("cib,cb->ci", by_law[:, :, 0], solution.u[:, 0])
    return by_law.sum(axis=1), by_bound[:, 1:]


def _by_motion(
    prepared: Structure, motion: list[Array], component: tuple[int, int]
) -> tuple[float, list[Array]]:
    """A = (q(θ₁) - q(θ₂)) / 2 at the extremes, and rows (n_h,) by which it follows the motion."""
    rows = [each[component] for each in prepared.output_rows]
    q = np.array([row @ amplitude for row, amplitude in zip(rows, motion, strict=True)])
    angles = extremes(q[:, None])[:, 0]
    shares = np.exp(1j * np.outer(np.arange(len(rows)), angles)) @ [0.5, -0.5]
    amplitude = float((shares @ q).real)
    return amplitude, [share * row for share, row in zip(shares, rows, strict=True)]


def _transposed(modes: StuckModes, s: float, row: Array) -> Array:
    """A row (n,) times the inverse of the modal dynamic stiffness at s, rad/s."""
    if modes.springs is None and modes.coupled_damping is None:  # diagonal
        return modes.solve(s, row)
    return modes.solve(-s, row.conj()[:, None])[:, 0].conj()  # D(s)ᴴ = D(-s)


def prepared_again(
    system: System, response: Response, modes: Mapping[int, StuckModes] | None = None
) -> PreparedSystem:
    """The system of a response ready to be solved as that was, its own friction included."""
    check_contacts(response, system.contacts)
    system = replace(system, contacts=replace(system.contacts, mu=response.mu))
    return options_of(system, response).prepare(system, response.frequency, 1, modes)


def solution_at(ready: PreparedSystem, response: Response, point: int) -> Solution:
    """A point of a response solved again from where it is."""
    omega, solver = TURN * float(response.frequency[point]), ready.solver
    begin = to_real(response.contact[point] - response.force[point] / response.stiffness)
    if ready.rest is not None:  # what is in the mean is the static problem's
        begin[:, :, 0] = 0.0
    held = fixed(solver.family.at(omega), solver.family.friction)
    return replace(solve(held, begin, 0.0, tolerance=ready.options.tolerance), parameter=omega)
