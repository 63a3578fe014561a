"""Wear indicators against loops done by hand."""

import numpy as np
import pytest

from vanelock import nonlinear
from vanelock.nonlinear import Contacts, Diameter, Force, System
from vanelock.quantities.contacts import _travel, wear

K, KT, MU, N = 4e5, 2e6, 0.4, 50.0


def jenkins(force, constant=N):
    """A mass on a spring, dragged over a contact of constant normal load, at rest with it."""
    kn = 1e6
    own = np.zeros((1, 3, 2))
    own[0, 0, 1] = own[0, 1, 0] = 1
    return System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(np.diag([K, kn]), np.diag([1e-9, 1e-9]), own)},
        contacts=Contacts(
            kn=np.array([kn]),
            kt=np.array([[KT, KT]]),
            mu=np.array([MU]),
            v0=np.array([2 * constant / kn]),
            joint=("interlock",),
        ),
        force={1: Force(np.array([force + 0j, 0]))},
    )


@pytest.fixture(scope="module")
def loop():
    """Exact loop of a slider dragged by U cos θ at constant load: displacement, force."""
    U = 5 * MU * N / KT
    angle = 2 * np.pi * np.arange(4096) / 4096
    u, w = U * np.cos(angle), np.empty(4096)
    play, place = MU * N / KT, U - MU * N / KT  # after a first quarter it is at the lower bound
    for i, each in enumerate(np.concatenate([u, u])):
        place = min(max(place, each - play), each + play)
        w[i % 4096] = place
    displacement = np.column_stack([np.full(4096, 1e-5), u, np.zeros(4096)])
    force = np.column_stack([np.full(4096, N), KT * (u - w), np.zeros(4096)])
    return U, displacement, force


def test_slip_counts_in_the_plane_and_while_the_contact_is_closed(loop):
    """Of a Jenkins element it is four times what exceeds its play."""
    U, displacement, force = loop
    stiffness = np.array([1e6, KT, KT])
    slip = _travel(displacement, force, stiffness)
    assert slip == pytest.approx(4 * (U - MU * N / KT), rel=1e-5)
    both, pushed, opened = displacement.copy(), force.copy(), force.copy()
    both[:, 1:] = displacement[:, [1]] * [0.6, 0.8]
    pushed[:, 1:] = force[:, [1]] * [0.6, 0.8]
    assert _travel(both, pushed, stiffness) == pytest.approx(slip)
    opened[:2048] = 0
    assert _travel(displacement, opened, stiffness) == pytest.approx(slip / 2, rel=1e-2)


def test_solved_response_dissipates_what_its_slider_travels_under_load():
    response = nonlinear.frequency_response(jenkins(60.0), [10.0], nonlinear.Options(9))
    assert response.converged.all()
    found = wear(response, np.array([2e-6]), np.array([1e-15]))
    assert found.slip[0] > 0
    assert found.work[0] == pytest.approx(N * found.slip[0], rel=1e-4)
    # By hand: at constant load the slider travels 4 (U - μn/kt) and dissipates μn times that.
    U = np.ptp(nonlinear.contact_loop(response, 0, 0)[0][:, 1]) / 2
    assert found.slip[0] == pytest.approx(4 * (U - MU * N / KT), rel=1e-3)
    assert found.mean_load[0] == found.largest_load[0] == pytest.approx(N)
    assert found.mean_pressure[0] == pytest.approx(N / 2e-6)
    assert found.slip_per_hour[0] == pytest.approx(found.slip[0] * 36000)
    assert found.depth_per_hour[0] == pytest.approx(1e-15 * found.work[0] * 36000 / 2e-6)


def test_stuck_contact_travels_nowhere_and_sampled_friction_has_no_exact_slip():
    response = nonlinear.frequency_response(jenkins(1.0), [10.0], nonlinear.Options(3))
    unknown = np.full(1, np.nan)
    found = wear(response, unknown, unknown)
    assert found.slip[0] == found.work[0] == found.energy[0] == 0
    assert np.isnan(found.energy_per_area[0])
    assert np.isnan(found.volume_per_hour[0])
    response = nonlinear.frequency_response(
        jenkins(60.0), [10.0], nonlinear.Options(3, samples=256)
    )
    found = wear(response, unknown, unknown)
    assert np.isnan(found.slip[0])
    assert found.work[0] == found.energy[0] / MU > 0
