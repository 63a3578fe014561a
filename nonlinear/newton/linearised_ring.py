"""The balance of a ring whose sectors need not be alike, condensed to all their contacts.

Sector j of a travelling wave does what the first one does, later by jφ, φ = 2π EO/N. Seen from
there, q_j^(h) = q̂_j^(h) e^{-ihjφ}, the law of contact is the same in every sector, as it does not
know the time; and where all are alike, so are all q̂_j. What differs is a sum of waves n,

    q̂_j = Σ_n Q_n e^{-2πijn/N},      n = 0 ... N - 1,

of which harmonic h has the nodal diameter (n + h EO) mod N, so that the structure, which is alike,

    U_n^(h) = R̂_{h,n} W_n^(h),

takes N small receptances and two discrete Fourier transforms.

The balance is linearised by GMRES from that of a ring of alike sectors. The contacts' laws
linearise to a matrix J_j a sector. With its mean J̄ instead, waves n do not meet, and in the real
coefficients of harmonic h >= 1, of which Z = C + iS,

    P_n = I - J̄ R̂_n,    R̂_n = [ (A + Ã)/2    i(A - Ã)/2 ]     A = R̂_{h,n},  Ã = R̂*_{h,-n},
                              [ -i(A - Ã)/2   (A + Ã)/2 ],

is complex and as large as one sector's contacts; P_{N-n} is its conjugate. Contacts whose J̄ is
small, such as those that stick on springs that differ by sector, are left to the iteration: theirs
counts as zero, so that P_n is inverted on the others alone. Where all sectors are alike, and none
is left out, these are the linearised balance itself, and GMRES ends at its first step.
"""

from dataclasses import dataclass, replace

import numpy as np

from vanelock.common.arrays import Array, Booleans, Complex, Floats, Integers
from vanelock.nonlinear.balance.balance import Balance
from vanelock.nonlinear.balance.receptance_columns import Columns, HeldColumns
from vanelock.nonlinear.fourier import to_complex, to_real
from vanelock.nonlinear.newton.preconditioner import Equations, Kept, Preconditioned


class RingColumns(HeldColumns):
    """Columns of the receptances of all waves of a ring that have been asked for so far."""

    def __init__(self, waves: tuple[Columns, ...]) -> None:
        super().__init__(waves[0].size)
        self.waves = waves
        self.held: Array = np.empty((len(waves[0].compute), len(waves), 0, self.size), complex)
        self._chosen: tuple[Integers, Array] | None = None

    def with_harmonics(self, harmonics: int) -> "RingColumns":
        """Those of the first harmonics alone."""
        return RingColumns(
            tuple(Columns(each.size, each.compute[: harmonics + 1]) for each in self.waves)
        )

    def hold(self, components: Integers) -> None:
        """Make sure that the columns of these components are held, (H + 1, N, k, 3c)."""
        if not len(missing := self._admitted(components)):
            return
        fresh = np.empty((*self.held.shape[:2], len(missing), self.size), complex)
        for n, columns in enumerate(self.waves):
            for h, compute in enumerate(columns.compute):
                fresh[h, n] = compute(missing)
        self.held = np.concatenate([self.held, fresh], axis=2)

    def among(self, chosen: Integers) -> Array:
        """(H + 1, N, k, k) of some components on themselves; the last choice is kept."""
        if self._chosen is None or not np.array_equal(self._chosen[0], chosen):
            self.hold(chosen)
            square = self.held[:, :, self.place[chosen][:, None], chosen]
            self._chosen = chosen, np.ascontiguousarray(square)
        return self._chosen[1]


def _passed(receptances: Array, w: Floats) -> Floats:
    """R̂ w, (N, r, m), of deviations (N, k, m) of the columns that (H + 1, N, k, r) are of."""
    waves = np.fft.ifft(to_complex(w), axis=1)
    moved = (waves[:, :, None] @ receptances)[:, :, 0]
    return to_real(np.fft.fft(moved, axis=1))


