"""The check of solved points: its own marching and damping, and that it finds what is wrong."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.nonlinear.systems import (
    alike_contacts,
    even,
    first_frequency,
    march,
    random_system,
    solved_response,
    stuck_stiffness,
    with_contacts,
    with_rest,
)
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contacts,
    Diameter,
    Force,
    Options,
    System,
    audit_response,
)
from vanelock.nonlinear.audit import _coefficients, _damping_matrix, _histories, _march_contacts

Array = NDArray[np.complex128]


def drawn(count, harmonics, mean, seed):
    """Contacts and loops, closed throughout if `mean` is large."""
    rng = np.random.default_rng(seed)
    made = Contacts(
        kn=rng.uniform(0.5, 2, count),
        kt=rng.uniform(0.5, 2, (count, 2)),
        mu=rng.choice([0.0, 0.1, 0.3, 1.0], count),
        v0=np.zeros(count),
    )
    q: Array = rng.normal(size=(harmonics + 1, count, 3)).astype(np.complex128)
    q[1:] += 1j * rng.normal(size=(harmonics, count, 3))
    for h in range(harmonics + 1):
        q[h] /= h + 1
    q[0, :, 0] += mean
    return made, q


def test_blocks_of_a_period_march_as_one_step_after_the_other():
    made, q = drawn(count=20, harmonics=3, mean=7.0, seed=1)
    stepwise = march(made, q, 4096)
    assert stepwise[:, :, 0].min() > 0
    force, work = _march_contacts(made, q, 4096)
    np.testing.assert_allclose(force, _coefficients(stepwise, 3), atol=1e-13)
    slipping = work > 0
    assert 5 <= slipping.sum() <= 15


def test_error_of_marching_falls_with_the_square_of_the_samples():
    made, q = drawn(count=16, harmonics=3, mean=0.5, seed=2)
    assert np.mean(_histories(q, 64)[:, :, 0].min(axis=0) < 0) > 0.5
    best = _march_contacts(made, q, 2**18)
    errors = []
    for samples in (2**10, 2**12, 2**14):
        found = _march_contacts(made, q, samples)
        errors.append([np.abs(one - other).max() for one, other in zip(found, best, strict=True)])
    coarse, middle, fine = np.array(errors)
    assert np.all(fine < 1e-6)
    assert np.all(middle < coarse / 6)
    assert np.all(fine < middle / 6)


def test_damping_matrix_of_a_massless_coordinate_is_that_without_it():
    # The coordinate in the middle condenses to a spring of 1/(1/2 + 1/3) = 1.2 N/m.
    K = np.array([[3.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 4.0]])
    own = np.zeros((1, 3, 3), complex)
    made = System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K, np.diag([1.0, 0.0, 2.0]), own)},
        contacts=Contacts(np.ones(1), np.ones((1, 2)), np.ones(1), np.zeros(1)),
        damping_ratio=0.1,
    )
    small = np.array([[2.2, -1.2], [-1.2, 2.2]])
    condensed = Diameter(small, np.diag([1.0, 2.0]), own[:, :, :2])
    expected = _damping_matrix(replace(made, diameters={0: condensed}), 0)
    found = _damping_matrix(made, 0)
    np.testing.assert_allclose(found[np.ix_([0, 2], [0, 2])], expected, atol=1e-14)
    np.testing.assert_allclose(found[1], 0, atol=1e-14)


CASES: dict[str, dict[str, Any]] = {
    "forward": {"sectors": 5, "engine_order": 1},
    "backward": {"sectors": 7, "engine_order": -2},
    "alone": {"sectors": 1, "engine_order": 0},
    "opening": {"preload": 0.05, "sectors": 6, "engine_order": 3},
    "stuck": {"amplitude": 1e-6},
}


@pytest.mark.parametrize("case", CASES)
def test_solved_points_pass(case):
    system = with_rest(random_system(11, **CASES[case]), 0.1)
    response = solved_response(system, first_frequency(system) * np.array([0.9, 1.0]))
    found = audit_response(system, response)
    assert np.all(found.residual_error < 1e-8)
    assert np.all(found.residual < 3 * found.residual_error)
    assert np.all(found.imbalance < 1e-7)
    assert np.all(found.imbalance < 3 * found.imbalance_error)
    assert np.all(found.force_difference < 1e-8)
    assert np.all(found.friction_power >= 0)
    hertz = response.frequency[:, None]
    work = found.friction_power / hertz
    np.testing.assert_allclose(work, response.dissipation, atol=1e-7 * max(work.max(), 1e-300))
    share = found.friction_power.sum(axis=1) / found.excitation_power
    assert np.all(share == 0) if case == "stuck" else np.all(share > 0.1)


@pytest.mark.parametrize("case", ["backward", "opening", "stuck"])
def test_solved_points_of_isotropic_friction_pass(case):
    system = even(random_system(11, **CASES[case]))
    hertz, options = first_frequency(system) * np.array([0.9, 1.0]), Options(friction="isotropic")
    response = solved_response(system, hertz, options)
    found = audit_response(system, response)
    # The law's own error, of five collocation points a step, is below 4e-7 of the displacements.
    assert np.all(found.residual < np.maximum(3 * found.residual_error, 1e-7))
    assert np.all(found.imbalance < np.maximum(3 * found.imbalance_error, 1e-7))
    work = found.friction_power / response.frequency[:, None]
    rounding = np.finfo(float).eps * np.abs(response.force * response.contact).max()
    atol = max(1e-7 * work.max(), rounding)
    np.testing.assert_allclose(work, response.dissipation, atol=atol)
    if case != "stuck":  # where it slips, it is no solution of the other law
        other = replace(response, friction="orthogonal")
        assert np.all(audit_response(system, other).residual > 1e-4)


def test_marched_circle_has_its_closed_form():
    # A slider at the distance r = μ n/kt behind, its force in the direction of the motion.
    kn, kt, mu, n0, amplitude = 2e6, 3e6, 0.3, 50.0, 2e-5
    made = alike_contacts(kn, kt, mu)
    q = np.zeros((2, 1, 3), complex)
    q[0, 0, 0], q[1, 0, 1], q[1, 0, 2] = n0 / kn, amplitude, -1j * amplitude
    (force, done), r = _march_contacts(made, q, 2**12, "isotropic"), mu * n0 / kt
    work = 2 * np.pi * mu * n0 * r * np.sqrt((amplitude / r) ** 2 - 1)
    np.testing.assert_allclose(done, work, rtol=1e-5)
    np.testing.assert_allclose(np.abs(force[1, 0, 1:]), mu * n0, rtol=1e-6)


@pytest.fixture(name="solved", scope="module")
def solved_fixture():
    system = random_system(4)
    response = solved_response(system, [first_frequency(system)], Options(3))
    return system, response


def test_a_wrong_coordinate_shows_as_its_residual(solved):
    system, response = solved
    away = 1e-6 * np.abs(response.x[2]).max()
    x = dict(response.x)
    x[2] = x[2].copy()
    x[2][0, 3] += away
    found = audit_response(system, replace(response, x=x))
    k = system.nodal_diameter(2)
    M, C, s = system.at(k).M, _damping_matrix(system, k), 4 * np.pi * response.frequency[0]
    moved = 1j * s * C - s**2 * M
    free, stuck = system.at(k).K + moved, stuck_stiffness(system, k) + moved
    sizes = sorted(np.abs(D[:, 3]).max() * away for D in (free, stuck))
    assert 0.3 * sizes[0] < found.residual[0] * found.scale[0, 1] < 3 * sizes[1]
    assert found.residual[0] > 30 * found.residual_error[0]


@pytest.mark.parametrize("change", ["friction", "damping", "interference", "force", "phase"])
def test_a_response_of_another_system_fails(change, solved):
    system, response = solved
    contacts = system.contacts
    others = {
        "friction": with_contacts(system, mu=1.001 * contacts.mu),
        "interference": with_contacts(system, v0=1.001 * contacts.v0),
        "damping": replace(system, damping_ratio=0.006),
        "force": replace(system, force={1: Force(1.001 * system.force[1].vector)}),
        "phase": replace(
            system,
            diameters={k: replace(d, own=d.next, next=d.own) for k, d in system.diameters.items()},
        ),
    }
    found = audit_response(others[change], response)
    assert found.residual[0] > 1e-5
    assert found.residual[0] > 1000 * found.residual_error[0]
    assert change == "interference" or found.imbalance[0] > 100 * found.imbalance_error[0]


def test_error_of_plain_samples_shows(solved):
    system, exact = solved
    response = solved_response(system, exact.frequency, Options(3, samples=64))
    assert response.residual[0] < 1e-10
    found = audit_response(system, response)
    assert 1e-5 < found.residual[0] < 1e-1
    assert 1e-5 < found.force_difference[0] < 1e-1


def test_forces_are_compared_with_the_largest(solved):
    system, response = solved
    found = audit_response(system, replace(response, force=1.1 * response.force))
    assert abs(np.abs(response.force).max() - 1) > 0.1
    assert found.force_difference[0] == pytest.approx(0.1, rel=1e-6)


def test_points_are_those_asked_for():
    system = random_system(6)
    hertz = first_frequency(system) * np.array([0.9, 1.0, 1.1])
    response = solved_response(system, hertz, Options(1))
    found = audit_response(system, response, points=[2, 0], samples=256)
    np.testing.assert_array_equal(found.frequency, response.frequency[[2, 0]])
    every = audit_response(system, response, samples=256)
    np.testing.assert_array_equal(found.excitation_power, every.excitation_power[[2, 0]])


def test_what_does_not_fit_is_refused(solved):
    system, response = solved
    refused("points: given 1: there are 1", audit_response, system, response, points=[1])
    with pytest.raises(InputError, match="samples: given 1000: a power of two, at least 256"):
        audit_response(system, response, samples=1000)
    refused("other coordinates or contacts", audit_response, random_system(1, contacts=7), response)
