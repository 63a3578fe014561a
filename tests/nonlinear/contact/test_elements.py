"""Elements of laws of their own and isotropic friction, against theory and integration in time."""

from dataclasses import replace

import numpy as np
import pytest

from tests.nonlinear.systems import (
    PLANE_PATHS,
    in_time,
    planar,
    solved_response,
    with_contacts,
)
from tests.refusals import refused
from vanelock import nonlinear
from vanelock.nonlinear import (
    ELEMENT,
    Contact,
    Element,
    Options,
    System,
    frequency_response,
)
from vanelock.nonlinear.contact.element_force import periodic_force

DAMPING, FORCE = 0.02, 0.1
HERTZ = np.linspace(0.5, 2.5, 5) / (2 * np.pi)


def coupled(u, rate, state, p, out):
    """Two displacements, each bound to the other and to its rate."""
    squared = u[0] ** 2 + u[1] ** 2
    out[0] = p[0] * squared * u[0] + p[1] * rate[0] * u[1]
    out[1] = p[0] * squared * u[1] + p[1] * rate[1] * squared


def fading(u, rate, state, p, out):
    """A memory of samples, not of the motion."""
    state[0] = 0.9 * state[0] + 0.1 * u[0]
    out[0] = u[0] - state[0]


def element(force, *parameters, places=(0,), **more):
    return Element(force=force, places=places, parameters=parameters, **more)


def mass(*elements, contacts=(), **damping):
    """A mass on a spring, 1 kg, 1 N/m, with contacts and elements to ground."""
    damping = damping or {"C": [[DAMPING]]}
    given = {"elements": elements, "force": {0: FORCE}, **damping}
    return System.from_matrices([[1.0]], [[1.0]], contacts, **given)


def mass_on(harmonics, *elements, contacts=(), **options):
    """Its response."""
    options = Options(harmonics, **options)
    return solved_response(mass(*elements, contacts=contacts), HERTZ, options)


def test_duffing_oscillator_has_its_first_harmonic():
    found = mass_on(1, element("cubic_spring", 0.5))
    omega, a = 2 * np.pi * found.frequency, np.abs(found.output[:, 1, 0, 0])
    dynamic = 1 - omega**2 + 0.75 * 0.5 * a**2 + 1j * DAMPING * omega
    np.testing.assert_allclose(a * np.abs(dynamic), FORCE, rtol=1e-9)
    assert np.all(found.state == ELEMENT)


def test_quadratic_damper_has_its_first_harmonic():
    found = mass_on(1, element("quadratic_damper", 0.5))
    omega, a = 2 * np.pi * found.frequency, np.abs(found.output[:, 1, 0, 0])
    damping = DAMPING * omega + 8 / (3 * np.pi) * 0.5 * omega**2 * a
    np.testing.assert_allclose(a * np.abs(1 - omega**2 + 1j * damping), FORCE, rtol=1e-9)
    work = 8 / 3 * 0.5 * omega**2 * a**3
    np.testing.assert_allclose(found.dissipation[:, 0], work, rtol=1e-9)


STOP = element("stop", 2.0, 0.1)
SLIDER = element("jenkins", 1.0, 0.05)
CONTACTS = [Contact(normal=0, kn=2.0, gap=0.1), Contact(tangential=0, kt=1.0, mu=0.5, preload=0.1)]


@pytest.mark.parametrize(
    ("elements", "beside", "instead"),
    [
        ([STOP], [], CONTACTS[:1]),
        ([replace(STOP, stiffness=1e4)], [], CONTACTS[:1]),
        ([SLIDER], [], CONTACTS[1:]),
        ([SLIDER], CONTACTS[:1], CONTACTS),
        ([STOP], CONTACTS[1:], CONTACTS),
    ],
    ids=["stop", "stop of a stiffness", "slider", "slider beside a gap", "stop beside a slider"],
)
def test_stop_and_slider_are_contacts_with_a_gap_and_a_constant_load(elements, beside, instead):
    found, expected = mass_on(3, *elements, contacts=beside), mass_on(3, contacts=instead)
    size = expected.amplitude.max()
    np.testing.assert_allclose(found.output, expected.output, atol=1e-8 * size)
    if not beside:
        work = expected.dissipation
        np.testing.assert_allclose(found.dissipation, work, rtol=1e-7, atol=1e-8 * size)


def test_sliders_in_parallel_are_several_elements():
    both = mass_on(3, element("jenkins", 2.0, 0.1, 1.0, 0.03))
    apart = mass_on(3, element("jenkins", 2.0, 0.1), element("jenkins", 1.0, 0.03))
    np.testing.assert_allclose(both.output, apart.output, atol=1e-9 * apart.amplitude.max())


