"""One system from systems of the same scene that hold different nodal diameters."""

from collections.abc import Sequence
from dataclasses import replace

from vanelock.common.errors import InputError
from vanelock.rom.system.system import System, common_band


def united(systems: Sequence[System]) -> System:
    """The system that holds the nodal diameters of several.

    A part that is reduced at one nodal diameter after the other, as they are needed, keeps what
    each of them takes: the numbers of coordinates may differ from diameter to diameter.

    Parameters
    ----------
    systems : sequence of System
        The same parts, joints and excitation joined at different nodal diameters.

    Raises
    ------
    InputError
        If there are none, a nodal diameter comes twice, or contacts or outputs differ.
    """
    if not systems:
        raise InputError("united: no systems given")
    first, *others = systems
    diameters, force = dict(first.diameters), dict(first.force)
    for other in others:
        if twice := diameters.keys() & other.diameters.keys():
            raise InputError(f"united: nodal diameter {min(twice)} comes twice")
        alike = ("sectors", "engine_order", "output_names", "damping_ratio", "damping_joints")
        differing = [name for name in alike if getattr(first, name) != getattr(other, name)]
        if differing or first.contacts.joint != other.contacts.joint:
            raise InputError(f"united: the systems differ in {(differing or ['contacts'])[0]}")
        diameters |= other.diameters
        force |= other.force
    band = common_band(each.band for each in systems)
    return replace(
        first,
        diameters=dict(sorted(diameters.items())),
        force=dict(sorted(force.items())),
        band=band,
    )
