"""The scene with 14 contacts in place of 66 and few elements, for samples of the verifications.

Joints are as stiff as those of the scene as a whole.
"""

from types import SimpleNamespace

from tests.conftest import CASING_MASTERS, VANE_MASTERS
from vanelock import fem, mesh, rom
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
