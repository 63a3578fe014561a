"""A system in an HDF5 file: its groups, their units, and what is refused as none."""

from typing import TypeVar

import h5py
import numpy as np

from vanelock.common.arrays import Complex
from vanelock.common.errors import InputError
from vanelock.common.product import packed
from vanelock.rom.system.coordinates import check
from vanelock.rom.system.element import Element
from vanelock.rom.system.system import Contacts, Diameter, Force, System

S = TypeVar("S", bound=System)

_FORMAT = "vanelock-system"
_VERSION = 1


def write_system(system: System, group: h5py.Group) -> None:
    """Write a system into a group."""
    group.attrs["format"] = _FORMAT
    group.attrs["version"] = _VERSION
    group.attrs["sectors"] = system.sectors
    group.attrs["engine_order"] = system.engine_order
    units = {"K": "N/m", "M": "kg", "C": "N s/m"}
    for k, matrices in system.diameters.items():
        inner = group.create_group(f"nd/{k}")
        for name in ("K", "M", "C", "own", "next", "output"):
            value = getattr(matrices, name)
            if value is not None:
                dataset = inner.create_dataset(name, data=value, **packed(value))
                dataset.attrs["unit"] = units.get(name, "1")
        for name, places in matrices.parts.items():
            inner.create_dataset(f"part/{name}", data=places)
    contact = group.create_group("contact")
    units = {"kn": "N/m", "kt": "N/m", "mu": "1", "v0": "m"}
    if system.contacts.slider.any():
        units["slider"] = "m"
    for name, unit in units.items():
        contact.create_dataset(name, data=getattr(system.contacts, name)).attrs["unit"] = unit
    text = h5py.string_dtype()
    if system.contacts.joint:
        contact.create_dataset("joint", data=list(system.contacts.joint), dtype=text)
    for i, element in system.contacts.elements.items():
        if not isinstance(element.force, str):
            raise InputError(
                f"Element {element.name!r}: follows a function, which no file can hold: name a law"
            )
        law = contact.create_dataset(f"element/{i}", data=element.parameters)
        law.attrs["law"], law.attrs["name"] = element.force, element.name
        law.attrs["places"] = len(element.places)
    if system.contacts.always_closed:
        closed = list(system.contacts.always_closed)
        contact.create_dataset("always_closed", data=closed, dtype=text)
    for h, force in system.force.items():
        dataset = group.create_dataset(f"force/{h}", data=force.vector)
        dataset.attrs["unit"] = "N" if force.omega_power == 0 else "N s^2"
        dataset.attrs["omega_power"] = force.omega_power
    if system.output_names:
        group.create_dataset("output/name", data=list(system.output_names), dtype=text)
    if system.damping_ratio is not None:
        group.create_dataset("damping/ratio", data=system.damping_ratio)
        group["damping"].attrs["joints"] = system.damping_joints
    if system.band is not None:
        group.create_dataset("band", data=system.band).attrs["unit"] = "Hz"


def read_system(kind: type[S], group: h5py.Group) -> S:
    """Read a system from a group."""
    where = group.file.filename
    if group.attrs.get("format") != _FORMAT:
        inner = group.get("system")
        held = isinstance(inner, h5py.Group) and inner.attrs.get("format") == _FORMAT
        hint = "; a results file holds it in its group /system" if held else ""
        raise InputError(f"{where}: expected the format {_FORMAT!r} in its attributes{hint}")
    version = int(group.attrs.get("version", 0))
    if version != _VERSION:
        raise InputError(f"{where}: format version {version}, this program reads {_VERSION}")

    def optional(inner: h5py.Group, name: str) -> Complex | None:
        return inner[name][()] if name in inner else None

    diameters = {
        int(k): Diameter(
            K=inner["K"][()],
            M=inner["M"][()],
            own=inner["own"][()],
            next=optional(inner, "next"),
            output=optional(inner, "output"),
            C=optional(inner, "C"),
            parts={name: places[()] for name, places in inner.get("part", {}).items()},
        )
        for k, inner in group["nd"].items()
    }
    contact = group["contact"]

    def names(name: str) -> tuple[str, ...]:
        return tuple(contact[name].asstr()[()]) if name in contact else ()

    kt = np.asarray(contact["kt"][()], float)
    contacts = Contacts(
        kn=np.asarray(contact["kn"][()], float),
        kt=np.column_stack([kt, kt]) if kt.ndim == 1 else kt,
        mu=np.asarray(contact["mu"][()], float),
        v0=np.asarray(contact["v0"][()], float),
        joint=names("joint"),
        always_closed=names("always_closed"),
        slider=contact["slider"][()] if "slider" in contact else np.zeros((0, 2)),
        elements={
            int(i): Element(
                force=str(law.attrs["law"]),
                places=range(int(law.attrs["places"])),
                parameters=law[()],
                name=str(law.attrs["name"]),
            )
            for i, law in contact.get("element", {}).items()
        },
    )
    force = {
        int(h): Force(dataset[()], int(dataset.attrs.get("omega_power", 0)))
        for h, dataset in group.get("force", {}).items()
    }
    damping = group.get("damping")
    joints = "stuck" if damping is None else damping.attrs.get("joints", "stuck")
    system = kind(
        sectors=int(group.attrs["sectors"]),
        engine_order=int(group.attrs["engine_order"]),
        diameters=diameters,
        contacts=contacts,
        force=force,
        output_names=tuple(group["output/name"].asstr()[()]) if "output" in group else (),
        damping_ratio=None if damping is None else float(damping["ratio"][()]),
        damping_joints=str(joints),
        band=float(group["band"][()]) if "band" in group else None,
    )
    check(system, where)
    return system
