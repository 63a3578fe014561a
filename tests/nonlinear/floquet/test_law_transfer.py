"""The linearised law against the derivative of the law itself over several periods."""

import numpy as np
import pytest

from vanelock.nonlinear import Contacts
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.floquet.perturbation import law_transfer
from vanelock.nonlinear.fourier import to_real

H, P = 3, 4


def random_waves(seed, count=40):
    """Contacts in every state, as displacements of H harmonics."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(H + 1, count, 3)) + 1j * rng.normal(size=(H + 1, count, 3))
    q[2:] *= 0.4
    q[0] = q[0].real
    q[0, :, 0] += rng.uniform(-3, 6, count)
    mu = np.where(rng.random(count) < 0.15, 0.0, rng.uniform(0.1, 1, count))
    return q, Contacts(np.ones(count), np.ones((count, 2)), mu, np.zeros(count))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("part", "periods"), [(0, 1), (1, 3), (1, 2), (-2, 5)])
def test_perturbations_that_last_some_periods(seed, part, periods):
    # s = i part/periods: the perturbation has the harmonics k + part/periods of the wave, which are
    # whole ones of a wave that takes so many times longer, and the law has its derivative there.
    q, contacts = random_waves(seed)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    law = law_transfer(to_real(q), alpha, P)
    along, across = law.at(1j * part / periods).parts
    slow = np.zeros((periods * (P + 2) + 1, *q.shape[1:]), complex)
    slow[: periods * H + 1 : periods] = q
    jacobian = contact_law(contacts, len(slow) - 1)(to_real(slow)).jacobian
    answers = np.zeros(3 * contacts.count, bool)
    answers[law.components] = True
    for place, component in enumerate(law.components):
        contact, row = divmod(component, 3)
        for column, found in {0: across[place], row: along[place]}.items():
            block = jacobian[contact, row, :, column]
            for j in range(-P, P + 1):
                for k in range(-P, P + 1):
                    order = [abs(i * periods + part) for i in (j, k)]
                    if 0 in order:
                        continue  # the mean has no phase
                    derivative = block[2 * order[0] - 1 : 2 * order[0] + 1]
                    derivative = derivative[:, 2 * order[1] - 1 : 2 * order[1] + 1]
                    a, b, c, d = derivative.ravel()
                    # Of e^{ik}: what answers at e^{ij}, not at its conjugate.
                    plus = (a + d + 1j * (c - b)) / 2
                    minus = (a - d + 1j * (c + b)) / 2
                    signs = [np.sign(i * periods + part) for i in (j, k)]
                    value = plus if signs[0] == signs[1] else minus
                    expected = value if signs[0] > 0 else value.conjugate()
                    assert found[j + P, k + P] == pytest.approx(expected, abs=1e-9)
    state = np.any(jacobian != 0, axis=(2, 3, 4)).ravel()
    assert np.all(state[answers])


def test_shifted_by_a_harmonic():
    q, contacts = random_waves(7)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    law = law_transfer(to_real(q), alpha, P)
    s = 0.07 + 0.3j
    for one, other in zip(law.at(s).parts, law.at(s + 1j).parts, strict=True):
        np.testing.assert_allclose(other[:, :-1, :-1], one[:, 1:, 1:], atol=1e-12)


def test_growing_perturbation_by_quadrature():
    q, contacts = random_waves(11)
    alpha = (contacts.mu * contacts.kn)[:, None] / contacts.kt
    law = law_transfer(to_real(q), alpha, P)
    s, k = 0.2 + 0.31j, np.arange(-P, P + 1)
    still = law_transfer(to_real(q), alpha, P)
    along, _ = law.at(s).parts
    apart = along - still.static[0]
    for i in range(len(law.components)):
        expected = np.zeros((2 * P + 1, 2 * P + 1), complex)
        for begin, end, since, _ in law.held[i]:
            nodes, weights = np.polynomial.legendre.leggauss(60)
            angle = (begin + end) / 2 + (end - begin) / 2 * nodes
            kept = weights * (end - begin) / 2 * np.exp(-s * (angle - since))
            shown = np.exp(-1j * np.outer(k, angle)) @ kept / (2 * np.pi)
            expected += np.outer(shown, np.exp(1j * k * since))
        np.testing.assert_allclose(apart[i], expected, atol=1e-12)
