"""Gradients of peaks, amplitude and frequency, against differences of peaks that are solved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import FULL
from tests.nonlinear.systems import even, with_contacts
from tests.verification.nonlinear.spring_rings import MASSES, worst_ring
from vanelock.nonlinear import AmplitudeGradient, Options
from vanelock.nonlinear.forced_response.parameter_response import Parameter
from vanelock.nonlinear.peaks.peak import CurvePoint, Resonance
from vanelock.nonlinear.peaks.peak_gradient import _gradient_of_peak
from vanelock.nonlinear.peaks.peak_tracking import PeakTrack
from vanelock.rom.system.system import Force

COUNT, GROUPS = (105, 21) if FULL else (4, 2)
STEP = 1e-5
AMPLITUDE, FREQUENCY = 1e-6, 5e-5
"""Of the peak's amplitude, and of its half-width, by a parameter that changes by all of itself."""
FRICTIONS = ("orthogonal", "isotropic")
COUPLINGS = ("coupled", "uncoupled", "constant-load")


def scaled_contacts(name, where):
    """What scales one quantity of some contacts."""

    def change(system, share):
        given = getattr(system.contacts, name).copy()
        given[where] *= 1 + share
        return with_contacts(system, **{name: given})

    return change


def scaled_force(harmonics):
    def change(system, share):
        force = {
            h: replace(each, vector=(1 + share) * each.vector) if h in harmonics else each
            for h, each in system.force.items()
        }
        return replace(system, force=force)

    return change


def stiffer(changes):
    def change(system, share):
        diameters = {
            k: replace(one, K=one.K + share * changes[k]) for k, one in system.diameters.items()
        }
        return replace(system, diameters=diameters)

    return change


def replaced_slider(c, way):
    def change(system, share):
        slider = system.contacts.slider.copy()
        slider[c, way] += share
        return with_contacts(system, slider=slider)

    return change


def damped(system, share):
    return replace(system, damping_ratio=(1 + share) * system.damping_ratio)


def parameters(system, friction, random):
    """How a system changes by a share of each parameter, and what a gradient says of it."""
    contacts, drawn = system.contacts, {}
    for k, one in system.diameters.items():
        A = random.normal(size=one.K.shape) + 1j * random.normal(size=one.K.shape)
        A = A if np.iscomplexobj(one.K) else A.real
        drawn[k] = (A + A.conj().T) * np.abs(one.K).mean()
    ways = (slice(2),) if friction == "isotropic" else (slice(0, 1), slice(1, 2))

    def kt(c, way):
        return lambda each: float(contacts.kt[c, way] @ each.by_contact_stiffness()[c, 1:][way])

    def of(c, method, size):
        return lambda each: size * getattr(each, method)()[c]

    found = {
        "force": (scaled_force({1}), AmplitudeGradient.by_force),
        "force at rest": (scaled_force({0}), AmplitudeGradient.by_rest_force),
        "damping": (damped, lambda each: system.damping_ratio * each.by_damping()),
        "stiffness": (stiffer(drawn), lambda each: each.by_stiffness(drawn)),
    }
    for c in range(contacts.count):
        found[f"v0 {c}"] = scaled_contacts("v0", c), of(c, "by_interference", contacts.v0[c])
        found[f"mu {c}"] = scaled_contacts("mu", c), of(c, "by_friction", 1.0)
        found[f"kn {c}"] = (
            scaled_contacts("kn", c),
            of((c, 0), "by_contact_stiffness", contacts.kn[c]),
        )
        for way in ways:
            found[f"kt {c} {way}"] = scaled_contacts("kt", (c, way)), kt(c, way)
            slid = of((c, way), "by_slider", 1.0)
            found[f"slider {c} {way}"] = replaced_slider(c, way), lambda e, f=slid: f(e).sum()
    return found


def drawn_case(seed):
    """A random ring about its peak: system, range in Hz, options."""
    random = np.random.default_rng(1000 + seed)
    system, hertz = worst_ring(seed % 20, ("slip", "lift")[seed // 20 % 2])
    at_rest = 0.1 * random.normal(size=MASSES)
    friction, coupling = random.choice(FRICTIONS), COUPLINGS[random.choice(3, p=[0.6, 0.2, 0.2])]
    system = even(system) if friction == "isotropic" else system
    system = with_contacts(system, slider=0.02 * random.normal(size=system.contacts.kt.shape))
    system = replace(
        system,
        force={**system.force, 0: Force(at_rest.astype(complex))},
        damping_joints=str(random.choice(["stuck", "open"])),
    )
    options = Options(int(random.choice([1, 3, 5])), coupling=coupling, friction=str(friction))
    return system, (0.8 * hertz, 1.15 * hertz), options, random


def peak_of(system, near, options):
    """The highest peak, with what solves it."""
    ready = options.prepare(system, near, 1000)
    unvaried = Parameter("force", np.zeros(system.contacts.count, bool), False)
    span = (2 * np.pi * near[0], 2 * np.pi * near[1])
    track = PeakTrack(lambda _: ready, unvaried, span, None, 1.0)
    swept = track.sweep(1.0)
    track = track.with_component(1.0, swept)
    assert track.component is not None
    return ready, track.component, track.highest(1.0, swept)


def moved_peak(system, near, options, component, peak: CurvePoint) -> CurvePoint | None:
    """The same peak of a system that changed a little."""
    ready = options.prepare(system, near, 1000)
    solution = peak.solution
    find = Resonance(ready.solver.family, component, 1e-13, 1e-10).peak
    return find(solution.omega, solution.w, peak.bend, solution.reuse)


def errors(seed):
    """Largest errors of the gradients of amplitude and frequency; None without a smooth peak."""
    system, near, options, random = drawn_case(seed)
    ready, component, peak = peak_of(system, near, options)
    if peak is None or peak.sharp or not peak.distance < 1e-8:
        return None
    gradient = _gradient_of_peak(ready, component, peak, frequency=True)
    assert gradient is not None
    assert gradient.beside
    worst = np.zeros(2)
    for name, (change, by) in parameters(system, options.friction, random).items():
        ends = []
        for share in (-STEP, STEP):
            moved = moved_peak(change(system, share), near, options, component, peak)
            assert moved is not None, name
            ends.append((moved.amplitude, moved.solution.omega))
        (low, below), (high, above) = ends
        amplitude = (high - low) / (2 * STEP) - by(gradient.at_peak)
        omega = (above - below) / (2 * STEP) - 2 * np.pi * gradient.of_frequency(by)
        found = np.abs([amplitude / peak.amplitude, omega / peak.width])
        assert (found < [AMPLITUDE, FREQUENCY]).all(), (name, found)
        worst = np.maximum(worst, found)
    return worst, options


@pytest.mark.parametrize("group", range(GROUPS))
def test_all_parameters_move_peaks_as_differences_say(group, record):
    seeds = range(group, COUNT, GROUPS) if FULL else range(2 * group, 2 * group + 2)
    found = [errors(seed) for seed in seeds]
    smooth = [each for each in found if each is not None]
    assert smooth
    worst = np.max([each[0] for each in smooth], axis=0)
    record("systems", f"{len(smooth)} of {len(found)}")
    record("amplitude", f"{worst[0]:.1e}")
    record("frequency, of the half-width", f"{worst[1]:.1e}")
