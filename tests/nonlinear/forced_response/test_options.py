"""What options there may be; undamped resonances; responses cut off go on to the same numbers."""

import time
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
import scipy.linalg as la

from tests.nonlinear.systems import (
    even,
    gap_oscillator,
    random_system,
    sliding_system,
    solved_response,
)
from tests.refusals import refused
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    Contact,
    Element,
    Options,
    Shares,
    System,
    adaptive_response,
    frequency_response,
    hysteresis,
    parameter_response,
    peak_bounds,
    peak_response,
    static_response,
)
from vanelock.nonlinear.balance.balance import structure
from vanelock.nonlinear.continuation.globalisation import from_nothing
from vanelock.nonlinear.forced_response import frequency_sweep
from vanelock.nonlinear.forced_response.linear_response import check_bound
from vanelock.nonlinear.fourier import TURN

PLANE: dict[str, object] = {"friction": "isotropic"}


@pytest.mark.parametrize(("given", "message"), [
    ({"harmonics": -1}, "harmonics: given -1: must be >= 0"),
    ({"harmonics": 2.5}, "harmonics: given 2.5: needs a whole number"),
    ({"coupling": "loose"}, "coupling: given 'loose': allowed: coupled, uncoupled, constant-l"),
    ({"friction": "round"}, "friction: given 'round': allowed: orthogonal, isotropic"),
    ({"harmonic_diameters": "own"}, "harmonic_diameters: given 'own': allowed: wave, sector"),
    ({"direction": "left"}, "direction: given 'left': allowed: up, down"),
    ({"samples": 7}, "samples: given 7: needs at least 8"),
    ({"samples": 15, "harmonics": 3}, "samples: given 15: needs at least 16"),
    ({"samples": 96} | PLANE, "samples: given 96: isotropic friction has its events located"),
    ({"static_beyond": 1.0}, "static_beyond: given 1.0: must be > 1"),
    ({"tolerance": 0.0}, "tolerance: given 0.0: must be > 0"),
    ({"effort": 0}, "effort: given 0: must be >= 1"),
])  # fmt: skip
def test_what_is_not_possible_is_refused_at_once(given, message):
    refused(message, Options, **given)


def test_too_few_samples_for_the_harmonics_by_default_are_refused():
    system, few = random_system(0), Options(samples=15)
    for solved in (
        lambda: solved_response(system, [1.0], few),
        lambda: hysteresis(system, [1.0, 2.0], few),
        lambda: parameter_response(system, 1.0, "force", [1.0], few),
        lambda: peak_response(system, "force", [1.0], (1.0, 2.0), few),
    ):
        refused("samples: given 15: needs at least 16", solved)


def test_what_cannot_be_honoured_is_refused_with_the_reason():
    system, hertz = gap_oscillator(), [0.15, 0.2]
    with pytest.raises(InputError, match="direction: given 'down': hysteresis is of both ways"):
        hysteresis(system, hertz, Options(direction="down"))
    with pytest.raises(InputError, match="static_beyond: given 4: adaptive_response does not est"):
        adaptive_response(lambda _: system, hertz, Shares(0.1, 0.1), Options(static_beyond=4))


def test_options_by_name_are_refused_where_unknown_or_beside_others():
    system = sliding_system()
    assert not len(frequency_response(system, np.linspace(0.14, 0.22, 30), harmonics=3).jump)
    with pytest.raises(InputError, match="options: given, and harmonics beside: needs one of both"):
        static_response(system, Options(), harmonics=1)
    with pytest.raises(InputError, match="harmonic: given to static_response: allowed: system, "):
        static_response(system, harmonic=1)


HERTZ = np.linspace(0.5, 2.5, 41) / (2 * np.pi)


def folding():
    """A mass on a spring that hardens: two solutions between two folds, and one between them."""
    spring = Element(force="cubic_spring", places=[0], parameters=[4.0])
    return System.from_matrices([[1.0]], [[1.0]], elements=[spring], C=[[0.02]], force={0: 0.1})


def test_what_a_sweep_loses_is_found_from_the_other_side(monkeypatch):
    options, heard = Options(3, direction="down"), []
    whole = solved_response(folding(), HERTZ, options)
    asked: list[float] = []

    def once(balance, *more):
        asked.append(balance.omega)
        found = from_nothing(balance, *more)
        return found if len(asked) == 1 else replace(found, converged=False, residual=1.0)

    monkeypatch.setattr(frequency_sweep, "from_nothing", once)

    def progress(done, total, hertz, amplitude):
        if np.isnan(amplitude):
            heard.append(hertz)

    found = solved_response(folding(), HERTZ, options, progress)
    assert len(asked) > 2  # the first one, and what lies below the fold
    np.testing.assert_allclose(found.amplitude, whole.amplitude, rtol=1e-9)
    assert set(np.round(heard, 9)) >= set(np.round(np.array(asked[1:]) / (2 * np.pi), 9))


K = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 4.0]])
M = np.diag([1.0, 1.5, 2.0])
SHARES = Shares(3e-2, 3e-2)


def slipping(load):
    """Three masses without damping that slip on the ground and on each other."""
    contacts = [
        Contact(tangential=0, second=1, kt=1.0, mu=0.3, preload=0.5),
        Contact(tangential=(1, 2), kt=2.0, mu=0.2, preload=1.5),
        Contact(tangential=2, kt=1.0, mu=0.0, preload=1.0),
    ]
    force = {0: 0.3 * load, 2: 0.7j * load}
    return System.from_matrices(M, K, contacts, force=force)


def limit(mode):
    """A mode's frequency, rad/s, and the load whose work is that of friction in large motion."""
    squares, shapes = la.eigh(K, M)
    a, b, c = shapes[:, mode]
    friction = 4 / np.pi * (0.15 * (abs(a) + abs(b)) + 0.3 * abs(b - c))
    return float(np.sqrt(squares[mode])), float(friction / abs(0.3 * a + 0.7j * c))


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_what_friction_holds_of_a_load_is_known_from_the_modes_that_slide(mode):
    omega, most = limit(mode)
    near = 0.97 * omega, 1.03 * omega
    check_bound(structure(slipping(0.999 * most), 1), near, None, "range")
    with pytest.raises(InputError, match=r"range: near \S+ Hz .* holds 0.999 of its load at most"):
        check_bound(structure(slipping(1.001 * most), 1), near, None, "range")
    damped = replace(slipping(2 * most), damping_ratio=1e-6)
    check_bound(structure(damped, 1), near, None, "range", omega)
    system, hertz = slipping(2 * most), (near[0] / TURN, near[1] / TURN)
    said = f"near {omega / TURN:.6g} Hz it grows without damping, and friction holds 0.5 of"
    with pytest.raises(InputError, match=f"frequencies: no largest amplitude .*: {said}"):
        adaptive_response(lambda _: system, hertz, SHARES)
    with pytest.raises(InputError, match="near: no largest amplitude .* at mu = 0.01: near"):
        peak_response(system, "mu", [0.01], hertz)
    with pytest.raises(InputError, match=f"near: no largest amplitude .* at zero: {said}"):
        peak_bounds(system, hertz, Options(1))


def test_peaks_by_force_end_where_friction_holds_no_more():
    omega, most = limit(0)
    hertz = 0.8 * omega / TURN, 1.2 * omega / TURN
    found = peak_response(slipping(most), "force", (0.5, 2.0), hertz, Options(1))
    assert found.parameter[-1] == 2.0
    np.testing.assert_array_equal(found.converged, found.parameter < 1)
    assert found.parameter[-2] > 0.99
    assert found.converged.sum() == len(found.converged) - 1  # no more is looked for beyond


def test_a_resonance_that_no_known_friction_holds_is_said_where_it_is_not_found():
    pad = Contact(tangential=0, normal=1, kn=1.0, kt=1.0, mu=0.3, gap=1e3)  # open for good
    system = System.from_matrices(np.eye(2), np.diag([1.0, 3.0]), [pad], force={0: 0.1})
    said = "frequencies: .*: near 0.159155 Hz it grows without damping, and friction alone may not"
    with pytest.raises(InputError, match=said):
        adaptive_response(lambda _: system, (0.9 / TURN, 1.15 / TURN), SHARES, Options(1))


def test_a_stop_that_nothing_damps_is_refused_where_it_grows():
    # Far beyond the gap, half a period belongs to each stiffness: 2 ω_1 ω_2 / (ω_1 + ω_2).
    stop = Contact(normal=0, kn=1.0, gap=0.1)
    system = System.from_matrices([[1.0]], [[1.0]], [stop], force={0: 0.1})
    near = 2 * 2**0.5 / (1 + 2**0.5) / TURN
    with pytest.raises(InputError, match=f"near {near:.3f}"):
        adaptive_response(lambda _: system, (0.95 * near, 1.05 * near), SHARES, Options(3))
    below = adaptive_response(lambda _: system, (0.90 * near, 0.94 * near), SHARES, Options(3))
    assert below.amplitude.max() < 1.0


class KilledError(Exception):
    """Stands for a kill."""


class Paper:
    """Points in memory; the run is killed when one beyond the last one allowed is due."""

    def __init__(self, points=None, allowed=np.inf):
        self.before, self.points, self.allowed = dict(points or {}), dict(points or {}), allowed
        self.added: list[str] = []

    def get(self, label):
        """A point that an earlier run has written."""
        return self.before.get(label)

    def add(self, label, numbers, unknowns):
        """Write one."""
        if len(self.added) >= self.allowed:
            raise KilledError
        self.added.append(label)
        self.points[label] = numbers, unknowns.copy()


