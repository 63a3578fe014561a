"""Responses to an accuracy: harmonics and frequencies chosen by their errors, errors by source."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import (
    gap_oscillator,
    sliding_system,
    solved_response,
    stuck_stiffness,
    with_contacts,
)
from tests.refusals import refused
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SOURCES,
    Diameter,
    Force,
    Options,
    Shares,
    adaptive_response,
    peak_errors,
)
from vanelock.nonlinear.adaptive.interpolant import Interpolant
from vanelock.rom.errors import Neglected


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


@pytest.mark.parametrize(("accuracy", "case"), [
    (3e-2, {"preload": 0.3}), (1e-2, {"amplitude": 3.0}), (1e-3, {}), (1e-3, {"preload": 0.3})
])  # fmt: skip
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
    best = solved_response(system, near, Options(19)).amplitude[:, 0, 0]
    assert abs(peak.amplitude / best.max() - 1) < accuracy
    assert abs(peak.frequency / near[best.argmax()] - 1) < accuracy
    assert peak.total < 1.2 * accuracy
    # Between its points the curve is as good.
    grid = np.linspace(0.141, 0.219, 40)
    dense = solved_response(system, grid, Options(19)).amplitude[:, 0, 0]
    curve = Interpolant(found.frequency, estimates.amplitude, estimates.slope)
    assert np.abs(curve.at(grid) - dense).max() < 2 * accuracy * best.max()


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
        solved_response(system, near, Options(H)).amplitude[:, 0, 0].max() for H in (15, 3)
    )
    assert few > 1.02 * exact
    shares = Shares(6e-4, 3e-4)
    found = adaptive_response(Asked(system), (0.14, 0.22), shares, monitor=(0, 0))
    assert abs(peak_errors(found).amplitude / exact - 1) < 1e-3


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
    up = solved_response(system, (low, high), Options(3))
    found = adaptive_response(
        lambda _: system, (low, high), Shares(1e-2, 1e-2), Options(3), monitor=(0, 0)
    )
    largest = up.amplitude[:, 0, 0].max()
    assert peak_errors(found).amplitude > 0.98 * largest
    softened = softening()
    down, upwards = (
        solved_response(softened, (0.7 * low, high), Options(3, direction=way))
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
    up, down = (solved_response(system, hertz, Options(1, direction=way)) for way in ("up", "down"))
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


@pytest.mark.parametrize("coupling", ["uncoupled", "constant-load"])
def test_pinned_harmonics_give_the_plain_response(coupling):
    system, hertz = sliding_system(preload=0.3), np.linspace(0.17, 0.19, 4)
    plain = solved_response(system, hertz, Options(3, coupling=coupling))
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
    best = solved_response(system, hertz, replace(options, harmonics=19)).amplitude[:, 0, 0]
    assert np.abs(size / best - 1).max() < 1e-3
    wave = solved_response(system, hertz, Options(19)).amplitude[:, 0, 0]
    assert np.abs(size / wave - 1).max() > 2e-3
    plain = solved_response(system, hertz, replace(options, harmonics=3))
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
    refused("a range is", adaptive_response, given, (2.0, 1.0), shares)
    mute = {k: replace(d, output=None) for k, d in system.diameters.items()}
    silent = replace(system, diameters=mute, output_names=())
    refused("has no output nodes", adaptive_response, lambda _: silent, (1.0, 2.0), shares)


HERTZ = np.linspace(0.165, 0.195, 13)
LOOSE = Shares(0.5, 0.5)


def _amplitude(response):
    return np.asarray(response.amplitude[:, 0, 0])


def _estimated(response, source):
    assert response.estimates is not None
    assert response.converged.all()
    np.testing.assert_allclose(response.estimates.amplitude, _amplitude(response), rtol=1e-9)
    return np.asarray(response.estimates.change[:, SOURCES.index(source)])


@pytest.mark.parametrize("preload", [1.0, 0.3])
def test_neglected_harmonics(preload):
    system = sliding_system(preload=preload)
    best = _amplitude(solved_response(system, HERTZ, Options(19)))
    greatest = []
    for H in (1, 3, 5):
        found = adaptive_response(lambda _: system, HERTZ, LOOSE, Options(H), monitor=(0, 0))
        estimated, made = _estimated(found, "harmonics"), best - _amplitude(found)
        greatest.append(np.abs(made).max())
        np.testing.assert_allclose(estimated, made, atol=0.5 * np.abs(made).max())
        # The highest point's is measured, and what is beyond allowed for.
        top = int(np.argmax(_amplitude(found)))
        assert 0.6 < estimated[top] / made[top] < 2.0
    assert greatest[0] > 5 * greatest[2]


def _softened(system, share):
    """The system without a share of one spring at every diameter, and a record of that."""
    missing = share * np.array([[1.0, -0.5], [-0.5, 1.5]])
    none = np.zeros_like(missing)
    diameters = {k: replace(d, K=d.K - missing) for k, d in system.diameters.items()}
    form = np.stack([missing, none, none])
    return replace(system, diameters=diameters), lambda _: Neglected(
        ((np.arange(2), form, np.inf),)
    )


def test_neglected_compliance():
    system = sliding_system()
    softer, neglected = _softened(system, 1e-4)
    found = adaptive_response(
        lambda _: system, HERTZ, LOOSE, Options(9), monitor=(0, 0), neglected=neglected
    )
    estimated = _estimated(found, "modes")
    made = _amplitude(solved_response(softer, HERTZ, Options(9))) - _amplitude(found)
    assert np.abs(made / _amplitude(found)).max() > 1e-4
    np.testing.assert_allclose(estimated, made, atol=0.05 * np.abs(made).max())


def test_mesh_that_is_too_stiff():
    # Without slip or interference every natural frequency falls by a share if masses grow by two.
    system = sliding_system(mu=100.0)
    share = 1e-5
    asked = []

    def mesh_error(diameter, hertz):
        asked.append((diameter, len(hertz)))
        return np.full(len(hertz), share)

    found = adaptive_response(
        lambda _: system, HERTZ, LOOSE, Options(1), monitor=(0, 0), mesh_error=mesh_error
    )
    heavier = {k: replace(d, M=d.M * (1 + 2 * share)) for k, d in system.diameters.items()}
    best = _amplitude(solved_response(replace(system, diameters=heavier), HERTZ, Options(1)))
    estimated, made = _estimated(found, "mesh"), best - _amplitude(found)
    near = np.abs(made) > 0.5 * np.abs(made).max()  # where inertia and stiffness are alike
    np.testing.assert_allclose(estimated[near], made[near], rtol=0.2)
    assert set(asked) == {(1, 2)}


def test_samples():
    system, options = sliding_system(preload=0.3), Options(3, samples=128)
    found = adaptive_response(lambda _: system, HERTZ, LOOSE, options, monitor=(0, 0))
    best = _amplitude(solved_response(system, HERTZ, Options(3)))
    estimated, made = _estimated(found, "samples"), best - _amplitude(found)
    assert np.abs(made / best).max() > 1e-6
    assert 0.8 < np.abs(estimated).max() / np.abs(made).max() < 1.25


def test_errors_of_a_peak():
    system = sliding_system()
    exact = adaptive_response(lambda _: system, (0.165, 0.195), Shares(1e-5, 1e-5), monitor=(0, 0))
    coarse = adaptive_response(
        lambda _: system, (0.165, 0.195), Shares(0.03, 0.03), Options(1), monitor=(0, 0)
    )
    best, estimated = peak_errors(exact), peak_errors(coarse)
    assert best.total < 1e-4
    made = abs(estimated.amplitude / best.amplitude - 1)
    assert 0.3 < estimated.total / made < 10
    shifted = np.nansum(list(estimated.frequency_error.values()))
    assert abs(estimated.frequency / best.frequency - 1) < 3 * shifted
    assert estimated.sources == (*SOURCES, "frequencies")
    assert np.isnan(estimated.amplitude_error["mesh"])
    assert coarse.estimates is not None
    ends = coarse.at([0, 1, 2])
    assert np.isnan(peak_errors(ends).amplitude_error["frequencies"])
    plain = solved_response(system, HERTZ[:3], Options(1))
    assert np.isnan(plain.error).all()
    refused("peak_errors: the response has no error estimates", peak_errors, plain)


def test_the_error_of_a_peak_takes_nothing_from_beyond_a_jump():
    """A straight branch of slope 2 /Hz that ends at 4.5 of a curve in hertz, and a parabola."""
    system = sliding_system()
    solved = adaptive_response(lambda _: system, np.linspace(0.17, 0.19, 9), Shares(0.1, 0.1))
    assert solved.estimates is not None
    f = np.arange(9.0)

    def drawn(amplitude, slope):
        estimates = replace(
            solved.estimates, amplitude=amplitude, slope=slope, change=np.zeros((9, len(SOURCES)))
        )
        return replace(solved, frequency=f, estimates=estimates, jump=np.array([[4, 5]]))

    hill, rising = 8 - (f - 3) ** 2, 2 * f
    top = drawn(np.where(f < 5, hill, 4.0), np.where(f < 5, -2 * (f - 3), 0.0))
    found = peak_errors(top)  # a parabola is interpolated exactly
    assert found.amplitude_error["frequencies"] == pytest.approx(0, abs=1e-12)
    end = drawn(np.where(f < 5, rising, 1.0), np.where(f < 5, 2.0, 0.0))
    found = peak_errors(end)  # the branch may go on for 1 Hz, and by 2 of 8
    assert found.amplitude == 8
    assert found.amplitude_error["frequencies"] == pytest.approx(2 / 8)
    assert found.frequency_error["frequencies"] == pytest.approx(1 / 4)
