"""Responses to an accuracy: harmonics and frequencies chosen by their errors."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import gap_oscillator, sliding_system, stuck_stiffness, with_contacts
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Diameter,
    Force,
    Options,
    Shares,
    adaptive_response,
    frequency_response,
    peak_errors,
)
from vanelock.nonlinear.adaptive import sampling
from vanelock.nonlinear.adaptive.interpolant import Interpolant


class Asked:
    """Systems by number of harmonics, with no diameters but those needed; notes what is asked."""

    def __init__(self, system):
        self.system = system
        self.harmonics: list[int] = []

    def __call__(self, harmonics):
        """The system that they need."""
        self.harmonics.append(harmonics)
        N = self.system.sectors
        excited = self.system.force
        needed = {self.system.nodal_diameter(h) for h in (*range(harmonics + 1), *excited)}
        needed = {folded(k, N) for k in needed}
        kept = {k: d for k, d in self.system.diameters.items() if k in needed}
        return replace(self.system, diameters=kept)


@pytest.mark.parametrize(
    ("accuracy", "case"),
    [(3e-2, {"preload": 0.3}), (1e-2, {"amplitude": 3.0}), (1e-3, {}), (1e-3, {"preload": 0.3})],
)
def test_peak_and_curve_are_as_exact_as_asked(case, accuracy):
    system = sliding_system(**case)
    systems = Asked(system)
    shares = Shares(0.6 * accuracy, 0.3 * accuracy)
    found = adaptive_response(systems, (0.14, 0.22), shares, monitor=(0, 0))
    estimates = found.estimates
    assert estimates is not None
    assert found.converged.all()
    assert systems.harmonics == sorted(set(systems.harmonics))  # growing, and none twice
    ahead = 2 if accuracy > 0.02 else 6  # how far resonances are looked for
    assert systems.harmonics[-1] == estimates.tried <= found.harmonics + ahead
    assert estimates.harmonics.max() == found.harmonics
    peak = peak_errors(found)
    near = peak.frequency * np.linspace(0.995, 1.005, 41)
    best = frequency_response(system, near, Options(19), find_jumps=False).amplitude[:, 0, 0]
    assert abs(peak.amplitude / best.max() - 1) < accuracy
    assert abs(peak.frequency / near[best.argmax()] - 1) < accuracy
    assert peak.total < 1.2 * accuracy
    # Between its points the curve is as good.
    grid = np.linspace(0.141, 0.219, 40)
    dense = frequency_response(system, grid, Options(19), find_jumps=False).amplitude[:, 0, 0]
    curve = Interpolant(found.frequency, estimates.amplitude, estimates.slope)
    assert np.abs(curve.at(grid) - dense).max() < 2 * accuracy * best.max()


def test_more_accuracy_costs_more_points_and_harmonics():
    system, spent = sliding_system(), []
    for accuracy in (3e-2, 1e-3, 1e-4):
        shares = Shares(accuracy, accuracy)
        found = adaptive_response(lambda _: system, (0.14, 0.22), shares, monitor=(0, 0))
        assert found.estimates is not None
        spent.append((found.points, int(found.estimates.harmonics.sum())))
        least, most = found.estimates.harmonics.min(), found.estimates.harmonics.max()
    assert spent == sorted(spent)
    assert (least, most) != (most, most)  # each point as many as it needs
    fewer = found.estimates.harmonics < found.harmonics
    assert np.all(found.output[fewer, found.harmonics] == 0)


def test_without_slip_one_harmonic_is_enough():
    systems = Asked(sliding_system(mu=100.0))
    found = adaptive_response(systems, (0.14, 0.22), Shares(1e-3, 1e-3), monitor=(0, 0))
    assert systems.harmonics == [1]
    assert found.harmonics == 1
    assert np.all(found.error < 1e-12)


def test_a_resonance_of_a_harmonic_far_ahead_is_found():
    # At its own diameter harmonic 9 meets a mode; nothing at the diameters before it shows that.
    plain = sliding_system(sectors=24)
    mode = 9 * 2 * np.pi * 0.16856
    own = plain.diameters[9]
    factor = la.eigh(stuck_stiffness(plain, 9), own.M, eigvals_only=True)[0] / mode**2
    system = replace(plain, diameters=plain.diameters | {9: replace(own, M=own.M * factor)})
    near = np.linspace(0.1675, 0.1695, 41)
    exact, few = (
        frequency_response(system, near, Options(H), find_jumps=False).amplitude[:, 0, 0].max()
        for H in (15, 3)
    )
    assert few > 1.02 * exact
    shares = Shares(6e-4, 3e-4)
    found = adaptive_response(Asked(system), (0.14, 0.22), shares, monitor=(0, 0))
    assert abs(peak_errors(found).amplitude / exact - 1) < 1e-3


def test_a_crowded_curve_gets_its_last_points_where_it_is_high(monkeypatch):
    system, shares = sliding_system(), Shares(1e-4, 1e-6)
    many = adaptive_response(lambda _: system, (0.1, 0.3), shares, monitor=(0, 0))
    monkeypatch.setattr(sampling, "_CROWD", 48)
    few = adaptive_response(lambda _: system, (0.1, 0.3), shares, monitor=(0, 0))
    assert few.points == 48 < many.points
    assert peak_errors(few).amplitude == pytest.approx(peak_errors(many).amplitude, rel=1e-5)


def test_a_force_at_a_higher_harmonic_begins_there_or_is_refused():
    system = sliding_system()
    size = len(system.at(system.nodal_diameter(3)).K)
    system = replace(system, force={**system.force, 3: Force(np.full(size, 0.01 + 0j))})
    shares, hertz = Shares(1e-2, 1e-2), [0.1]
    with pytest.raises(InputError, match="harmonics: given 1: the system has force/3"):
        adaptive_response(lambda _: system, hertz, shares, Options(1), monitor=(0, 0))
    systems = Asked(system)
    found = adaptive_response(systems, hertz, shares, monitor=(0, 0))
    assert systems.harmonics[:2] == [1, 3]
    assert found.estimates is not None
    assert found.estimates.harmonics.min() >= 3
    assert np.all(found.x[3] != 0)


def test_diameters_that_are_not_there_are_stood_in_for():
    # Sizes of the matrices may differ between diameters: here one has an idle coordinate more.
    system = sliding_system()

    def larger(d):
        def grown(a):
            return np.concatenate([a, np.zeros((*a.shape[:-1], 1))], axis=-1)

        K, M = (np.block([[a, np.zeros((2, 1))], [np.zeros((1, 2)), 1.0]]) for a in (d.K, d.M))
        return Diameter(K, M, grown(d.own), grown(d.next), output=grown(d.output))

    mixed = system.diameters | {3: larger(system.diameters[3])}
    mixed_system = replace(system, diameters=mixed)
    shares = Shares(1e-4, 1e-3)
    hertz = np.linspace(0.17, 0.19, 5)
    whole = adaptive_response(lambda _: mixed_system, hertz, shares, monitor=(0, 0))
    piece = adaptive_response(Asked(mixed_system), hertz, shares, monitor=(0, 0))
    assert whole.harmonics >= 5
    np.testing.assert_allclose(piece.amplitude, whole.amplitude, rtol=1e-4)


def softening():
    """A mass between springs, one of which opens."""
    return with_contacts(stopped(), v0=np.ones(1))


def stopped():
    """A mass with a gap to a stop: its curve bends over and folds twice."""
    stuck = gap_oscillator(C=None, damping_ratio=0.01)
    return replace(stuck, damping_joints="stuck")


def test_curve_takes_the_larger_of_two_solutions():
    # Hardening: upwards the upper branch is kept to its end. Mirrored, it is found from above.
    system = stopped()
    low, high = 0.9 / (2 * np.pi), 1.5 / (2 * np.pi)
    up = frequency_response(system, (low, high), Options(3), find_jumps=False)
    found = adaptive_response(
        lambda _: system, (low, high), Shares(1e-2, 1e-2), Options(3), monitor=(0, 0)
    )
    largest = up.amplitude[:, 0, 0].max()
    assert peak_errors(found).amplitude > 0.98 * largest
    softened = softening()
    down, upwards = (
        frequency_response(softened, (0.7 * low, high), Options(3, direction=way), find_jumps=False)
        for way in ("down", "up")
    )
    assert down.amplitude.max() > 1.05 * upwards.amplitude.max()  # the sweep upwards misses it
    found = adaptive_response(
        lambda _: softened, (0.7 * low, high), Shares(1e-2, 1e-2), Options(3), monitor=(0, 0)
    )
    assert found.amplitude.max() > 0.98 * down.amplitude.max()


def test_listed_frequencies_take_the_larger_of_two_solutions():
    # Softening: downwards the upper branch is kept to its end.
    system = softening()
    hertz = np.linspace(0.63, 1.5, 59)[::-1] / (2 * np.pi)
    up, down = (
        frequency_response(system, hertz, Options(1, direction=way), find_jumps=False)
        for way in ("up", "down")
    )
    larger = np.maximum(up.amplitude, down.amplitude)[:, 0, 0]
    assert np.sum(larger > 1.05 * up.amplitude[:, 0, 0]) > 2  # the sweep upwards misses these
    found = adaptive_response(
        lambda _: system, hertz, Shares(1e-2, 1e-2), Options(1), monitor=(0, 0)
    )
    np.testing.assert_allclose(found.amplitude[:, 0, 0], larger, rtol=1e-6)
    assert found.direction == "both"
    assert found.jump is not None
    jumped = found.frequency[found.jump]
    assert len(jumped)
    assert np.all(jumped[:, 0] < jumped[:, 1])


def test_listed_frequencies_without_a_jump_are_swept_once():
    seen: list[float] = []
    found = adaptive_response(
        lambda _: sliding_system(preload=0.3),
        np.linspace(0.17, 0.19, 5),
        Shares(1e-2, 1e-2),
        monitor=(0, 0),
        progress=lambda done, total, hertz, size: seen.append(hertz),
    )
    assert seen == sorted(found.frequency)
    assert found.direction == "up"


@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_pinned_harmonics_give_the_plain_response(coupling):
    system, hertz = sliding_system(preload=0.3), np.linspace(0.17, 0.19, 4)
    plain = frequency_response(system, hertz, Options(3, coupling=coupling), find_jumps=False)
    found = adaptive_response(
        lambda _: system, hertz, Shares(1e-9, 1e-9), Options(3, coupling=coupling)
    )
    np.testing.assert_allclose(found.output, plain.output, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.contact[:, 0], plain.contact[:, 0], rtol=1e-8)


def test_harmonics_at_one_diameter_are_chosen_and_judged_there():
    system, hertz = sliding_system(), np.linspace(0.16, 0.2, 9)
    options = Options(harmonic_diameters="sector")
    two = replace(system, diameters={k: system.diameters[k] for k in (0, 1)})
    found = adaptive_response(lambda _: two, hertz, Shares(1e-3, 1e-3), options, (0, 0))
    assert set(found.harmonic_diameters) == {0, 1}
    assert found.harmonics > 1
    size = found.amplitude[:, 0, 0]
    best = frequency_response(
        system, hertz, replace(options, harmonics=19), find_jumps=False
    ).amplitude[:, 0, 0]
    assert np.abs(size / best - 1).max() < 1e-3
    wave = frequency_response(system, hertz, Options(19), find_jumps=False).amplitude[:, 0, 0]
    assert np.abs(size / wave - 1).max() > 2e-3
    plain = frequency_response(system, hertz, replace(options, harmonics=3), find_jumps=False)
    pinned = adaptive_response(
        lambda _: two, hertz, Shares(1e-9, 1e-9), replace(options, harmonics=3)
    )
    np.testing.assert_allclose(pinned.contact, plain.contact, rtol=0, atol=1e-10)


def test_what_cannot_be_is_refused():
    system = sliding_system()
    given = lambda _: system  # noqa: E731
    shares = Shares(0.1, 0.1)
    with pytest.raises(InputError, match=r"shares.harmonics: given 0.0: allowed are numbers"):
        adaptive_response(given, (1.0, 2.0), Shares(0.0, 0.1))
    with pytest.raises(InputError, match="a range is"):
        adaptive_response(given, (2.0, 1.0), shares)
    mute = {k: replace(d, output=None) for k, d in system.diameters.items()}
    silent = replace(system, diameters=mute, output_names=())
    with pytest.raises(InputError, match="has no output nodes"):
        adaptive_response(lambda _: silent, (1.0, 2.0), shares)