def close(value, expected):
    """All numbers of a product agree to 1e-9 of the largest beside them, times aside."""
    if is_dataclass(value):
        for each in fields(value):
            if each.name not in ("seconds", "residual"):
                close(getattr(value, each.name), getattr(expected, each.name))
    elif isinstance(value, dict):
        assert value.keys() == expected.keys()
        for key in value:
            close(value[key], expected[key])
    elif isinstance(value, list | tuple):
        for one, other in zip(value, expected, strict=True):
            close(one, other)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fc":
        largest = np.nanmax(np.abs(expected), initial=0.0)
        np.testing.assert_allclose(value, expected, rtol=0, atol=1e-9 * largest)
    else:
        np.testing.assert_equal(value, expected)


def growing(system):
    """Systems with no nodal diameters but those needed."""

    def systems(harmonics):
        needed = {folded(system.nodal_diameter(h), system.sectors) for h in range(harmonics + 1)}
        kept = {k: each for k, each in system.diameters.items() if k in needed}
        return replace(system, diameters=kept)

    return systems


def _range(store=None):
    return frequency_response(sliding_system(amplitude=2.0), (0.15, 0.21), Options(3), store=store)


def _many_contacts(store=None):
    # More unknowns than are factored: GMRES, whose preconditioner goes from point to point.
    system = random_system(5, size=40, contacts=20, mu=0.1, damping_ratio=0.05, harmonics=3)
    return frequency_response(system, np.linspace(0.02, 0.05, 8), Options(3), store=store)


def _uncoupled(store=None):
    options = Options(3, coupling="uncoupled", direction="down")
    system = sliding_system(amplitude=2.0, preload=0.5)
    return frequency_response(system, np.linspace(0.15, 0.21, 8), options, store=store)


def _adaptive(store=None):
    systems, shares = growing(sliding_system(amplitude=3.0)), Shares(6e-3, 3e-3)
    return adaptive_response(systems, (0.14, 0.22), shares, monitor=(0, 0), store=store)


def _isotropic(store=None):
    systems, options = growing(even(sliding_system(preload=0.5))), Options(friction="isotropic")
    return adaptive_response(systems, (0.15, 0.2), Shares(4e-2, 4e-2), options, store=store)


@pytest.mark.parametrize("compute", [_range, _many_contacts, _uncoupled, _adaptive, _isotropic])
def test_wherever_it_is_cut_off_it_ends_at_the_same_numbers(compute):
    whole = Paper()
    expected = compute()
    close(compute(whole), expected)  # writing down changes nothing
    assert len(whole.added) > 5
    begun = Paper(allowed=2 * len(whole.added) // 3)
    with pytest.raises(KilledError):
        compute(begun)
    again = Paper(begun.points)
    close(compute(again), expected)
    assert {*again.added}.isdisjoint(begun.points)  # nothing that was written is solved again
    assert again.points.keys() == whole.points.keys()


def test_what_was_written_is_checked_by_the_equations():
    system, hertz = sliding_system(), np.linspace(0.15, 0.21, 10)
    paper = Paper()
    expected = frequency_response(system, hertz, Options(3), store=paper)
    points = {}
    for i, (label, (numbers, w)) in enumerate(paper.points.items()):
        points[label] = numbers, w * (1 + 1e-3 * i) if i % 2 else np.full_like(w, np.nan)
    again = Paper(points)
    close(frequency_response(system, hertz, Options(3), store=again), expected)
    assert len(again.added) == 5  # those that no iteration leads on from


@pytest.mark.parametrize("compute", [_range, _adaptive])
def test_no_number_depends_on_the_time_that_something_took(compute, monkeypatch):
    expected = compute()
    rng = np.random.default_rng(0)
    for clock in ("process_time", "perf_counter", "monotonic", "time"):
        monkeypatch.setattr(time, clock, lambda: float(rng.exponential(1e4)))
    close(compute(), expected)


def test_points_of_other_frequencies_are_not_taken():
    one, hertz, paper = sliding_system(), np.linspace(0.15, 0.21, 10), Paper()
    frequency_response(one, hertz, Options(3), store=paper)
    again, elsewhere = Paper(paper.points), np.append(hertz[:4], hertz[4:] + 1e-3)
    found = frequency_response(one, elsewhere, Options(3), store=again)
    close(found, frequency_response(one, elsewhere, Options(3)))
    assert len(again.added) == len(paper.added) - 4


def test_modes_of_a_diameter_do_not_depend_on_what_was_asked_for_before():
    # Engine order 2 of 5: harmonic 2 has diameter 4, which mirrors 1, that of harmonic 3.
    whole = random_system(4, engine_order=2, harmonics=5)
    k = {folded(each, 5): whole.at(folded(each, 5)) for each in whole.diameters}
    system = replace(whole, diameters=k)
    few = structure(system, 2)
    many = structure(system, 3, stuck=structure(system, 1).modes)
    assert few.modes[4].shapes.tobytes() == many.modes[4].shapes.tobytes()
