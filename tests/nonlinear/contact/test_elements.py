"""Elements that follow laws of their own, beside theory and beside contacts, which are located."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.errors import InputError
from vanelock.nonlinear import ELEMENT, Contact, Element, Options, System, frequency_response
from vanelock.nonlinear.contact.element_force import periodic_force
from vanelock.nonlinear.contact.law import contact_law

Floats = NDArray[np.float64]
DAMPING, FORCE = 0.02, 0.1
HERTZ = np.linspace(0.5, 2.5, 5) / (2 * np.pi)


def coupled(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """Two displacements, each bound to the other and to its rate."""
    squared = u[0] ** 2 + u[1] ** 2
    out[0] = p[0] * squared * u[0] + p[1] * rate[0] * u[1]
    out[1] = p[0] * squared * u[1] + p[1] * rate[1] * squared


def fading(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    """A memory of samples, not of the motion."""
    state[0] = 0.9 * state[0] + 0.1 * u[0]
    out[0] = u[0] - state[0]


def mass_on(harmonics: int, *elements: Element, contacts: Any = (), **options: Any) -> Any:
    """Response of a mass on a spring, 1 kg, 1 N/m, with contacts and elements to ground."""
    made = System.from_matrices(
        [[1.0]], [[1.0]], contacts, elements=elements, C=[[DAMPING]], force={0: FORCE}
    )
    return frequency_response(made, HERTZ, Options(harmonics, **options), find_jumps=False)


def test_duffing_oscillator_has_its_first_harmonic() -> None:
    found = mass_on(1, Element(force="cubic_spring", places=[0], parameters=[0.5]))
    omega, a = 2 * np.pi * found.frequency, np.abs(found.output[:, 1, 0, 0])
    dynamic = 1 - omega**2 + 0.75 * 0.5 * a**2 + 1j * DAMPING * omega
    np.testing.assert_allclose(a * np.abs(dynamic), FORCE, rtol=1e-9)
    assert np.all(found.state == ELEMENT)


def test_quadratic_damper_has_its_first_harmonic() -> None:
    found = mass_on(1, Element(force="quadratic_damper", places=[0], parameters=[0.5]))
    omega, a = 2 * np.pi * found.frequency, np.abs(found.output[:, 1, 0, 0])
    damping = DAMPING * omega + 8 / (3 * np.pi) * 0.5 * omega**2 * a
    np.testing.assert_allclose(a * np.abs(1 - omega**2 + 1j * damping), FORCE, rtol=1e-9)
    work = 8 / 3 * 0.5 * omega**2 * a**3
    np.testing.assert_allclose(found.dissipation[:, 0], work, rtol=1e-9)


@pytest.mark.parametrize("stiffness", [None, 1e4])
def test_stop_is_a_contact_with_a_gap(stiffness: float | None) -> None:
    stop = Element(force="stop", places=[0], parameters=[2.0, 0.1], stiffness=stiffness)
    found = mass_on(3, stop)
    other = mass_on(3, contacts=[Contact(normal=0, kn=2.0, gap=0.1)])
    np.testing.assert_allclose(found.output, other.output, atol=1e-8 * other.amplitude.max())


def test_slider_is_a_contact_with_a_constant_load() -> None:
    found = mass_on(3, Element(force="jenkins", places=[0], parameters=[2.0, 0.1]))
    other = mass_on(3, contacts=[Contact(tangential=0, kt=2.0, mu=0.5, preload=0.2)])
    np.testing.assert_allclose(found.output, other.output, atol=1e-8 * other.amplitude.max())
    np.testing.assert_allclose(found.dissipation, other.dissipation, rtol=1e-7, atol=1e-12)


def test_sliders_in_parallel_are_several_elements() -> None:
    both = mass_on(3, Element(force="jenkins", places=[0], parameters=[2.0, 0.1, 1.0, 0.03]))
    pairs = (2.0, 0.1), (1.0, 0.03)
    apart = mass_on(3, *(Element(force="jenkins", places=[0], parameters=p) for p in pairs))
    np.testing.assert_allclose(both.output, apart.output, atol=1e-9 * apart.amplitude.max())


def test_elements_and_contacts_act_together() -> None:
    stop = Contact(normal=0, kn=2.0, gap=0.1)
    slider = Contact(tangential=0, kt=1.0, mu=0.5, preload=0.1)
    as_stop = Element(force="stop", places=[0], parameters=[2.0, 0.1])
    as_slider = Element(force="jenkins", places=[0], parameters=[1.0, 0.05])
    wanted = mass_on(3, contacts=[stop, slider])
    for contact, element in ((stop, as_slider), (slider, as_stop)):
        found = mass_on(3, element, contacts=[contact])
        np.testing.assert_allclose(found.output, wanted.output, atol=1e-8 * wanted.amplitude.max())


ELEMENTS = [
    Element(force="cubic_spring", places=[0], parameters=[2.0]),
    Element(force="stop", places=[0], parameters=[3.0, 0.2]),
    Element(force="quadratic_damper", places=[0], parameters=[0.7]),
    Element(force="tanh_friction", places=[0], parameters=[1.0, 0.3]),
    Element(force="jenkins", places=[0], parameters=[2.0, 0.6, 1.0, 0.8, 3.0, 0.1]),
    Element(force=coupled, places=[0, 1], parameters=[2.0, 0.6]),
]


@pytest.mark.parametrize(
    "element", ELEMENTS, ids=lambda each: getattr(each.force, "__name__", each.force)
)
@pytest.mark.parametrize("samples", [None, 512])
def test_derivatives_are_those_of_differences(element: Element, samples: int | None) -> None:
    rng, step, omega = np.random.default_rng(2), 1e-6, 1.3
    falling = np.repeat(np.arange(6), 2)[1:].clip(1) ** 2
    u = rng.normal(size=(len(element.places), 11)) / falling
    found = periodic_force(element, u, omega, samples)

    def moved(du: Floats | float, dw: float) -> Floats:
        ahead = periodic_force(element, u + du, omega + dw, samples).force
        behind = periodic_force(element, u - du, omega - dw, samples).force
        return (ahead - behind) / (2 * step)

    size = np.abs(found.jacobian).max()
    for _ in range(2):
        direction = rng.normal(size=u.shape)
        given = np.einsum("imjn,jn->im", found.jacobian, direction)
        # A kink passes instants as they are chosen anew: 1e-5 and less.
        np.testing.assert_allclose(given, moved(step * direction, 0.0), atol=1e-4 * size)
    np.testing.assert_allclose(found.by_omega, moved(0.0, step), atol=1e-6 * size)


def test_instants_resolve_a_law_far_below_what_uniform_samples_do() -> None:
    rng = np.random.default_rng(5)
    u = rng.normal(size=(1, 11)) / np.repeat(np.arange(6), 2)[1:].clip(1) ** 2
    for element in ELEMENTS[:5]:
        found = periodic_force(element, u, 1.3).force
        finest = periodic_force(element, u, 1.3, 1 << 16).force
        assert np.abs(found - finest).max() < 3e-8 * np.abs(finest).max(), element.force


def test_velocity_counts_where_arcs_pass_folds() -> None:
    # Friction with a velocity, beside a spring that folds the curve: both ways meet at the ends.
    spring = Element(force="cubic_spring", places=[0], parameters=[4.0])
    friction = Element(force="tanh_friction", places=[0], parameters=[0.01, 0.05])
    up, down = (mass_on(1, spring, friction, direction=way) for way in ("up", "down"))
    assert up.converged.all()
    assert down.converged.all()
    assert np.abs(up.amplitude - down.amplitude).max() > 0.1 * up.amplitude.max()
    np.testing.assert_allclose(up.amplitude[[0, -1]], down.amplitude[[0, -1]], rtol=1e-8)


def test_a_gradient_of_the_frequency_sees_velocities() -> None:
    element = Element(force="quadratic_damper", places=[0], parameters=[0.5])
    made = System.from_matrices([[1.0]], [[1.0]], elements=[element])
    law = contact_law(made.contacts, 3)
    u = np.zeros((1, 3, 7))
    u[0, 0] = np.random.default_rng(0).normal(size=7)
    rate = (law(u, 1.3 + 1e-5).w - law(u, 1.3 - 1e-5).w) / 2e-5
    by_omega = law(u, 1.3).by_omega
    assert by_omega is not None
    np.testing.assert_allclose(by_omega, rate, atol=1e-7 * np.abs(rate).max())


def test_adaptive_response_takes_elements() -> None:
    made = System.from_matrices(
        [[1.0]],
        [[1.0]],
        elements=[Element(force="stop", places=[0], parameters=[2.0, 0.1])],
        C=[[DAMPING]],
        force={0: FORCE},
    )
    shares = nonlinear.Shares(1e-4, 1e-3)
    found = nonlinear.adaptive_response(lambda _: made, HERTZ[1:3], shares)
    fixed = frequency_response(made, HERTZ[1:3], Options(25), find_jumps=False)
    close = np.abs(found.amplitude[:, 0, 0] / fixed.amplitude[:, 0, 0] - 1)
    assert found.converged.all()
    assert close.max() < 3e-4


def test_linear_limits_leave_elements_out() -> None:
    made = System.from_matrices(
        [[1.0]], [[1.0]], elements=[ELEMENTS[0]], damping_ratio=0.01, force={0: FORCE}
    )
    found = nonlinear.linear_response(made, HERTZ)
    omega = 2 * np.pi * HERTZ
    wanted = FORCE / np.abs(1 - omega**2 + 0.02j * omega)
    np.testing.assert_allclose(found.amplitude[:, 0, 0], wanted, rtol=1e-10)


def dragging(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    out[0], state[0] = p[0] * (u[0] - state[0]), u[0]


def unknown(u: Floats, rate: Floats, state: Floats, p: Floats, out: Floats) -> None:
    out[0] = nothing(u)  # type: ignore[name-defined]  # noqa: F821


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"force": "quintic"}, "force = 'quintic': allowed: cubic_spring, stop"),
        ({"parameters": [1.0, 2.0]}, r"cubic_spring needs k \(N/m3\)"),
        ({"parameters": [np.inf]}, "needs a list of numbers"),
        ({"places": []}, "needs a list of one to three"),
        ({"places": [0, 1]}, "given 2: cubic_spring needs one"),
        ({"stiffness": 0}, "stiffness = 0: must be > 0"),
        ({"memory": -1}, "memory = -1: must be >= 0"),
        ({"force": dragging}, r"memory = 0: force uses more of state \(index 0 is out of bounds"),
        ({"force": dragging, "memory": 1, "parameters": []}, "reads or writes beyond what it is"),
    ],
)
def test_what_is_impossible_is_refused(given: dict[str, Any], message: str) -> None:
    possible = {"force": "cubic_spring", "places": [0], "parameters": [1.0]}
    with pytest.raises(InputError, match=message):
        Element(**{**possible, **given})


@pytest.mark.parametrize(
    ("force", "memory", "message"),
    [(unknown, 0, "cannot be compiled: NameError"), (fading, 1, "changes with every finer")],
)
def test_a_law_that_is_none_is_refused(force: Any, memory: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mass_on(3, Element(force=force, places=[0], memory=memory))


def test_what_is_of_contacts_alone_says_so() -> None:
    made = System.from_matrices([[1.0]], [[1.0]], elements=[ELEMENTS[0]], force={0: FORCE})
    found = frequency_response(made, HERTZ[:2], Options(3), find_jumps=False)
    for refused in (
        lambda: nonlinear.stability(made, found),
        lambda: nonlinear.time_response(made, HERTZ[0]),
        lambda: nonlinear.audit_response(made, found),
        lambda: nonlinear.static_bounds(made),
    ):
        with pytest.raises(InputError, match="'element': .* contacts alone"):
            refused()
    with pytest.raises(InputError, match="an element"):
        nonlinear.contact_loop(found, 0, 0)
