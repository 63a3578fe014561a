"""Curves drawn from a damped mode against a closed form, their order, and sweeps of the vane."""

import os
from dataclasses import replace

import numpy as np
import pytest

from tests.verification.nonlinear.peaks.test_damped_modes import (
    KT,
    SLIP,
    C,
    K,
    describing_function,
    one_mass,
)
from tests.verification.nonlinear.spring_rings import loaded, spring_ring
from vanelock.nonlinear import Options, damped_mode, frequency_response, modal_synthesis
from vanelock.rom.system.system import Force

FULL = os.environ.get("VANELOCK_VERIFY") == "full"
TOP = 0.7
"""Of a peak, above which curves are compared."""


@pytest.mark.parametrize("force", [0.1, 0.3, 0.6] if FULL else [0.1, 0.6])
def test_one_mass_is_drawn_as_its_describing_function_has_it(force, record_property):
    """|K + k' - Ω² + i(CΩ + k'')| U = f, with k' and k'' of Jenkins' element."""
    system = one_mass(1.0)
    mode = damped_mode(system, 1, np.geomspace(0.1, 20, 400 if FULL else 200), Options(1))
    curve = modal_synthesis(system, mode).response(force)
    U, omega = np.abs(curve.output[:, 0, 0]), 2 * np.pi * curve.frequency
    stiffness, loss = describing_function(U)
    needed = np.abs(K + stiffness - omega**2 + 1j * (C * omega + loss)) * U
    aside = np.abs(needed / force - 1).max()
    slides = U.max() * KT / SLIP
    record_property("points", len(U))
    record_property("largest amplitude", f"{slides:.1f} of that at which it slips")
    record_property("force's difference", f"{aside:.1e}")
    assert slides > 1
    assert curve.others.max() < 1e-12
    assert aside < 1e-3  # between the mode's points a cubic


@pytest.mark.parametrize("seed", range(3 if FULL else 1))
def test_what_is_left_out_at_the_top_is_of_second_order(seed, record_property):
    """The balance at the top's frequency, ever less of the load off the shape of the mode there."""
    system = spring_ring(seed)
    whole = damped_mode(system, 1, options=Options(1))
    a = whole.amplitude[whole.damping_ratio.argmax()]
    mode = damped_mode(system, 1, a * np.geomspace(0.5, 2, 81), Options(1))
    omega, ratio = 2 * np.pi * mode.frequency[40], mode.damping_ratio[40]
    own = system.at(system.nodal_diameter(1)).M @ mode.shape[40]
    load = system.force[1].vector
    rest = load - own * (mode.shape[40].conj() @ load)
    rest *= np.linalg.norm(own) / np.linalg.norm(rest)
    level, orders = 2 * ratio * omega**2 * a, {}
    for others in (True, False):
        found = []
        for share in (0.08, 0.04, 0.02):
            pushed = replace(system, force={1: Force(level * (own + share * rest))})
            curve = modal_synthesis(pushed, mode).response(others=others)
            top = int(curve.amplitude.argmax())
            hertz = curve.frequency[top]
            solved = frequency_response(pushed, [hertz], Options(1), find_jumps=False)
            assert solved.converged.all()
            output = curve.output[top]
            found.append(np.abs(solved.output[0, 1] - output).max() / np.abs(output).max())
        orders[others] = np.log2(found[0] / found[-1]) / 2
        name = "with others" if others else "one mode alone"
        record_property(name, ", ".join(f"{each:.1e}" for each in found))
    assert orders[True] > 1.7
    assert 0.7 < orders[False] < 1.3


def strayed(curve, solved, node, direction):
    """Height, and the largest difference above 70 % of it, of a curve drawn beside one solved."""
    first = curve.curve == 0
    hertz, size = curve.frequency[first], np.abs(curve.output[first, node, direction])
    top = int(size.argmax())
    true = np.abs(solved.output[:, 1, node, direction])
    up, down = np.argsort(hertz[: top + 1]), top + np.argsort(hertz[top:])
    drawn = np.where(
        solved.frequency <= hertz[top],
        np.interp(solved.frequency, hertz[up], size[up]),
        np.interp(solved.frequency, hertz[down], size[down]),
    )
    high = true > TOP * true.max()
    return size[top] / true.max() - 1, np.abs(drawn[high] / true[high] - 1).max()


def beside_the_balance(system, number, force, harmonics, record_property):
    """Height and curve by one mode alone and with the others, and how much these move contacts."""
    options = Options(harmonics)
    mode = damped_mode(system, number, None, options)
    assert mode.complete
    size = mode.response.amplitude.max(axis=0)
    node, direction = np.unravel_index(size.argmax(), size.shape)
    synthesis = modal_synthesis(system, mode)
    alone, curve = synthesis.response(force, others=False), synthesis.response(force)
    assert curve.curve.max() == 0
    size = np.abs(curve.output[:, node, direction])
    high = size > TOP * size.max()
    hertz = np.linspace(curve.frequency[high].min(), curve.frequency[high].max(), 241)
    solved = frequency_response(loaded(system, force), hertz, options, find_jumps=False)
    assert solved.converged.all()
    before = strayed(alone, solved, node, direction)
    after = strayed(curve, solved, node, direction)
    slips = np.interp(size.max(), np.abs(synthesis.output[:, node, direction]), mode.damping_ratio)
    others = curve.others[high].max()
    record_property("height", f"{before[0]:+.2%} by one mode alone, {after[0]:+.2%}")
    record_property("curve above 70 % of it", f"{before[1]:.2%} by one mode alone, {after[1]:.2%}")
    record_property("contacts' vibration by other modes", f"{others:.0%}")
    record_property("damping at the peak / stuck", f"{slips / mode.damping_ratio[0]:.1f}")
    return before, after, others


FEW = [(2, 0.5, 1)]
MANY = [(1, 0.05, 1), (1, 0.1, 1), (2, 0.3, 1), (2, 0.5, 1), (2, 1.0, 1), (2, 0.5, 3)]


@pytest.mark.parametrize(("number", "force", "harmonics"), MANY if FULL else FEW)
def test_other_modes_put_the_vanes_resonance_right(
    scene, number, force, harmonics, record_property
):
    """Under the load of its engine order, which is along none of its modes."""
    before, after, _ = beside_the_balance(scene.system, number, force, harmonics, record_property)
    assert abs(after[0]) < abs(before[0]) / 3
    assert after[1] < before[1] / 3


FEW = [(2, 0.1, 1)]
MANY = [(2, 0.05, 1), (2, 0.1, 1), (2, 0.2, 1), (2, 0.3, 3)]


@pytest.mark.parametrize(("number", "force", "harmonics"), MANY if FULL else FEW)
def test_where_first_order_does_not_do_the_curve_says_so(
    scene, number, force, harmonics, record_property
):
    """Other modes then move the contacts by 15 % of the mode's motion, or more."""
    before, after, others = beside_the_balance(
        scene.system, number, force, harmonics, record_property
    )
    assert abs(after[0]) < abs(before[0])
    assert others > 0.15
