"""The structure of a ring, by waves, and what mistuned contacts and modes change in it.

The stuck structure is that of alike sectors. What differs acts on it as deviations w do:

    interference, sliders:    u = ... + Δv₀ - R̂ Δv₀,
    stiffness of springs:     w = W(u) - κ (u - W(u)),
    a mode's frequency:       w = -κ q,  q = g x,

for each mode a row of its own beside the contacts, of unit stiffness, κ = k ((1 + δ)² - 1).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vanelock.common.arrays import Array, Booleans, Complex, Floats
from vanelock.common.errors import InputError
from vanelock.nonlinear.balance.balance import Structure, structure
from vanelock.nonlinear.balance.receptance_tables import Tabulated, balances
from vanelock.nonlinear.balance.stuck_modes import HarmonicModes, StuckModes, stuck_modes
from vanelock.nonlinear.contact.law import Law, contact_law
from vanelock.nonlinear.forced_response.ring.mistuning import Mistuning, SectorModes
from vanelock.nonlinear.fourier import to_complex, to_real
from vanelock.nonlinear.newton.linearised_ring import RingBalance, RingColumns
from vanelock.rom.system.coordinates import check, check_ring
from vanelock.rom.system.system import Contacts, System


@dataclass(frozen=True)
class RingSource:
    """Gives the balances of a ring.

    `waves`: n = 0 ... N - 1; the excitation and what is alike at rest are of n = 0; `offset` (N,
    3c): interference and sliders reversed, more than those of n = 0, m.
    """

    waves: tuple[Structure | Tabulated, ...]
    offset: Floats

    @property
    def structure(self) -> Any:
        """Itself: gives motions and their slopes as a `Structure` does, those of all sectors."""
        return self

    @cached_property
    def each(self) -> list[Structure]:
        """The waves' structures."""
        return [wave.structure for wave in self.waves]

    @property
    def system(self) -> System:
        """The one that all sectors are compared with."""
        return self.each[0].system

    @property
    def harmonics(self) -> int:
        """H."""
        return self.each[0].harmonics

    def balance(self, omega: float) -> RingBalance:
        """The balance at a circular frequency, rad/s."""
        found = [wave.balance(omega) for wave in self.waves]
        ring = RingColumns(tuple(each.columns for each in found))
        alike = np.tile(found[0].linear, (len(self.waves), 1, 1))
        alike[:, :, 0] += self._moved_at_rest.reshape(len(alike), 3)
        return RingBalance(omega, alike, found[0].columns, ring)

    @cached_property
    def _moved_at_rest(self) -> Floats:
        """(N, 3c) Δv₀ - R̂ Δv₀, m."""
        every = np.arange(self.offset.shape[1])
        pushes = np.fft.ifft(self.offset, axis=0)
        waves = [
            push @ wave.columns(0, 0.0, every) for push, wave in zip(pushes, self.each, strict=True)
        ]
        return np.asarray(self.offset - np.fft.fft(waves, axis=0).real)

    def amplitudes(self, omega: float, w: Floats) -> list[list[Array]]:
        """Modal amplitudes by wave and harmonic under deviations w (N c, 3, 2H + 1)."""
        flat = w.reshape(len(self.waves), -1, w.shape[2]).copy()
        flat[:, :, 0] -= self.offset
        pulled = np.fft.ifft(to_complex(flat), axis=1) * self.each[0].stiffness
        every = []
        for n, wave in enumerate(self.each):
            pushes = [wave.at(h).pull @ pulled[h, n] for h in range(self.harmonics + 1)]
            every.append(
                [
                    wave.at(h).solve(h * omega, wave.modal_force(h, omega) + push)
                    for h, push in enumerate(pushes)
                ]
            )
        return every

    def output(self, amplitudes: list[list[Array]]) -> Complex:
        """(H + 1, N, o, 3) displacement of the output nodes, each sector at its own instant, m."""
        waves = np.stack(
            [wave.output(own) for wave, own in zip(self.each, amplitudes, strict=True)], axis=1
        )
        found: Complex = np.fft.fft(waves, axis=1)
        found[0] = found[0].real
        return found

    def slope(self, omega: float, w: Floats) -> Floats:
        """du/dω at fixed w, (N c, 3, 2H + 1)."""
        rates = np.zeros(
            (self.harmonics + 1, len(self.waves), len(self.each[0].stiffness)), complex
        )
        for n, (wave, own) in enumerate(zip(self.each, self.amplitudes(omega, w), strict=True)):
            for h, amplitudes in enumerate(own):
                rate, modes = wave.push_rate(h, omega, amplitudes), wave.at(h)
                if rate is not None:
                    rates[h, n] = modes.rows @ modes.solve(h * omega, rate)
        return to_real(np.fft.fft(rates, axis=1)).reshape(w.shape)


def ring_source(
    system: System,
    harmonics: int,
    limits: tuple[float, float],
    points: int,
    modes: SectorModes | None = None,
    stuck: Mapping[int, StuckModes] | None = None,
) -> RingSource:
    """The ring of a system, all sectors alike."""
    N, stuck = system.sectors, stuck or {}
    loaded = replace(system, contacts=_with_modes(system.contacts, modes))
    rows = 3 * loaded.contacts.count
    if not all(k in stuck and len(stuck[k].rows) == rows for k in range(N)):
        stuck = ring_modes(system, modes, stuck).diameters
    still = replace(loaded.contacts, v0=0 * loaded.contacts.v0, slider=0 * loaded.contacts.slider)
    unloaded = replace(loaded, contacts=still, force={})
    waves: list[Structure | Tabulated] = []
    alike = structure(loaded, harmonics, stuck=stuck)
    waves.append(balances(alike, *limits, points))
    for n in range(1, N):
        diameters = tuple((n + k) % N for k in alike.nodal_diameters)
        wave = Structure(unloaded, harmonics, diameters, {k: stuck[k] for k in diameters})
        waves.append(balances(wave, *limits, points))
    return RingSource(tuple(waves), np.zeros((N, len(alike.stiffness))))