@dataclass(frozen=True)
class RingBalance(Balance):
    """The balance at one frequency of all N sectors, one behind the other.

    `linear` is (N c, 3, 2H + 1); `columns` are those of the wave n = 0.
    """

    ring: RingColumns

    @property
    def sectors(self) -> int:
        """N."""
        return len(self.ring.waves)

    def with_harmonics(self, harmonics: int) -> "RingBalance":
        """The balance of the first harmonics alone."""
        linear = self.linear[:, :, : 2 * harmonics + 1].copy()
        ring = self.ring.with_harmonics(harmonics)
        return replace(self, linear=linear, columns=ring.waves[0], ring=ring)

    def moved(self, w: Floats) -> Floats:
        """R̂ w, (N c, 3, 2H + 1)."""
        flat = w.reshape(self.sectors, -1, w.shape[2])
        components, ring = np.flatnonzero(flat.any(axis=(0, 2))), self.ring
        if not len(components):
            return np.zeros_like(w)
        ring.hold(components)
        if 2 * len(components) > len(ring.components):
            components, held = ring.components, ring.held
        else:
            held = ring.held[:, :, ring.place[components]]
        return _passed(held, flat[:, components]).reshape(w.shape)


_WEAK = 0.1  # largest entry of J̄ of contacts that are left to the iteration


@dataclass(frozen=True)
class _KeptRing(Kept):
    """The inverses of P_n, kept over steps and frequencies while they serve.

    `contacts` (a,): of a sector, those that they are of: whose J̄ is not small; `inverse` (N/2 + 1,
    3am, 3am); `sign`: of the determinant of all waves.
    """

    contacts: Integers
    inverse: Complex
    sign: float

    def serves(self, contacts: Integers) -> bool:
        """Whether it serves where these contacts deviate."""
        return not self.stale and bool(np.isin(self.contacts, contacts).all())


