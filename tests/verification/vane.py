"""The vane of the verifications: that of their samples, its limits, peaks and other interlocks.

The sample's has 14 contacts in place of 66 and few elements; its joints are as stiff as a whole.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tests.conftest import CASING_MASTERS, VANE_MASTERS
from tests.nonlinear.systems import solved_response
from tests.verification.nonlinear.spring_rings import loaded
from vanelock import fem, mesh, rom
from vanelock.nonlinear import Options
from vanelock.stages.parts.segment import Joint, Segment

STEEL = fem.Material(E=170e9, nu=0.3, rho=8200)
HOOK = mesh.HookDimensions(band_nodes=3)
DIMENSIONS = mesh.VaneDimensions(hook=HOOK, interlock_nodes=3, root_fillet=0.0)
SIZE = 0.04
JOINTS = (
    Joint("hook", kn=1.17e8, kt=1.17e8, mu=0.3, interference=20e-6),
    Joint("interlock", kn=1.67e6, kt=1.67e6, mu=0.15, interference=2e-6),
)


def small_parts() -> tuple[tuple[fem.Model, fem.Model], rom.Component, rom.Component]:
    """Models and components of the vane and the casing."""
    vane_model = fem.assemble(mesh.vane_segment(DIMENSIONS, size=SIZE), STEEL)
    casing_model = fem.assemble(mesh.casing_sector(hook=HOOK, size=SIZE), STEEL)
    vane = rom.reduce(vane_model, VANE_MASTERS)
    casing = rom.reduce(
        casing_model, CASING_MASTERS, nodal_diameters=[0, 1, 2, 3, 8], band=vane.band
    )
    return (vane_model, casing_model), vane, casing


def with_all_diameters(scene: SimpleNamespace) -> rom.System:
    """The system of a scene with all nodal diameters of its ring."""
    casing = rom.reduce(scene.casing_model, CASING_MASTERS, modes=10, nodal_diameters=range(9))
    return Segment(scene.joints, 1, 30.0, damping_ratio=0.003).join(scene.vane, casing)


def interlocked(
    system: rom.System, mu: float | None = None, v0: float | None = None, load: float = 1.0
) -> rom.System:
    """The vane's system with another friction and interference, m, of the interlock, and load."""
    contacts = system.contacts
    values = {"mu": mu, "v0": v0}
    values = {name: value for name, value in values.items() if value is not None}
    own = contacts.of("interlock")
    changed = {n: np.where(own, value, getattr(contacts, n)) for n, value in values.items()}
    return loaded(replace(system, contacts=replace(contacts, **changed)), load)


def second_mode(system: rom.System) -> tuple[float, float, float]:
    """Frequencies of the second ND 1 mode, interlock free and stuck, followed by MAC; the MAC."""
    free, shapes = rom.linear_modes(system, 1, 6, ~system.contacts.of("interlock"))
    stuck, others = rom.linear_modes(system, 1, 6)
    agreement = rom.mac(shapes, others, system.at(1).M)[1]
    follower = int(np.argmax(agreement))
    return free[1], stuck[follower], agreement[follower]


def highest(
    system: rom.System, near: tuple[float, float], options: Options | None = None
) -> tuple[float, float]:
    """Frequency, Hz, and amplitude of the first output's highest peak."""
    response = solved_response(system, near, options or Options(1))
    size = response.amplitude[:, 0].max(axis=1)
    top = int(size.argmax())
    return float(response.frequency[top]), float(size[top])
