"""The linearised law of isotropic friction against the derivative of the law itself."""

import numpy as np
import pytest

from tests.nonlinear.floquet.test_law_transfer import H, P, random_waves
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.floquet.plane_transfer import plane_transfer
from vanelock.nonlinear.fourier import TURN, to_real


def whole(law, s):
    """Γ (o, 3, M, M) from each component's partners, what contacts remember eliminated."""
    found = law.at(s)
    parts = np.array(found.parts)
    for i, first in enumerate(law.remembering):
        again = 1 / (1 - law.memory[i] * np.exp(-TURN * s))
        read = found.read[i]
        for j, order in enumerate(([0, 1, 2], [2, 1, 0])):  # u1, v, u2 and u2, v, u1
            for e in range(3):
                parts[e, first + j] += again * np.outer(found.shown[i, j], read[order[e]])
    return np.moveaxis(parts, 0, 1)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("part", "periods"), [(0, 1), (1, 3), (1, 2), (-2, 5)])
def test_perturbations_that_last_some_periods(seed, part, periods):
    # As of orthogonal friction: harmonics k + part/periods are whole ones of a longer wave.
    q, contacts = random_waves(seed, 16)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    law = plane_transfer(to_real(q), alpha, P)
    found = whole(law, 1j * part / periods)
    slow = np.zeros((periods * (P + 2) + 1, *q.shape[1:]), complex)
    slow[: periods * H + 1 : periods] = q
    deviation = contact_law(contacts, len(slow) - 1, friction="isotropic")(to_real(slow))
    answers = np.zeros(3 * contacts.count, bool)
    answers[law.components] = True
    assert np.all(np.any(deviation.jacobian != 0, axis=(2, 3, 4)).ravel()[answers])
    order = np.arange(-P, P + 1) * periods + part
    size, sign = np.abs(order), np.sign(order)
    known = np.outer(size, size) > 0  # the mean has no phase
    alike = np.equal.outer(sign, sign)
    cosine = np.maximum(2 * size - 1, 0)
    off = []
    for place, component in enumerate(law.components):
        contact, row = divmod(component, 3)
        for e, column in enumerate(law.partners[:, place] % 3):
            if e and row == 0:
                continue
            block = deviation.jacobian[contact, row, :, column]
            a, b, c, d = (block[np.ix_(cosine + i, cosine + j)] for i in (0, 1) for j in (0, 1))
            value = np.where(alike, a + d + 1j * (c - b), a - d + 1j * (c + b)) / 2
            value = np.where(sign[:, None] > 0, value, value.conj())
            off.append(np.abs(found[place, e] - value)[known].max())
    assert np.quantile(off, 0.9) < 1e-7
    assert max(off) < 3e-5  # of steps that differ where a contact that slips lifts off


def test_shifted_by_a_harmonic():
    q, contacts = random_waves(7)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    law = plane_transfer(to_real(q), alpha, P)
    assert 0 < len(law.remembering) < contacts.count
    s = 0.07 + 0.3j
    one, other = whole(law, s), whole(law, s + 1j)
    np.testing.assert_allclose(other[..., :-1, :-1], one[..., 1:, 1:], atol=1e-6)


def test_what_a_straight_path_remembers_fades_with_the_distance_slipped():
    # Back and forth along one line, r constant: 4 (U - r) slipped a period, η' = -(λ/r) η.
    u = np.zeros((1, 3, 3))
    u[0, :2, :2] = [[1.0, 0.0], [0.0, 1.3]]
    for alpha in (0.9, 1.2):
        law = plane_transfer(u, np.full((1, 2), alpha), P)
        assert law.memory == pytest.approx([np.exp(-4 * (1.3 - alpha) / alpha)], rel=1e-8)
