"""Wear over cycles: rates against the slip of loops, where a joint opens, and what is refused."""

import numpy as np
import pytest

from tests.nonlinear.systems import even, with_contacts
from tests.refusals import refused
from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contact,
    Dwell,
    Options,
    System,
    WearHistory,
    frequency_response,
    static_response,
    wear_history,
)


def ring(seed):
    """A ring whose friction is the same in all directions of the plane, and its peak, Hz."""
    _, force, hertz = next(iter(worst_of(seed).values()))
    return even(loaded(spring_ring(seed), force)), float(hertz)


def mass_on_foot(K, **loads):
    """Masses of 1 kg, the first of which slides and is pressed on by the last."""
    foot = {"normal": len(K) - 1, "mu": 0.5, "kt": 1.0, "kn": 2.0, "preload": 2.0, "name": "foot"}
    contacts = [Contact(tangential=0, **foot)]
    return System.from_matrices(np.eye(len(K)), K, contacts, damping_ratio=0.01, **loads)


def test_a_joint_opens_where_its_interference_says(tmp_path):
    """A contact held off by a static force: n = s (v0 - v_open), s = kn ks / (kn + ks)."""
    # An impact-free contact would never open; it is pushed apart by its own normal vibration.
    system, seen = mass_on_foot(np.eye(2), force={0: 1.0, 1: 0.4}, static_force={1: -0.2}), []
    dwell = Dwell(1e6, frequency=0.1)
    found = wear_history(
        system, dwell, 1e-3, 1.0, Options(3), ("x0", 0), progress=lambda *now: seen.append(now)
    )
    assert found.status == "preload lost"
    assert found.joints == ("foot",)
    assert found.cycles_to_loss == found.cycles[-1] < 1e6
    np.testing.assert_allclose(found.interference[-1], 0.2, rtol=1e-6)
    np.testing.assert_allclose(found.rest_load[0], (1 - 0.2) * 2 / 3, rtol=1e-8)
    np.testing.assert_allclose(found.rest_load[-1], 0.0, atol=1e-8)
    assert len(seen) == len(found.cycles)
    worn = with_contacts(system, v0=found.interference[3])
    load = static_response(worn).force[0, 0, 0, 0].real
    np.testing.assert_allclose(load, found.rest_load[3, 0], rtol=1e-9)
    again = frequency_response(worn, [0.1], Options(3))
    assert again.amplitude[0, 0, 0] == pytest.approx(found.amplitude[3], rel=1e-8)
    found.save(tmp_path / "wear.h5")
    np.testing.assert_array_equal(WearHistory.load(tmp_path / "wear.h5").rate, found.rate)


def test_force_of_a_dwell_scales_the_excitation():
    system, hertz = ring(0)
    dwells = [Dwell(10.0, frequency=hertz), Dwell(10.0, frequency=hertz, force=0.5)]
    found = wear_history(system, dwells, 1e-6, 1.0, Options(1), ("masses", 0))
    begins = int(np.argmax(found.dwell == 1))
    assert found.cycles[begins] == found.cycles[begins - 1] == 10.0
    half = with_contacts(loaded(system, 0.5), v0=found.interference[begins])
    expected = frequency_response(half, [hertz], Options(1)).amplitude[0, 0, 0]
    assert found.amplitude[begins] == pytest.approx(expected, rel=1e-9)


def two_peaks():
    """Two masses, the first of which slides; its output peaks at 0.24 Hz and, less, at 0.34 Hz."""
    K = np.array([[1.5, -0.5, 0.0], [-0.5, 4.5, 0.0], [0.0, 0.0, 1.0]])
    return mass_on_foot(K, force={0: 0.02, 1: 0.15})


def test_a_peak_that_became_higher_is_found_at_the_end_of_a_dwell():
    """Less preload damps the first peak more: from 0.37 m to below the other one."""
    system, near = two_peaks(), (0.18, 0.4)
    dwells = [Dwell(1e4, near=near), Dwell(1e5, near=near)]
    found = wear_history(system, dwells, 1e-4, 1.0, Options(3), ("x0", 0))
    ends = np.append(np.flatnonzero(np.diff(found.dwell)), len(found.cycles) - 1)
    assert np.isnan(found.higher_amplitude[:-1]).all()
    assert len(ends) == 2
    other = float(found.higher_frequency[-1])
    assert found.amplitude[-1] < found.higher_amplitude[-1] < found.amplitude[0]
    worn = found.system_at(system, -1)
    response = frequency_response(worn, other * np.linspace(0.98, 1.02, 41), Options(3))
    assert response.amplitude[:, 0, 0].max() == pytest.approx(found.higher_amplitude[-1], rel=1e-4)
    assert other == pytest.approx(0.34, rel=0.01)


