"""Gradients of a peak against differences of peaks that are solved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.verification.nonlinear.spring_rings import loaded, spring_ring, worst_of
from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    AmplitudeGradient,
    Options,
    frequency_response,
    peak_gradient,
    peak_gradient_of,
    peak_response,
)
from vanelock.nonlinear.following.peak import Resonance
from vanelock.nonlinear.following.peak_gradient import _gradient_of_peak
from vanelock.rom.system.system import Force, System

STEP = 1e-5


def slipping(
    seed: int, kind: str = "slip", **changes: object
) -> tuple[System, tuple[float, float]]:
    """A ring under the load that friction damps most, and a range about its peak, Hz."""
    kinds = worst_of(seed)
    _, force, hertz = kinds.get(kind) or next(iter(kinds.values()))
    system = replace(loaded(spring_ring(seed), force), **changes)
    return system, (0.85 * hertz, 1.12 * hertz)


def drawn(system: System, seed: int) -> dict[int, np.ndarray]:
    """A Hermitian change of the stiffness by nodal diameter, of its size."""
    random, found = np.random.default_rng(seed), {}
    for k, one in system.diameters.items():
        A = random.normal(size=one.K.shape) + 1j * random.normal(size=one.K.shape)
        A = A if np.iscomplexobj(one.K) else A.real
        found[k] = (A + A.conj().T) * np.abs(one.K).mean()
    return found


def changed(system: System, changes: dict[int, np.ndarray], share: float) -> System:
    diameters = {
        k: replace(one, K=one.K + share * changes[k]) for k, one in system.diameters.items()
    }
    return replace(system, diameters=diameters)


def difference(
    system: System,
    changes: dict[int, np.ndarray],
    near: tuple[float, float],
    options: Options,
    output: tuple[str, int],
) -> float:
    up, down = (
        peak_response(changed(system, changes, sign * STEP), "force", [1.0], near, options, output)
        for sign in (1, -1)
    )
    assert up.converged.all()
    assert down.converged.all()
    return float(up.amplitude[0] - down.amplitude[0]) / (2 * STEP)


@pytest.mark.parametrize(("seed", "harmonics"), [(0, 1), (3, 3)])
def test_stiffness_moves_a_peak_as_differences_say(seed: int, harmonics: int) -> None:
    system, near = slipping(seed)
    options = Options(harmonics)
    changes = drawn(system, seed)
    known = peak_response(system, "force", [1.0], near, options)
    output = known.output, known.direction
    found = peak_gradient(system, near, options, output)
    assert found.amplitude == pytest.approx(known.amplitude[0], rel=1e-12)
    assert found.frequency == pytest.approx(known.frequency[0], rel=1e-9)
    expected = difference(system, changes, near, options, output)
    assert found.at_peak.by_stiffness(changes) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("coupling", "diameter"), [("uncoupled", 0), ("constant-load", None)])
def test_the_state_at_rest_counts_where_it_is_solved_first(
    coupling: str, diameter: int | None
) -> None:
    system, near = slipping(2)
    options = Options(1, coupling=coupling)
    changes = drawn(system, 2)
    if diameter is not None:  # of nodal diameter 0 alone, which moves the rest
        changes = {k: (k == diameter) * change for k, change in changes.items()}
    known = peak_response(system, "force", [1.0], near, options)
    assert not known.sharp[0]
    output = known.output, known.direction
    found = peak_gradient(system, near, options, output)
    expected = difference(system, changes, near, options, output)
    assert found.at_peak.by_stiffness(changes) == pytest.approx(expected, rel=1e-5)


def test_contacts_that_open_and_damping_of_the_open_structure() -> None:
    system, near = slipping(0, "lift", damping_joints="open")
    changes = drawn(system, 4)
    known = peak_response(system, "force", [1.0], near, Options(3))
    output = known.output, known.direction
    found = peak_gradient(system, near, Options(3), output)
    expected = difference(system, changes, near, Options(3), output)
    assert found.at_peak.by_stiffness(changes) == pytest.approx(expected, rel=1e-5)


def test_a_stuck_peak_is_that_of_a_linear_structure() -> None:
    """With modal damping a resonance's peak is f/(2ζk): all stiffnesses alike lower it alike."""
    system, _ = slipping(2)
    system = loaded(system, 1e-6)
    contacts = system.contacts
    found = peak_gradient(system, (0.1, 0.5), Options(1))
    stiff = {
        k: one.K
        + np.einsum(
            "cdi,cd,cdj->ij",
            system.contact_rows(k).conj(),
            contacts.stiffness,
            system.contact_rows(k),
        )
        for k, one in system.diameters.items()
    }
    assert found.at_peak.by_stiffness(stiff) == pytest.approx(-found.amplitude, rel=1e-6)


