"""Tables of wear: what a joint has of its contacts, and what they do not know."""

import numpy as np
import pytest

from vanelock.analyses.energy import _contact_table, _joint_table
from vanelock.quantities.contacts import Wear
from vanelock.stages.parts.outputs import Places

ENERGY, SLIP, LOAD = np.array([0.0, 1e-6, 3e-6]), np.array([0.0, 2e-6, 1e-6]), np.array([5, 1, 3.0])
AREA = np.array([1e-6, 2e-6, np.nan])


def given(coefficient: float) -> tuple[Places, Wear]:
    own = np.full(3, coefficient)
    names, joints = ("hook 1", "lock 1", "lock 2"), ("hook", "lock", "lock")
    places = Places(names, joints, np.arange(3), np.eye(3), AREA, own)
    return places, Wear(100.0, ENERGY, SLIP, 2 * ENERGY, LOAD, 2 * LOAD, AREA, own)


def test_a_joint_has_sums_of_energy_and_the_largest_of_what_is_local() -> None:
    table = _joint_table("Joints", {"a": given(1e-15)})
    hook, lock = (dict(zip(table.by_head(), row, strict=True)) for row in table.shown)
    assert [each["slipping"] for each in (hook, lock)] == ["0 of 1", "2 of 2"]
    assert lock["energy (µJ/cycle)"] == pytest.approx(4)
    assert lock["energy per area (J/m^2/cycle)"] == pytest.approx(0.5)  # of the one with an area
    assert lock["power (mW)"] == pytest.approx(0.4)
    assert lock["slip (m/h)"] == pytest.approx(0.72)
    assert (lock["mean load (N)"], lock["largest load (N)"]) == (2, 6)
    assert lock["largest pressure (MPa)"] == pytest.approx(1)
    volume = 1e9 * 1e-15 * 8e-6 * 100 * 3600
    assert lock["worn volume (mm^3/h)"] == pytest.approx(volume)


def test_contacts_have_wear_only_where_a_coefficient_is_given() -> None:
    known, unknown = (_contact_table(*given(k)).by_head() for k in (1e-15, np.nan))
    assert set(known) - set(unknown) == {"worn volume (mm^3/h)", "worn depth (µm/h)"}
    assert known["area (mm^2)"] == [1, 2, None]
    assert known["y (mm)"] == [0, 1000, 0]
