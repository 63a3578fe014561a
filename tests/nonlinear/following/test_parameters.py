"""Responses against a force, a friction coefficient or an interference, at one frequency."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Options,
    ParameterResponse,
    System,
    contact_loop,
    frequency_response,
    parameter_response,
)
from vanelock.nonlinear.following.parameter_response import _NAMES, checked_parameter
from vanelock.nonlinear.forced_response.options import COUPLINGS
from vanelock.nonlinear.fourier import TURN
from vanelock.rom.system.system import Force

Make = Callable[..., System]
Lowest = Callable[[System], float]

MASK = np.array([True, False, True, True, False, False])


@pytest.fixture
def two_joints(random_system: Make) -> System:
    """Six contacts of two joints, under a static load too."""
    system = random_system(1, preload=3.0)
    contacts = replace(system.contacts, joint=tuple("rim" if m else "root" for m in MASK))
    static = Force(np.full(len(system.at(0).K), 0.3 + 0j))
    return replace(system, contacts=contacts, force={0: static, **system.force})


def changed(system: System, name: str, value: float, mask: NDArray[np.bool_]) -> System:
    """The system at a value of the parameter, written out once more."""
    if name == "force":
        return replace(system, force={**system.force, 1: Force(value * system.force[1].vector)})
    key = {"mu": "mu", "interference": "v0"}[name]
    moved = np.where(mask, value, getattr(system.contacts, key))
    return replace(system, contacts=replace(system.contacts, **{key: moved}))


@pytest.mark.parametrize(
    ("name", "joint", "low", "high"),
    [
        ("force", None, 1e-3, 30.0),
        ("mu", None, 0.03, 0.6),
        ("mu", "rim", 0.03, 0.6),
        ("interference", "rim", -2.0, 8.0),
        ("interference", None, 0.1, 20.0),
    ],
)
def test_values_give_what_systems_changed_by_hand_give(
    two_joints: System,
    first_frequency: Lowest,
    name: str,
    joint: str | None,
    low: float,
    high: float,
) -> None:
    hertz = 1.3 * first_frequency(two_joints)
    values = np.linspace(low, high, 8) if low < 0 else np.geomspace(low, high, 8)
    up, down = (
        parameter_response(
            two_joints, hertz, name, values, Options(1, direction=direction), joint=joint
        )
        for direction in ("up", "down")
    )
    mask = MASK if joint else np.ones(6, bool)
    for found in (up, down):
        assert found.response.converged.all()
        np.testing.assert_array_equal(found.parameter, values)
    states = set(up.response.state.ravel().tolist())
    assert len(states) > 1
    assert states & {SLIP, SLIP_OPEN}
    for i in (0, 4, 7):
        direct = frequency_response(changed(two_joints, name, values[i], mask), [hertz], Options(1))
        assert direct.converged.all()
        for found in (up, down):
            for key in ("contact", "force", "output", "dissipation"):
                one, other = getattr(found.response, key)[i], getattr(direct, key)[0]
                largest = np.abs(other).max()
                assert np.abs(one - other).max() <= 1e-7 * largest, key
        np.testing.assert_array_equal(up.at(i).mu, direct.mu)


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("name", _NAMES)
def test_derivative_to_each_parameter_is_exact(
    two_joints: System, first_frequency: Lowest, name: str, coupling: str
) -> None:
    hertz = 1.3 * first_frequency(two_joints)
    ready = Options(3, coupling=coupling).prepare(two_joints, [hertz], 1)
    joint = None if name == "force" else "rim"
    varied = checked_parameter(name, two_joints, np.array([0.5, 2.0]), joint)
    family = varied.family(ready, TURN * hertz)
    rng = np.random.default_rng(0)
    w = 0.1 * rng.normal(size=(6, 3, 7))
    place, step = varied.coordinate(0.7), 1e-6

    def deviation(parameter: float) -> NDArray[np.float64]:
        return family.law(parameter)(family.at(parameter).displacement(w)).w.reshape(-1)

    at_place = family.law(place)(family.at(place).displacement(w))
    exact = family.rate(place, w, at_place, np.arange(w.size))
    measured = (deviation(place + step) - deviation(place - step)) / (2 * step)
    assert np.abs(exact).max() > 0.01
    assert np.abs(measured - exact).max() < 1e-6 * np.abs(exact).max()
    # Nothing at all deviates: the balance must not be written to.
    before = family.at(place).linear.copy()
    zero = np.zeros_like(w)
    stuck = family.law(place)(family.at(place).displacement(zero))
    family.rate(place, zero, stuck, np.arange(w.size))
    np.testing.assert_array_equal(family.at(place).linear, before)


def test_points_keep_their_own_friction_and_survive_a_file(
    two_joints: System, first_frequency: Lowest, tmp_path: Path
) -> None:
    hertz = 1.3 * first_frequency(two_joints)
    found = parameter_response(two_joints, hertz, "mu", [0.2, 0.05], Options(3), joint="root")
    np.testing.assert_array_equal(found.mu, np.where(MASK, 0.3, np.array([[0.2], [0.05]])))
    found.save(tmp_path / "mu.h5")
    again = ParameterResponse.load(tmp_path / "mu.h5")
    assert again.name == "mu"
    np.testing.assert_array_equal(again.response.contact, found.response.contact)
    for point, mu in enumerate((0.2, 0.05)):
        one = again.at(point)
        contact = int(np.flatnonzero(~MASK)[np.argmax(one.dissipation[0, ~MASK])])
        u, f = contact_loop(one, 0, contact, 4000)
        assert np.abs(f[:, 1:]).max() <= mu * f[:, 0].max() * (1 + 1e-9)
        area = sum(
            float(np.sum(f[:, d] * (np.roll(u[:, d], -1) - np.roll(u[:, d], 1)) / 2))
            for d in (1, 2)
        )
        np.testing.assert_allclose(area, one.dissipation[0, contact], rtol=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"parameter": "kn"}, "parameter: given 'kn'"),
        ({"values": []}, "values: given none"),
        ({"values": [0.0, 1.0]}, "values: given 0: mu must be > 0"),
        ({"values": [[1.0]]}, "needs a list"),
        ({"joint": "hub"}, "joints are rim, root"),
        ({"parameter": "force", "joint": "rim"}, "the force acts on no joint"),
        ({"frequency": [1.0, 2.0]}, r"frequency: given \[1.0, 2.0\]: needs a number"),
    ],
)
def test_impossible_arguments_are_refused(
    two_joints: System, options: dict[str, object], message: str
) -> None:
    arguments: dict[str, object] = {
        "frequency": 1.0,
        "parameter": "mu",
        "values": [0.1],
        **options,
    }
    with pytest.raises(InputError, match=message):
        parameter_response(two_joints, **arguments)
