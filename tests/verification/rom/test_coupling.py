"""Coupled, uncoupled and constant-load balances of the vane: alike in full stick, apart in slip."""

import numpy as np
import pytest

from tests.conftest import FULL
from tests.nonlinear.systems import solved_response
from tests.verification.vane import highest, interlocked, second_mode
from vanelock.nonlinear import STUCK, Options, static_response

COUPLINGS = ("coupled", "uncoupled", "constant-load")


@pytest.mark.parametrize("mu", [0.15, 50.0])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_full_stick(scene, mu, harmonics, record):
    # With the smaller friction the interlock's contacts slide at assembly: the mean of what they
    # then carry relaxes under vibration, which the coupled balance alone follows.
    system = interlocked(scene.system, mu, load=1e-3 if mu < 1 else 3e-3)
    slid = int(static_response(system).active[0])
    record("contacts that slid at assembly", str(slid))
    assert (slid > 0) == (mu < 1)
    hertz = second_mode(scene.system)[1] + np.linspace(-6.0, 6.0, 25)
    coupled, *others = (
        solved_response(system, hertz, Options(harmonics, coupling=c)) for c in COUPLINGS
    )
    assert np.all(coupled.state == STUCK)
    moving = np.abs(coupled.contact[:, 1:]).max()
    pull = np.abs(coupled.force[:, 1:]).max()
    rest = np.abs(coupled.force[:, 0, scene.interlock]).max()
    for name, other in zip(COUPLINGS[1:], others, strict=True):
        assert other.converged.all()
        assert np.all(other.state == STUCK)
        apart = np.abs(other.contact - coupled.contact)[:, 1:].max() / moving
        force = np.abs(other.force - coupled.force)[:, 1:].max() / pull
        mean = np.abs(other.force - coupled.force)[:, 0].max() / rest
        record(f"{name}, h >= 1", f"{max(apart, force):.1e}")
        record(f"{name}, mean force", f"{mean:.1e} of the interlock's largest")
        assert apart < 1e-10
        assert force < 1e-10
        if slid:
            assert 1e-4 < mean < 0.2
        else:
            assert mean < 1e-9


def peaks(scene, record, harmonics=1, **changes):
    low, high, _ = second_mode(scene.system)
    system, found = interlocked(scene.system, **changes), {}
    for coupling in COUPLINGS:
        frequency, size = highest(
            system, (low - 4, high + 4), Options(harmonics, coupling=coupling)
        )
        found[coupling] = frequency, size
        record(coupling, f"{1e6 * size:.4g} um at {frequency:.2f} Hz")
    return found


@pytest.mark.parametrize("mu", [0.05, 0.15, 0.3, 0.6] if FULL else [0.05, 0.6])
def test_uncoupled_peaks_are_higher_in_frequency_and_lower_by_friction(scene, mu, record):
    # The small vane's contacts open at 0.6: by one harmonic its peaks lie 0.4 Hz the other way.
    harmonics = 1 if FULL or mu < 0.6 else 3
    found = peaks(scene, record, harmonics, mu=mu)
    assert found["uncoupled"][0] > found["coupled"][0]
    assert found["uncoupled"][1] < found["coupled"][1]
    if mu <= 0.15:  # gross slip: a load that varies damps better than the same constant one
        assert found["constant-load"][1] > found["uncoupled"][1]


@pytest.mark.parametrize("interference", [1e-6, 2e-6, 4e-6, 8e-6] if FULL else [2e-6, 8e-6])
def test_uncoupled_peaks_are_higher_in_frequency_and_lower_by_interference(
    scene, interference, record
):
    found = peaks(scene, record, v0=interference)
    assert found["uncoupled"][0] > found["coupled"][0]
    assert found["uncoupled"][1] < found["coupled"][1]