def test_a_dwell_without_a_peak_ends_the_history():
    dwells = [Dwell(1e4, near=(0.18, 0.4)), Dwell(1e4, near=(0.05, 0.06))]
    found = wear_history(two_peaks(), dwells, 1e-4, 1.0, Options(1), ("x0", 0))
    assert found.status == "solution lost"
    assert np.isnan(found.cycles_to_loss)
    assert found.cycles[-1] == 1e4
    assert not found.dwell.any()


def test_what_does_not_wear_keeps_its_interference():
    system, hertz = ring(1)
    found = wear_history(system, Dwell(50.0, frequency=hertz), [1e-4, 0.0], 1.0, Options(1))
    assert np.all(np.diff(found.interference[:, 0]) < 0)
    np.testing.assert_array_equal(found.interference[:, 1], system.contacts.v0[1])
    still = wear_history(system, Dwell(50.0, frequency=hertz), 0.0, 1.0, Options(1))
    np.testing.assert_array_equal(still.interference[-1], system.contacts.v0)
    assert still.cycles.tolist() == [0.0, 50.0]


@pytest.mark.parametrize(("given", "message"), [
    ({"dwells": []}, r"dwells: given \[\]: needs a Dwell"),
    ({"dwells": [3.0]}, r"dwells\[0\]: given 3.0: needs a Dwell"),
    ({"coefficient": -1.0}, r"coefficient: given -1 m²/N: must be >= 0"),
    ({"coefficient": [1.0, 2.0, 3.0]}, r"coefficient: given shape \(3,\): needs a number"),
    ({"area": 0.0}, r"area: given 0 m²: must be > 0"),
    ({"area": np.nan}, r"area: given nan: must be finite"),
    ({"step": 0.9}, r"step: given 0.9: must be one number > 0 and <= 0.5"),
    ({"options": Options(0)}, r"harmonics: given 0: vibration needs at least 1"),
    ({"output": ("nowhere", 0)}, r"output: given 'nowhere': allowed: masses"),
    ({"dwells": Dwell(1.0, near=(1.0, 2.0))}, r"dwells\[0\]: given near = \(1, 2\) Hz: no peak"),
])  # fmt: skip
def test_bad_input_is_one_line(given, message):
    system, hertz = ring(0)
    asked = {"dwells": Dwell(1.0, frequency=hertz), "coefficient": 1e-6, "area": 1.0}
    refused(message, wear_history, system, **{"options": Options(1), **asked, **given})


def test_no_friction_no_wear_is_said():
    system, hertz = ring(0)
    smooth = with_contacts(system, mu=np.array([0.4, 0.0]))
    with pytest.raises(InputError, match="contact 1, whose mu is 0"):
        wear_history(smooth, Dwell(1.0, frequency=hertz), 1e-6, 1.0)


@pytest.mark.parametrize(("given", "message"), [
    ({"cycles": 0.0, "frequency": 1.0}, r"Dwell.cycles: given 0.0: must be one number > 0"),
    ({"cycles": 1.0}, r"Dwell: given none of frequency and near: needs one of them"),
    ({"cycles": 1.0, "frequency": 1.0, "near": (1.0, 2.0)}, r"Dwell: given both of frequency"),
    ({"cycles": 1.0, "frequency": -1.0}, r"Dwell.frequency: given -1.0: must be one number"),
    ({"cycles": 1.0, "near": (2.0, 1.0)}, r"Dwell.near: given \(2.0, 1.0\): a range is"),
    ({"cycles": 1.0, "frequency": 1.0, "force": "a"}, r"Dwell.force: given 'a': needs an"),
])  # fmt: skip
def test_bad_dwells_are_refused(given, message):
    refused(message, Dwell, **given)