def ring_modes(
    system: System, modes: SectorModes | None = None, stuck: Mapping[int, StuckModes] | None = None
) -> HarmonicModes:
    """Stuck modes of all N nodal diameters, which know the amplitudes of sectors' own modes, too.

    Rings that differ in nothing else share them, and what is computed of them on the way.

    Parameters
    ----------
    system : System
        With the nodal diameters 0 to N/2.
    modes : SectorModes, optional
    stuck : dict of int to StuckModes, optional
        Of the system, computed before.

    Raises
    ------
    InputError
        If nodal diameters are missing, or the modes' rows do not fit.
    """
    N, stuck = system.sectors, stuck or {}
    check(system, diameters=stuck)
    check_ring(system, N // 2, "a mistuned ring")
    half: dict[int, StuckModes] = {}
    for k in range(N // 2 + 1):
        half[k] = stuck[k] if k in stuck else stuck_modes(system, k)
        if modes is not None:
            half[k] = _with_rows(half[k], modes, k)
    return HarmonicModes({k: half[k] if k in half else half[N - k].conjugate() for k in range(N)})


def _with_modes(contacts: Contacts, modes: SectorModes | None) -> Contacts:
    """Contacts and, behind them, three modes in the place of one more each."""
    more = 0 if modes is None else -(-len(modes.stiffness) // 3)
    if not more:
        return contacts
    names = (*contacts.joints, *["modes"] * more)
    return replace(
        contacts,
        kn=np.append(contacts.kn, np.ones(more)),
        kt=np.concatenate([contacts.kt, np.ones((more, 2))]),
        mu=np.append(contacts.mu, np.ones(more)),
        v0=np.append(contacts.v0, np.zeros(more)),
        slider=np.concatenate([contacts.slider, np.zeros((more, 2))]),
        joint=names,
    )


def _with_rows(stuck: StuckModes, modes: SectorModes, k: int) -> StuckModes:
    """Stuck modes that know the amplitudes of a sector's own modes, too."""
    rows = modes.rows.get(k)
    if rows is None or rows.shape != (len(modes.stiffness), len(stuck.shapes)):
        given = "none" if rows is None else f"shape {rows.shape}"
        wanted = (len(modes.stiffness), len(stuck.shapes))
        raise InputError(
            f"mistuning.modes: rows of nodal diameter {k}: given {given}: needs {wanted}"
        )
    own = np.zeros((-(-len(rows) // 3) * 3, stuck.rows.shape[1]), np.result_type(rows, stuck.rows))
    own[: len(rows)] = rows @ stuck.shapes
    if not np.iscomplexobj(stuck.rows) and not own.imag.any():
        own = own.real
    springs = stuck.springs
    if springs is not None:
        springs = np.append(springs, np.zeros(len(own)))
    return replace(stuck, rows=np.concatenate([stuck.rows, own]), springs=springs)


@dataclass(frozen=True)
class _RingContacts:
    """The contacts of all sectors, one behind the other, and the modes' rows among them.

    `contacts`: (N c,), mistuned; `stiffer` (N c, 3): κ; `bonded` (N c,): which are modes; `offset`
    (N, 3c): as of `RingSource`.
    """

    contacts: Contacts
    stiffer: Floats
    bonded: Booleans
    offset: Floats

    def law(self, harmonics: int, samples: int | None, friction: str) -> Law:
        """The law of all."""
        law = contact_law(self.contacts, harmonics, samples, friction)
        bonded = self.bonded if self.bonded.any() else None
        return replace(law, stiffer=self.stiffer if self.stiffer.any() else None, bonded=bonded)


def ring_contacts(alike: Contacts, mistuning: Mistuning) -> _RingContacts:
    """Contacts of a ring."""
    N, modes = mistuning.sectors, mistuning.modes
    each = _with_modes(alike, modes)
    c, own = each.count, alike.count
    stiffer, offset = np.zeros((N, c, 3)), np.zeros((N, c, 3))
    stiffer[:, :own, 0], stiffer[:, :own, 1:] = mistuning.kn, mistuning.kt
    offset[:, :own, 0], offset[:, :own, 1:] = mistuning.interference, 0.0 - mistuning.slider
    if modes is not None:
        beyond = np.zeros((N, 3 * (c - own)))
        shifts = (1 + mistuning.frequency) ** 2 - 1
        beyond[:, : shifts.shape[1]] = modes.stiffness * shifts
        stiffer[:, own:] = beyond.reshape(N, -1, 3)
    friction = np.zeros((N, c))
    friction[:, :own] = mistuning.mu
    spring = np.where(np.arange(c)[:, None] < own, stiffer, 0.0)
    contacts = Contacts(
        kn=(each.kn * (1 + spring[:, :, 0])).reshape(-1),
        kt=(each.kt * (1 + spring[:, :, 1:])).reshape(-1, 2),
        mu=(each.mu * (1 + friction)).reshape(-1),
        v0=(each.v0 + offset[:, :, 0]).reshape(-1),
        slider=(each.slider - offset[:, :, 1:]).reshape(-1, 2),
        joint=each.joints * N,
        elements={j * c + i: element for j in range(N) for i, element in each.elements.items()},
    )
    bonded = np.tile(np.arange(c) >= own, N)
    return _RingContacts(contacts, stiffer.reshape(-1, 3), bonded, offset.reshape(N, -1))