class LinearisedRing(Preconditioned):
    """P applied, preconditioned by that of the ring of alike sectors."""

    LIMIT, STALE = 200, 4

    def __init__(self, equations: Equations) -> None:
        balance, deviation, rows, _, border, reuse, _ = equations
        assert isinstance(balance, RingBalance)
        m, self.sectors = deviation.w.shape[2], balance.sectors
        count, width = len(deviation.w) // self.sectors, 3 * m
        contacts = np.unique(rows // width % count)
        self.a = len(contacts)
        components = np.asarray(3 * contacts[:, None] + np.arange(3)).reshape(-1)
        blocks = deviation.jacobian.reshape(self.sectors, count, width, width)
        self.blocks = np.ascontiguousarray(blocks[:, contacts])
        self.mean = self.blocks.mean(axis=0)
        self.receptance = balance.ring.among(components)
        per_sector = components[:, None] * m + np.arange(m)
        every = count * width * np.arange(self.sectors)
        entries = (every[:, None] + per_sector.reshape(-1)).reshape(-1)
        super().__init__(equations, entries)
        self.reuse: _KeptRing | None = reuse if isinstance(reuse, _KeptRing) else None
        if not (self.reuse and self.reuse.serves(contacts)):
            self.reuse = self._made(contacts)
        self.singular = self.reuse is None
        if self.reuse is not None:
            self.strong = np.isin(contacts, self.reuse.contacts)
            near, far = self._components(self.strong), self._components(~self.strong)
            self.coupling = np.ascontiguousarray(self.receptance[:, :, far[:, None], near])
        if border is not None and not self.singular:
            self._led = np.array([self._alike(each) for each in self.rate])
            self._pivot = border.corner + self.normal @ self._led.T
            self.singular |= np.linalg.slogdet(self._pivot)[0] == 0.0

    def _made(self, contacts: Integers) -> _KeptRing | None:
        """Inverses at this very state; None where one does not exist."""
        strong = np.abs(self.mean).max(axis=(1, 2)) > _WEAK
        matrices = self._waves(strong)
        own = [P.real for n, P in enumerate(matrices) if 2 * n % self.sectors == 0]
        sign = float(np.prod([np.linalg.slogdet(P)[0] for P in own]))
        try:
            inverse: Complex = np.linalg.inv(matrices).astype(complex, copy=False)
        except np.linalg.LinAlgError:
            return None
        if sign == 0.0 or not np.all(np.isfinite(inverse)):
            return None
        return _KeptRing(contacts[strong], inverse, sign)

    def _components(self, chosen: Booleans) -> Integers:
        """Places of some contacts' components among those of all that deviate."""
        return np.flatnonzero(np.repeat(chosen, 3))

    def _waves(self, strong: Booleans) -> Complex:
        """(N/2 + 1, 3sm, 3sm) P_n of s contacts for n = 0 ... N/2."""
        near = self._components(strong)
        N, m, k = self.sectors, self.m, len(near)
        waves = np.arange(N // 2 + 1)
        R = self.receptance[:, :, near[:, None], near].swapaxes(2, 3)  # (H + 1, N, to, from)
        moved = np.zeros((len(waves), k, m, k, m), complex)
        moved[:, :, 0, :, 0] = R[0, waves]
        for h in range(1, len(R)):
            A, B = R[h, waves], R[h, -waves].conj()
            c, s = 2 * h - 1, 2 * h
            moved[:, :, c, :, c] = moved[:, :, s, :, s] = (A + B) / 2
            moved[:, :, c, :, s] = 1j * (A - B) / 2
            moved[:, :, s, :, c] = -1j * (A - B) / 2
        P: Complex = -(self.mean[strong] @ moved.reshape(len(waves), k // 3, 3 * m, k * m))
        P = P.reshape(len(waves), k * m, k * m)
        each = np.arange(k * m)
        P[:, each, each] += 1.0
        return P

    def _alike(self, y: Floats) -> Floats:
        """P⁻¹ of the ring of alike sectors, on the entries of these contacts."""
        assert self.reuse is not None
        N, strong = self.sectors, self.strong
        x = y.reshape(N, self.a, 3 * self.m).copy()
        if not strong.any():
            return x.reshape(-1)
        right = x[:, strong]
        if not strong.all():
            moved = _passed(self.coupling, x[:, ~strong].reshape(N, -1, self.m))
            right += (self.mean[strong] @ moved.reshape(N, -1, 3 * self.m, 1))[..., 0]
        waves = np.fft.rfft(right.reshape(N, -1), axis=0).conj()
        solved = (self.reuse.inverse @ waves[:, :, None])[:, :, 0]
        x[:, strong] = np.fft.irfft(solved.conj(), N, axis=0).reshape(right.shape)
        return x.reshape(-1)

    def _alone(self, x: Floats) -> Floats:
        """P x."""
        u = _passed(self.receptance, x.reshape(self.sectors, -1, self.m))
        moved = self.blocks @ u.reshape(self.sectors, self.a, 3 * self.m, 1)
        return np.asarray(x - moved.reshape(-1))

    def _precondition(self, y: Floats) -> Floats:
        """The same of the ring of alike sectors, inverted."""
        if self.border is None:
            return self._alike(y)
        x, p = np.split(y, [len(self.entries)])
        ahead = self._alike(x)
        moved = np.linalg.solve(self._pivot, p - self.normal @ ahead)
        return np.append(ahead + moved @ self._led, moved)

    def solve(self, gap: Floats, tolerance: float) -> Floats | None:
        """(dw, dp); None where the iteration does not get there."""
        return None if self.singular else super().solve(gap, tolerance)

    def merit(self, gap: Floats) -> float:
        """Preconditioned size of a gap."""
        if self.singular:
            return float(np.linalg.norm(gap * self.weight))
        return super().merit(gap)

    def orientation(self) -> float:
        """As of `Iterative`: waves n and N - n are conjugate and do not count."""
        assert self.reuse is not None
        border = 1.0 if self.border is None else float(np.linalg.slogdet(self._pivot)[0])
        return self.reuse.sign * border * self._turned()