ELEMENTS = [
    element("cubic_spring", 2.0),
    element("stop", 3.0, 0.2),
    element("quadratic_damper", 0.7),
    element("tanh_friction", 1.0, 0.3),
    element("jenkins", 2.0, 0.6, 1.0, 0.8, 3.0, 0.1),
    element(coupled, 2.0, 0.6, places=[0, 1]),
]


@pytest.mark.parametrize(
    "element", ELEMENTS, ids=lambda each: getattr(each.force, "__name__", each.force)
)
@pytest.mark.parametrize("samples", [None, 512])
def test_derivatives_are_those_of_differences(element, samples):
    rng, step, omega = np.random.default_rng(2), 1e-6, 1.3
    falling = np.repeat(np.arange(6), 2)[1:].clip(1) ** 2
    u = rng.normal(size=(len(element.places), 11)) / falling
    _, jacobian, by_omega = periodic_force(element, u, omega, samples)

    def moved(du, dw):
        ahead = periodic_force(element, u + du, omega + dw, samples)[0]
        behind = periodic_force(element, u - du, omega - dw, samples)[0]
        return (ahead - behind) / (2 * step)

    size = np.abs(jacobian).max()
    for _ in range(2):
        direction = rng.normal(size=u.shape)
        given = np.einsum("imjn,jn->im", jacobian, direction)
        # A kink passes instants as they are chosen anew: 1e-5 and less.
        np.testing.assert_allclose(given, moved(step * direction, 0.0), atol=1e-4 * size)
    np.testing.assert_allclose(by_omega, moved(0.0, step), atol=1e-6 * size)


def test_instants_resolve_a_law_far_below_what_uniform_samples_do():
    rng = np.random.default_rng(5)
    u = rng.normal(size=(1, 11)) / np.repeat(np.arange(6), 2)[1:].clip(1) ** 2
    for element in ELEMENTS[:5]:
        found = periodic_force(element, u, 1.3)[0]
        finest = periodic_force(element, u, 1.3, 1 << 16)[0]
        assert np.abs(found - finest).max() < 3e-8 * np.abs(finest).max(), element.force


def test_velocity_counts_where_arcs_pass_folds():
    # Friction with a velocity, beside a spring that folds the curve: both ways meet at the ends.
    spring = element("cubic_spring", 4.0)
    friction = element("tanh_friction", 0.01, 0.05)
    up, down = (mass_on(1, spring, friction, direction=way) for way in ("up", "down"))
    assert up.converged.all()
    assert down.converged.all()
    assert np.abs(up.amplitude - down.amplitude).max() > 0.1 * up.amplitude.max()
    np.testing.assert_allclose(up.amplitude[[0, -1]], down.amplitude[[0, -1]], rtol=1e-8)


def test_adaptive_response_takes_elements():
    shares = nonlinear.Shares(1e-4, 1e-3)
    found = nonlinear.adaptive_response(lambda _: mass(STOP), HERTZ[1:3], shares)
    fixed = solved_response(mass(STOP), HERTZ[1:3], Options(25))
    assert found.converged.all()
    np.testing.assert_allclose(found.amplitude[:, 0, 0], fixed.amplitude[:, 0, 0], rtol=3e-4)


def test_linear_limits_leave_elements_out():
    found = nonlinear.linear_response(mass(ELEMENTS[0], damping_ratio=0.01), HERTZ)
    omega = 2 * np.pi * HERTZ
    expected = FORCE / np.abs(1 - omega**2 + 0.02j * omega)
    np.testing.assert_allclose(found.amplitude[:, 0, 0], expected, rtol=1e-10)


def dragging(u, rate, state, p, out):
    out[0], state[0] = p[0] * (u[0] - state[0]), u[0]


def unknown(u, rate, state, p, out):
    out[0] = nothing(u)  # type: ignore[name-defined]  # noqa: F821


@pytest.mark.parametrize(("given", "message"), [
    ({"force": "quintic"}, "force = 'quintic': allowed: cubic_spring, stop"),
    ({"parameters": [1.0, 2.0]}, r"cubic_spring needs k \(N/m3\)"),
    ({"parameters": [np.inf]}, "needs a list of numbers"),
    ({"places": []}, "needs a list of one to three"),
    ({"places": [0, 1]}, "given 2: cubic_spring needs one"),
    ({"stiffness": 0}, "stiffness = 0: must be > 0"),
    ({"memory": -1}, "memory = -1: must be >= 0"),
    ({"force": dragging}, r"memory = 0: force uses more of state \(index 0 is out of bounds"),
    ({"force": dragging, "memory": 1, "parameters": []}, "reads or writes beyond what it is"),
])  # fmt: skip
def test_what_is_impossible_is_refused(given, message):
    possible = {"force": "cubic_spring", "places": [0], "parameters": [1.0]}
    refused(message, Element, **{**possible, **given})


