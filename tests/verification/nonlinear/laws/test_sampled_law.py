"""The contact law on plain samples against the one with located events, by number of samples."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import FULL
from vanelock.nonlinear import SLIP, SLIP_OPEN
from vanelock.nonlinear.contact.law import contact_law
from vanelock.nonlinear.fourier import basis
from vanelock.rom import Contacts

COUNT = 2000 if FULL else 200


def draw(harmonics):
    """Contacts that slip, lift off or both, μ from 0.1 to 3."""
    rng = np.random.default_rng([5, harmonics])
    made = Contacts(
        kn=rng.uniform(0.5, 2, COUNT),
        kt=rng.uniform(0.5, 2, (COUNT, 2)),
        mu=rng.choice([0.1, 0.3, 1.0, 3.0], COUNT),
        v0=np.zeros(COUNT),
    )
    falling = np.repeat(np.arange(harmonics + 1), 2)[1:].clip(1)
    u = rng.normal(size=(COUNT, 3, 2 * harmonics + 1)) / falling
    u[:, 0, 0] += rng.uniform(-1, 4, COUNT)
    return made, u


def spread(error):
    return f"median {np.median(error):.1e}, 95 % {np.quantile(error, 0.95):.1e}"


@pytest.mark.parametrize("harmonics", [1, 3, 5])
def test_error_by_number_of_samples(harmonics, record):
    made, u = draw(harmonics)
    exact = contact_law(made, harmonics)(u)
    size = np.abs(u).max(axis=(1, 2))
    steep = np.abs(exact.jacobian).max(axis=(1, 2, 3, 4)).clip(1.0)
    groups = {"slipping": exact.state == SLIP, "opening": exact.state == SLIP_OPEN}
    medians: dict[str, list[float]] = {name: [] for name in groups}
    for samples in (64, 128, 256, 1024):
        found = contact_law(made, harmonics, samples)(u)
        error = np.abs(found.w - exact.w).max(axis=(1, 2)) / size
        bent = np.abs(found.jacobian - exact.jacobian).max(axis=(1, 2, 3, 4)) / steep
        for name, own in groups.items():
            medians[name].append(np.median(error[own]))
            record(
                f"{samples} samples, {np.sum(own)} {name}",
                f"{spread(error[own])}, largest {error[own].max():.1e} "
                f"(Jacobian {spread(bent[own])})",
            )
    # Touch-downs between samples make it of first order, slip alone of second.
    assert medians["slipping"][3] < 0.02 * medians["slipping"][0]
    assert medians["opening"][3] < 0.2 * medians["opening"][0]
    assert medians["slipping"][1] < 1e-3
    assert medians["opening"][1] < 1e-2


@pytest.mark.parametrize("harmonics", [1, 3, 5, 9])
def test_located_events_do_not_depend_on_what_brackets_them(harmonics, record):
    made, u = draw(harmonics)
    law = contact_law(made, harmonics)
    exact = law(u)
    size = np.abs(u).max(axis=(1, 2))
    steep = np.abs(exact.jacobian).max(axis=(1, 2, 3, 4)).clip(1.0)
    for count in (max(32, 8 * harmonics), 37 * harmonics, 256, 4096):
        table = basis(harmonics, 2 * np.pi * np.arange(count) / count)
        other = replace(law, table=table)(u)
        error = (np.abs(other.w - exact.w).max(axis=(1, 2)) / size).max()
        bent = (np.abs(other.jacobian - exact.jacobian).max(axis=(1, 2, 3, 4)) / steep).max()
        record(f"{count} brackets", f"{error:.1e} (Jacobian {bent:.1e})")
        assert error < 1e-10
        assert bent < 1e-8
