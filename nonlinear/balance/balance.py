"""The coupled balance of all harmonics, condensed to the contacts, around the stuck state.

In the contact displacements u, with w their deviation from sticking (`law`) and R̂ = B D̃⁻¹ Bᴴ K_c,

    u^(h) = ũ^(h) + R̂_h w^(h),      ũ^(h) = B D̃_h⁻¹ f^(h),
    ũ^(0) = v₀ + B₀ K̃₀⁻¹ (f^(0) - B₀ᴴ K_c v₀),

with v₀ the interference and, in the tangential directions, the assembled sliders' places reversed;
so the nonlinear equations are w = W(u(w)), one for each component of w that is not zero.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from vanelock.common.arrays import Array, Complex, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.receptance_columns import Columns, passed
from vanelock.nonlinear.balance.stuck_modes import StuckModes, stuck_modes
from vanelock.nonlinear.fourier import to_complex, to_real
from vanelock.rom.system.coordinates import check
from vanelock.rom.system.system import System

_Compute: TypeAlias = Callable[[Integers], Array]


@dataclass(frozen=True)
class Balance:
    """The balance at one frequency.

    `omega`: excitation's circular frequency, rad/s; `linear` (c, 3, 2H + 1): ũ, relative
    displacements with all contacts stuck, m; `columns`: R̂_h, (3c, 3c), for h = 0 ... H.
    """

    omega: float
    linear: Floats
    columns: Columns

    def with_mean(self, mean: Floats) -> "Balance":
        """The balance whose mean displacement is held at (c, 3), m, whatever the contacts do."""
        linear = self.linear.copy()
        linear[:, :, 0] = mean
        size = self.columns.size
        compute = (
            lambda frequencies: np.zeros((len(frequencies), size)),
            *self.columns.compute[1:],
        )
        return replace(self, linear=linear, columns=Columns(size, compute))

    def with_harmonics(self, harmonics: int) -> "Balance":
        """The balance of the first harmonics alone."""
        linear = self.linear[:, :, : 2 * harmonics + 1].copy()
        columns = Columns(self.columns.size, self.columns.compute[: harmonics + 1])
        return replace(self, linear=linear, columns=columns)

    def displacement(self, w: Floats) -> Floats:
        """U = ũ + R̂ w, (c, 3, 2H + 1)."""
        return self.linear + self.moved(w)

    def moved(self, w: Floats) -> Floats:
        """R̂ w, (c, 3, 2H + 1)."""
        flat = w.reshape(-1, w.shape[2])
        components = np.flatnonzero(flat.any(axis=1))
        if not len(components):
            return np.zeros_like(w)
        columns = self.columns
        columns.hold(components)
        if 2 * len(components) > len(columns.components):
            components, held = columns.components, columns.held
        else:
            place = columns.place[components]
            held = [each[place] for each in columns.held]
        return passed(flat[components], held).reshape(w.shape)


@dataclass(frozen=True)
class Structure:
    """A system prepared for H harmonics: what does not depend on the frequency.

    `harmonics`: H; `nodal_diameters`: ND of each harmonic; `modes`: by nodal diameter; `cutoff`:
    rad/s; modes whose poles lie beyond h times this count by their static part in harmonic h.
    """

    system: System
    harmonics: int
    nodal_diameters: tuple[int, ...]
    modes: dict[int, StuckModes]
    cutoff: float = np.inf

    @property
    def structure(self) -> "Structure":
        """Itself, as of all that gives balances."""
        return self

    def at(self, harmonic: int) -> StuckModes:
        """Stuck modes of a harmonic."""
        return self._by_harmonic[harmonic]

    @cached_property
    def _by_harmonic(self) -> list[StuckModes]:
        every = [self.modes[k] for k in self.nodal_diameters]
        every[0] = every[0].at_rest
        if not np.isfinite(self.cutoff):
            return every
        cut = (modes.static_beyond(h * self.cutoff) for h, modes in enumerate(every) if h)
        return [every[0], *cut]

    def left_out(self, omega: float, w: Floats) -> Floats:
        """What the modes beyond the cutoff would add to the motion, w held, (c, 3, 2H + 1) m."""
        missed = [np.zeros(len(self.stiffness), complex)]
        for h, amplitude in enumerate(self.amplitudes(omega, w)[1:], 1):
            cut, full = self.at(h), self.modes[self.nodal_diameters[h]]
            ratio = cut.dynamic(h * omega) / full.dynamic(h * omega)
            missed.append(full.rows @ full.sprung(h * omega, amplitude * (ratio - 1)))
        return to_real(np.stack(missed)).reshape(w.shape)

    @cached_property
    def stiffness(self) -> Floats:
        """K_c, (3c,) N/m."""
        return self.system.contacts.stiffness.reshape(-1)

    @cached_property
    def _static_columns(self) -> Array:
        rows = self.at(0).rows
        return np.asarray((rows.conj() @ rows.T) * self.stiffness[:, None])

    @cached_property
    def _preload(self) -> Floats:
        """Modal force of the interference and of the assembled sliders."""
        offset = self.system.contacts.offset.reshape(-1)
        return np.asarray(self.at(0).pull @ (self.stiffness * offset)).real

    @cached_property
    def _held_still(self) -> Floats:
        return self._static(0.0)

    def _static(self, omega: float) -> Floats:
        """ũ of the mean, (3c,) m."""
        modes = self.at(0)
        moved = modes.rows @ modes.solve(0.0, self.modal_force(0, omega))
        return np.asarray(moved + self.system.contacts.offset.reshape(-1))

    @cached_property
    def output_rows(self) -> list[Array]:
        """(o, 3, n) displacements of the output nodes in each mode, by harmonic."""
        rows: dict[int, Array] = {}
        for h, k in enumerate(self.nodal_diameters):
            modes, output = self.at(h), self.system.at(k).output
            if output is None:
                output = np.zeros((len(self.system.output_names), 3, len(modes.shapes)))
            if id(modes) not in rows:
                rows[id(modes)] = output @ modes.shapes
        return [rows[id(self.at(h))] for h in range(self.harmonics + 1)]

    @cached_property
    def unit_forces(self) -> dict[int, Array]:
        """Modal forces of the excitation at ω = 1 rad/s, by harmonic."""
        forces = {h: f for h, f in self.system.force.items() if h <= self.harmonics}
        modal: dict[int, Array] = {
            h: self.at(h).shapes.conj().T @ f.vector for h, f in forces.items()
        }
        if 0 in modal:
            modal[0] = modal[0].real
        return modal

    def growth(self, harmonic: int, omega: float) -> float:
        """What the excitation of a harmonic is multiplied by at ω."""
        force = self.system.force.get(harmonic)
        return float(omega**force.omega_power) if force is not None else 1.0

    def modal_force(self, harmonic: int, omega: float) -> Array:
        """Modal force of the excitation; that of interference and sliders included at h = 0."""
        if harmonic in self.unit_forces:
            total = self.unit_forces[harmonic] * self.growth(harmonic, omega)
        else:
            total = np.zeros(len(self.at(harmonic).compliance))
        return np.asarray(total - self._preload if harmonic == 0 else total)

    def vibration(self, harmonic: int, omega: float) -> Array:
        """ũ of a harmonic h >= 1, (3c,) m."""
        if harmonic not in self.system.force:
            return np.zeros(len(self.stiffness))
        modes = self.at(harmonic)
        push = self.modal_force(harmonic, omega)
        return np.asarray(modes.rows @ modes.solve(harmonic * omega, push))

    def columns(self, harmonic: int, omega: float, components: Integers) -> Array:
        """Columns of R̂_h, (k, 3c), of the wanted (k,) components, by summing all modes."""
        if harmonic == 0:
            return self._static_columns[components]
        modes = self.at(harmonic)
        shares = modes.solve(harmonic * omega, modes.pull[:, components])
        return (modes.rows @ shares).T * self.stiffness[components, None]

    def assembled(
        self, omega: float, vibrations: Iterable[Array], compute: tuple[_Compute, ...]
    ) -> Balance:
        """A balance from ũ_h and the columns of R̂_h of the harmonics h = 1 ... H."""
        still = partial(self.columns, 0, 0.0)
        columns = Columns(len(self.stiffness), (still, *compute))
        shape = (self.system.contacts.count, 3, 2 * self.harmonics + 1)
        force = self.system.force.get(0)
        varies = force is not None and force.omega_power
        static = self._static(omega) if varies else self._held_still
        return Balance(omega, to_real(np.stack([static, *vibrations])).reshape(shape), columns)

    def balance(self, omega: float) -> Balance:
        """The balance at a circular frequency, rad/s."""
        vibrating = range(1, self.harmonics + 1)
        return self.assembled(
            omega,
            (self.vibration(h, omega) for h in vibrating),
            tuple(partial(self.columns, h, omega) for h in vibrating),
        )

    def push_rate(self, harmonic: int, omega: float, amplitudes: Array) -> Array | None:
        """Modal forces that moving on in ω amounts to, at fixed w; None where nothing changes."""
        force = self.system.force.get(harmonic)
        grows = force is not None and force.omega_power
        if harmonic == 0 and not grows:
            return None
        rate: Array = -harmonic * self.at(harmonic).slope(harmonic * omega, amplitudes)
        if force is not None and grows:
            applied = self.unit_forces[harmonic] * self.growth(harmonic, omega)
            rate = rate + applied * (force.omega_power / omega)
        return rate

    def slope(self, omega: float, w: Floats) -> Floats:
        """du/dω at fixed w, (c, 3, 2H + 1)."""
        moved = []
        for h, amplitudes in enumerate(self.amplitudes(omega, w)):
            rate, modes = self.push_rate(h, omega, amplitudes), self.at(h)
            if rate is None:
                moved.append(np.zeros(len(self.stiffness), complex))
            else:
                moved.append(modes.rows @ modes.solve(h * omega, rate))
        return to_real(np.stack(moved)).reshape(w.shape)

    def amplitudes(self, omega: float, w: Floats) -> list[Array]:
        """Modal amplitudes of every harmonic under the excitation and the deviation w."""
        pulled = to_complex(w.reshape(-1, w.shape[2])) * self.stiffness
        components = np.flatnonzero(w.any(axis=2).reshape(-1))
        few = 4 * len(components) < len(self.stiffness)
        result = []
        for h in range(self.harmonics + 1):
            modes = self.at(h)
            if few:
                push = (pulled[h, components].conj() @ modes.rows[components]).conj()
            else:
                push = modes.pull @ pulled[h]
            if h == 0:
                push = push.real
            result.append(modes.solve(h * omega, self.modal_force(h, omega) + push))
        return result

    def output(self, amplitudes: list[Array]) -> Complex:
        """(H + 1, o, 3) displacement of the output nodes from modal amplitudes, m."""
        pairs = zip(self.output_rows, amplitudes, strict=True)
        return np.array([rows @ amplitude for rows, amplitude in pairs], complex)


def structure(
    system: System,
    harmonics: int,
    harmonic_diameters: str = "wave",
    stuck: Mapping[int, StuckModes] | None = None,
) -> Structure:
    """Prepare a system for the balance of `harmonics` harmonics."""
    stuck = stuck or {}
    check(system, diameters=stuck, harmonics=harmonics)
    wave = harmonic_diameters == "wave"
    diameters = tuple(system.nodal_diameter(h if wave else min(h, 1)) for h in range(harmonics + 1))
    modes = dict(stuck)
    for k in sorted(set(diameters)):
        mirrored = (system.sectors - k) % system.sectors
        if k in modes:
            continue
        if k not in system.diameters and mirrored in system.diameters:
            # Whatever is known already: what a diameter has does not depend on what was asked for.
            there = modes[mirrored] if mirrored in modes else stuck_modes(system, mirrored)
            modes[k] = there.conjugate()
        else:
            modes[k] = stuck_modes(system, k)
    for h, k in enumerate(diameters):
        force = system.force.get(h)
        if force is not None and len(force.vector) != len(modes[k].shapes):
            raise InputError(
                f"system: force/{h} has {len(force.vector)} entries; "
                f"nodal diameter {k} has {len(modes[k].shapes)}"
            )
    return Structure(system, harmonics, diameters, {k: modes[k] for k in diameters})