@pytest.mark.parametrize(("force", "memory", "message"), [
    (unknown, 0, "cannot be compiled: NameError"), (fading, 1, "changes with every finer")
])  # fmt: skip
def test_a_law_that_is_none_is_refused(force, memory, message):
    refused(message, mass_on, 3, Element(force=force, places=[0], memory=memory))


def test_what_is_of_contacts_alone_says_so():
    made = mass(ELEMENTS[0])
    found = solved_response(made, HERTZ[:2], Options(3))
    for asked in (
        lambda: nonlinear.stability(made, found),
        lambda: nonlinear.time_response(made, HERTZ[0]),
        lambda: nonlinear.audit_response(made, found),
        lambda: nonlinear.static_bounds(made),
    ):
        refused("'element': .* contacts alone", asked)
    refused("an element", nonlinear.contact_loop, found, 0, 0)


PLANE_HERTZ = 1.05 / (2 * np.pi)
PLANE = Options(3, friction="isotropic")


@pytest.mark.parametrize(("swing", "v0", "shake", "state"), PLANE_PATHS)
def test_mass_that_slides_in_a_plane(swing, v0, shake, state):
    system, steps = planar(swing, 0.6, v0, shake), 2000
    path, _ = in_time(system, PLANE_HERTZ, 30, steps, "isotropic")
    moving, errors = path - path.mean(axis=0), []
    turn = np.exp(2j * np.pi * np.arange(steps) / steps)[:, None]
    for harmonics in (1, 3, 7, 15):
        response = solved_response(system, [PLANE_HERTZ], Options(harmonics, friction="isotropic"))
        assert response.state[0, 0] == state
        history = sum((response.x[k][0] * turn**k).real for k in range(1, harmonics + 1))
        errors.append(float(np.abs(history - moving).max() / np.abs(moving).max()))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.3 * errors[0]
    assert errors[3] < 1e-3


CASES = {  # push along t2, interference, push along the normal, friction, what is left open
    "slides along t1": (0.02, 2.0, 0.0, "orthogonal", (False, True)),
    "slides along t1, held in the plane": (0.02, 2.0, 0.0, "isotropic", (False, False)),
    "slides along both": (2.0j, 2.0, 0.0, "orthogonal", (False, False)),
    "slides and opens": (0.02, 0.8, 2.0, "orthogonal", (False, False)),
    "sticks": (0.02, 40.0, 0.0, "orthogonal", (True, True)),
    "sticks in the plane": (0.02, 40.0, 0.0, "isotropic", (True, True)),
}


@pytest.mark.parametrize("name", CASES)
def test_what_assembly_left_is_kept_where_nothing_slides(name):
    swing, v0, shake, friction, expected = CASES[name]
    system = planar(swing, 0.6, v0, shake)
    response = solved_response(system, [PLANE_HERTZ], Options(5, friction=friction))
    assert tuple(response.undetermined[0, 0]) == expected
    one, other = (
        in_time(system, PLANE_HERTZ, 40, 500, friction, (0.0, left))[1][:, 1].mean()
        for left in (-0.1, 0.1)
    )
    assert other - one == pytest.approx(0.2, rel=1e-6) if expected[1] else abs(other - one) < 0.02


def test_contact_without_friction_leaves_nothing_open():
    none = with_contacts(planar(0.02, 0.6, 2.0, 0.0), mu=np.zeros(1))
    assert not frequency_response(none, [0.1], Options(1)).undetermined.any()


@pytest.mark.parametrize("kt", [1e10, 1e13])
def test_friction_that_vanishes_beside_the_motion_is_none(kt):
    K = 1e7 * np.array([[2.0, -1.0], [-1.0, 2.0]])
    contact = Contact(tangential=1, normal=(None, 0), mu=1e-9, kt=kt, kn=1e7, preload=0.1)
    system = System.from_matrices(np.eye(2), K, [contact], force={1: 0.1}, static_force={0: -3.0})
    found = frequency_response(system, [430.0, 500.0, 600.0], Options(1, friction="isotropic"))
    square = (2 * np.pi * found.frequency[:, None, None]) ** 2 * np.eye(2)
    alone = np.linalg.solve(K + np.diag([1e7, 0.0]) - square, [0.0, 0.1])
    assert found.converged.all()
    np.testing.assert_allclose(found.x[1], alone, rtol=1e-7)  # μ n is 1e-9 of the force
