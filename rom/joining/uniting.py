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
    diameters, loaded = dict(first.diameters), _loaded(first)
    at_rest = first.force.get(0)
    for other in others:
        if twice := diameters.keys() & other.diameters.keys():
            raise InputError(f"united: nodal diameter {min(twice)} comes twice")
        alike = ("sectors", "engine_order", "output_names", "damping_ratio", "damping_joints")
        differing = [name for name in alike if getattr(first, name) != getattr(other, name)]
        if differing or first.contacts.joint != other.contacts.joint:
            raise InputError(f"united: the systems differ in {(differing or ['contacts'])[0]}")
        diameters |= other.diameters
        loaded, at_rest = loaded or _loaded(other), at_rest or other.force.get(0)
    if loaded is None:
        k = first.nodal_diameter(1)
        have = ", ".join(map(str, sorted(diameters)))
        raise InputError(f"united: the load acts at nodal diameter {k}, and there are {have}")
    band = common_band(each.band for each in systems)
    diameters = dict(sorted(diameters.items()))
    force = loaded.force if at_rest is None else {**loaded.force, 0: at_rest}
    return replace(first, diameters=diameters, force=force, band=band)


def _loaded(system: System) -> System | None:
    """The system itself if it holds the nodal diameter of its load."""
    k, N = system.nodal_diameter(1), system.sectors
    return system if {k, (N - k) % N} & system.diameters.keys() else None
