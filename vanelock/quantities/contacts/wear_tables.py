"""Tables of wear indicators: of every contact, and of the joints that they belong to."""

from collections.abc import Callable, Mapping

import numpy as np

from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.quantities.contacts.wear import Floats, Wear
from vanelock.stages.parts.places import Places

INDICATORS: dict[Column, Callable[[Floats], np.float64]] = {
    Column("energy", "µJ/cycle"): np.sum,
    Column("energy per area", "J/m²/cycle"): np.max,
    Column("power", "mW"): np.sum,
    Column("slip", "µm/cycle"): np.max,
    Column("slip", "m/h", key="slip_per_hour"): np.max,
    Column("mean load", "N"): np.mean,
    Column("largest load", "N"): np.max,
    Column("mean pressure", "MPa"): np.max,
    Column("largest pressure", "MPa"): np.max,
    Column("worn volume", "mm³/h"): np.sum,
    Column("worn depth", "µm/h"): np.max,
}
"""Of a contact, and what a joint has of its contacts'."""
WORN = ("worn volume", "worn depth")
PLACE = (Column("x", "mm"), Column("y", "mm"), Column("z", "mm"))


def contact_table(places: Places, wear: Wear) -> Table:
    """A line for each contact: its place, its area and its indicators."""
    columns = (Column("contact"), *PLACE, Column("area", "mm²"), *INDICATORS)
    values = (*places.points.T, wear.area, *_indicators(wear))
    rows = list(zip(places.names, *values, strict=True))
    return Table("Contacts", columns, rows).without_empty(*WORN)


def joint_table(title: str, cases: Mapping[str, tuple[Places, Wear]]) -> Table:
    """A line for each joint of each case, by its name."""
    rows: list[tuple[Cell, ...]] = []
    for name, (places, wear) in cases.items():
        joints = np.array(places.joint)
        for joint in dict.fromkeys(places.joint):
            own = joints == joint
            values = [each[own][np.isfinite(each[own])] for each in _indicators(wear)]
            pairs = zip(INDICATORS.values(), values, strict=True)
            values = [function(each) if len(each) else None for function, each in pairs]
            rows.append((name, joint, f"{np.sum(wear.energy[own] > 0)} of {own.sum()}", *values))
    columns = (*heads("case", "joint", "slipping"), *INDICATORS)
    return Table(title, columns, rows).without_empty(*WORN)


def _indicators(wear: Wear) -> tuple[Floats, ...]:
    return (
        wear.energy,
        wear.energy_per_area,
        wear.power,
        wear.slip,
        wear.slip_per_hour,
        wear.mean_load,
        wear.largest_load,
        wear.mean_pressure,
        wear.largest_pressure,
        wear.volume_per_hour,
        wear.depth_per_hour,
    )