def test_no_peak_is_one_line() -> None:
    system, near = slipping(0)
    with pytest.raises(InputError, match=r"^near: no peak was found in it$"):
        peak_gradient(system, (2 * near[1], 2.02 * near[1]))
    with pytest.raises(InputError, match="needs at least 1"):
        peak_gradient(system, near, Options(0))


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled", "constant-load"])
@pytest.mark.parametrize("kind", ["slip", "lift"])
def test_gradients_obey_dimensional_analysis(kind: str, coupling: str) -> None:
    """Loads and interference scale the motion; stiffness and loads the square of the frequency."""
    system, near = slipping(0, kind)
    rest = Force(np.asarray(0.2 * np.random.default_rng(1).normal(size=3), complex))
    system = replace(system, force={**system.force, 0: rest})
    found = peak_gradient(system, near, Options(3, coupling=coupling), frequency=True)
    contacts = system.contacts
    every = {k: one.K for k, one in system.diameters.items()}

    def lengths(each: AmplitudeGradient) -> float:
        interference = float(contacts.v0 @ each.by_interference())
        return float(each.by_force() + each.by_rest_force() + interference)

    def forces(each: AmplitudeGradient) -> float:
        springs = float(np.vdot(contacts.stiffness, each.by_contact_stiffness()))
        resists = springs + each.by_stiffness(every)
        return float(each.by_force() + each.by_rest_force() + resists)

    assert lengths(found.at_peak) == pytest.approx(found.amplitude, rel=1e-8)
    # The frequency scales with them, which counts for nothing but at the exact extremum.
    assert forces(found.at_peak) == pytest.approx(0.0, abs=1e-6 * found.amplitude)
    assert found.of_frequency(lengths) == pytest.approx(0.0, abs=1e-6 * found.frequency)
    assert found.of_frequency(forces) == pytest.approx(found.frequency / 2, rel=1e-6)


def test_a_peak_of_a_response_is_that_of_a_search() -> None:
    system, near = slipping(2)
    whole = peak_gradient(system, near, Options(3), frequency=True)
    hertz = np.linspace(*near, 60)
    response = frequency_response(system, hertz, Options(3), find_jumps=False)
    at = system.output_names.index(whole.output[0]), whole.output[1]
    point = int(response.amplitude[:, *at].argmax())
    found = peak_gradient_of(system, response, point, whole.output, 0.02)
    assert found.amplitude == pytest.approx(whole.amplitude, rel=1e-10)
    assert found.frequency == pytest.approx(whole.frequency, rel=1e-8)
    for by in (AmplitudeGradient.by_force, AmplitudeGradient.by_damping):
        assert by(found.at_peak) == pytest.approx(by(whole.at_peak), rel=1e-6)
        assert found.of_frequency(by) == pytest.approx(whole.of_frequency(by), rel=1e-3)
    with pytest.raises(InputError, match=r"^point: given 0: no peak was found there$"):
        peak_gradient_of(system, response, 0, whole.output, 1e-5)


def test_where_no_frequency_is_followed_the_reason_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    system, near = slipping(2)
    ready, found = Options(1).prepare(system, near, 1000), peak_gradient(system, near, Options(1))
    component = system.output_names.index(found.output[0]), found.output[1]
    monkeypatch.setattr(Resonance, "read", lambda *_: None)
    for changes, asked, why in (
        ({}, False, "the peak's frequency was not asked for"),
        ({"sharp": True}, True, "the peak is sharp"),
        ({"distance": 1e-3}, True, "the peak is not exact"),
        ({}, True, "close beside the peak the path turns back or was lost"),
    ):
        again = _gradient_of_peak(ready, component, replace(found.peak, **changes), asked)
        assert again is not None
        with pytest.raises(InputError, match=f"^of_frequency: {why}"):
            again.of_frequency(AmplitudeGradient.by_force)
