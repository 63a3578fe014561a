"""Check what a run left, or a joined system, without computing."""

from collections.abc import Iterator
from pathlib import Path

import h5py

from vanelock.commands.stored.contents import as_written, contents_of
from vanelock.common.errors import InputError
from vanelock.common.files.hdf5 import opened
from vanelock.common.tables import counted
from vanelock.mesh import Part
from vanelock.nonlinear import Response, System
from vanelock.results.files import results_file
from vanelock.rom import Component
from vanelock.stages.parts.components import PARTS

Row = tuple[str, str]
KINDS = {"mesh": Part, "reduced model": Component, "system": System, "response": Response}
"""Products of a results file that are read whole, by what they are called."""
LISTED = 5
"""Failed cases that are named."""


def stored(path: Path) -> tuple[list[Row], str]:
    """What an HDF5 file, or the one in a run's folder, holds, and what it is."""
    if path.is_dir():
        path, folder = path / results_file.NAME, path
        if not path.exists():
            raise InputError(f"{folder}: holds no {results_file.NAME}: not the folder of a run")
    with opened(path, results_file.PARTS) as file:
        kind = str(file.attrs.get("format", ""))
    if kind == "vanelock-system":
        return list(_system(System.load(path))), f"{path}: a system that can be solved"
    with results_file.open_results(path) as file:
        with as_written(file):
            loaded, sizes = contents_of(path, file), list(_sizes(file))
        products = list(_products(file))
    failed = f"{len(loaded.failed):,}"
    if loaded.failed:
        named = [*(name[:60] for name in list(loaded.failed)[:LISTED])]
        failed += f": {', '.join(named + ['...'] * (len(loaded.failed) > LISTED))}"
    rows = [
        ("complete", "yes" if loaded.complete else "NO: the run was stopped or is under way"),
        ("date", loaded.date),
        ("cases", f"{len(loaded.cases):,}"),
        ("failed", failed),
        ("monitor", loaded.monitor.name or "-"),
        *sizes,
        ("read", ", ".join(counted(products.count(n), n) for n in KINDS if n in products) or "-"),
    ]
    return rows, f"{path}: results of a run"


def _system(system: System) -> Iterator[Row]:
    yield "sectors, engine order", f"{system.sectors}, {system.engine_order}"
    for k, matrices in system.diameters.items():
        yield f"nodal diameter {k}", f"{len(matrices.K):,} coordinates"
    yield "contacts", f"{len(system.contacts.kn):,}"


def _sizes(file: h5py.File) -> Iterator[Row]:
    """Sizes of meshes and system."""
    for part in PARTS:
        if (mesh := file.get(f"mesh/{part}")) is not None:
            yield f"{part}: nodes", f"{len(mesh['points']):,}"
            yield f"{part}: elements", f"{len(mesh['cells']):,}"
    if (system := file.get("system")) is not None:
        sizes = (len(group["K"]) for group in system["nd"].values())
        yield "reduced model: coordinates", f"{max(sizes, default=0):,}"
        yield "contacts", f"{len(system['contact/kn']):,}"


def _products(file: h5py.File) -> Iterator[str]:
    """Names of the products that could be read."""
    places = ["system"]
    for group in ("mesh", "rom", "response"):
        if isinstance(below := file.get(group), h5py.Group):
            places += [f"{group}/{name}" for name in below][:100]
    for place in places:
        item = file.get(place)
        if not isinstance(item, h5py.Group):
            continue
        stored = str(item.attrs.get("product", "System" if place == "system" else ""))
        for name, kind in KINDS.items():
            if kind.__name__ == stored:
                kind.load(item)
                yield name
