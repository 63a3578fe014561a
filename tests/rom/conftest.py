"""The coarse vane and casing, reduced and joined once."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest

from vanelock import fem, mesh, rom
from vanelock.rom.joining import joined_dofs

JOINTS = (
    rom.Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6),
    rom.Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6),
)
VANE_MASTERS = (
    "hook_front",
    "hook_rear",
    "interlock_left",
    "interlock_right",
    "key",
    "accessory",
)
CASING_MASTERS = ("hook_front", "hook_rear", "key", "force", "accessory")


@pytest.fixture(scope="session")
def coarse():
    """Models, components and system of the scene at its coarse size."""
    steel = fem.Material(E=170e9, nu=0.3, rho=8200)
    vane_model = fem.assemble(mesh.vane_segment(size="coarse"), steel)
    casing_model = fem.assemble(mesh.casing_sector(size="coarse"), steel)
    vane = rom.reduce(vane_model, VANE_MASTERS, modes=10)
    casing = rom.reduce(casing_model, CASING_MASTERS, modes=10, nodal_diameters=[0, 1, 3, 8])
    system = rom.join(vane, casing, JOINTS, rom.Excitation(1, force=30.0), damping_ratio=0.003)

    @lru_cache
    def truth(k, interlock):
        """Six frequencies, Hz, and vectors of the unreduced sector."""
        joints = JOINTS if interlock == "closed" else JOINTS[:1]
        omega2, vectors = fem.eigenpairs(*rom.unreduced(vane_model, casing_model, joints, k), 6)
        return np.sqrt(omega2) / (2 * np.pi), vectors

    return SimpleNamespace(
        truth=truth,
        vane_model=vane_model,
        casing_model=casing_model,
        vane=vane,
        casing=casing,
        system=system,
        joints=JOINTS,
        joined_dofs=joined_dofs(vane, casing),
        interlock=np.array([name == "interlock" for name in system.contacts.joint]),
    )
