"""A ring of small meshes from files, whose parts reduce in a moment."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.conftest import CASING_MASTERS, JOINTS, VANE_MASTERS
from tests.mesh.conftest import SECTORS, ring_sectors
from vanelock import fem, mesh, parse_study, rom
from vanelock.input.cases.sweep import cases
from vanelock.mesh.matching.side import own_part
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.stages.plan import Planned, plan

PARTS = ("vane", "casing")
STEEL = fem.Material(E=170e9, nu=0.3, rho=8200.0)
"""That of a study by default."""
COARSER = (1, 2, 2)
"""Fewer boxes of elements than the ring has otherwise."""


def planned_of(text: str) -> Planned:
    return plan(cases(parse_study(text)), lambda *_: None)[0]


@pytest.fixture
def stages(tmp_path) -> Stages:
    """Where products come from, kept in a folder of the test's own."""
    return Stages(Cache(tmp_path / "cache", print), silent)


@pytest.fixture(scope="session")
def ring_files(tmp_path_factory, lattice, write_mesh) -> Callable[..., dict[str, Any]]:
    """Function that writes a ring's parts, of elements of a type: file and sets' names of each.

    The vane's mesh has a set "end", its side at z = 0.2 m.
    """

    @lru_cache
    def written(cell_type: str, counts: tuple[int, int, int]) -> dict[str, Any]:
        folder, found = tmp_path_factory.mktemp("ring"), {}
        for name in PARTS:
            part = ring_sectors(lattice)(name, cell_type, counts)
            if name == "vane":
                end = np.flatnonzero(np.abs(part.points[:, 2] - 0.2) < 1e-9)
                part = replace(part, node_sets=part.node_sets | {"end": end})
            called = write_mesh(folder / f"{name}.vtu", part)
            own = {wanted: given for wanted, given in called.items() if wanted != "end"}
            found[name] = folder / f"{name}.vtu", own
        return found

    return written


@pytest.fixture(scope="session")
def ring_text(ring_files) -> Callable[..., str]:
    """Function that gives the beginning of a study of the ring, six modes a part."""

    def text(cell_type: str = "tetra10", counts: tuple[int, int, int] = (1, 3, 4)) -> str:
        lines = [f"[ring]\nsectors = {SECTORS}\n"]
        for name, (path, called) in ring_files(cell_type, counts).items():
            lines.append(f'[{name}]\nmesh = "{path}"\nunit = "mm"\n[{name}.sets]\n')
            lines += [f"{wanted} = {given!r}\n" for wanted, given in called.items()]
        return "".join([*lines, "[rom]\nmodes = 6\n"])

    return text


@pytest.fixture(scope="session")
def scene(ring_files) -> SimpleNamespace:
    own = [
        own_part(mesh.read_mesh(path, "mm"), name, called)
        for name, (path, called) in ring_files("tetra10", COARSER).items()
    ]
    mates = mesh.pair(*own, SECTORS)
    vane_model, casing_model = (fem.assemble(each, STEEL) for each in (mates.vane, mates.casing))
    vane = rom.reduce(vane_model, VANE_MASTERS)
    casing = rom.reduce(casing_model, CASING_MASTERS, nodal_diameters=range(4), band=vane.band)
    return SimpleNamespace(
        vane_model=vane_model, casing_model=casing_model, vane=vane, casing=casing, joints=JOINTS
    )
