"""Strut bosses: volumes against closed forms, where they stand, and which are refused."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from vanelock.mesh import CasingDimensions, casing_sector, quality
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.bosses import add_bosses, boss_angles
from vanelock.mesh.geometry.dimensions import HookDimensions
from vanelock.mesh.geometry.revolved import Corner
from vanelock.mesh.gmsh_session import session
from vanelock.mesh.refinement import _casing_plates


def outside(radius: float, height: float, shell: float) -> float:
    """Volume between a cylinder about z and the end of a radial cylinder, by slices along z."""
    gap = quad(
        lambda s: 2 * np.sqrt(radius**2 - s**2) * (shell + height - np.sqrt(shell**2 - s**2)),
        -radius,
        radius,
        epsabs=1e-15,
    )
    return float(gap[0])


@pytest.mark.parametrize(
    ("count", "changes"),
    [(1, {}), (3, {"boss_height": 0.02}), (2, {"boss_diameter": 0.06, "boss_position": 0.05})],
)
def test_bosses_add_the_cylinders_outside_the_shell(count: int, changes: dict[str, Any]) -> None:
    casing = CasingDimensions(bosses=count, **changes)
    tube = [
        Corner(radius, z) for radius, z in ((0.600, 0.0), (0.604, 0.0), (0.604, 0.2), (0.600, 0.2))
    ]
    with session("casing") as gmsh:
        shell = occ_solids.revolve(gmsh, tube, np.pi / 16)
        before = gmsh.model.occ.getMass(*shell)
        after = gmsh.model.occ.getMass(*add_bosses(gmsh, casing, 16, shell))
    assert before == pytest.approx(np.pi * (0.604**2 - 0.600**2) * 0.2 / 16, rel=1e-9)
    each = outside(casing.boss_diameter / 2, casing.boss_height, 0.604)
    # The kernel integrates faces with curved borders to some 1e-5; a flat shell would be 3e-3 off.
    assert after - before == pytest.approx(count * each, rel=1e-4)


def test_bosses_stand_evenly_over_the_whole_ring() -> None:
    angles = boss_angles(CasingDimensions(bosses=3), 16)
    ring = np.concatenate([angles + 2 * np.pi / 16 * k for k in range(16)])
    assert np.diff(ring) == pytest.approx(np.full(47, 2 * np.pi / 48))
    assert angles[1] == 0
    assert len(boss_angles(CasingDimensions(), 16)) == 0


def test_bosses_are_meshed_and_leave_the_sets_alone() -> None:
    plain, part = (
        casing_sector(CasingDimensions(bosses=count, boss_height=0.012), size=0.0245, stretch=1)
        for count in (0, 2)
    )
    figures = quality(part)
    assert figures.smallest_jacobian > 0
    assert figures.smallest_sicn > 0.02
    added = figures.volume - quality(plain).volume
    # Sixteen quadratic sides at least: inscribed in the circle, and 5 % below it if straight.
    assert added == pytest.approx(2 * outside(0.0125, 0.012, 0.604), rel=0.12)
    for name in ("hook_front", "hook_rear", "key", "force", "output", "left", "right"):
        mine, theirs = (other.points[other.node_sets[name]] for other in (part, plain))
        if name in ("left", "right"):
            assert len(mine) == len(theirs)
        else:
            assert np.array_equal(mine, theirs)
    # The tops are planes, 616 mm from the axis at both angles, and hold the cylinders' round edges.
    for angle in np.pi / 16 * np.array([-0.5, 0.5]):
        along = part.points @ [np.cos(angle), np.sin(angle), 0]
        across = part.points @ [-np.sin(angle), np.cos(angle), 0]
        off = np.hypot(across, part.points[:, 2] - 0.035)
        near = off < 0.0125 + 1e-9
        assert along[near].max() == pytest.approx(0.616, abs=1e-9)
        top = np.abs(along - 0.616) < 1e-9
        assert np.sum(top & near & (off > 0.0125 - 1e-9)) >= 8


def test_bosses_and_fillets_go_together_with_exact_faces() -> None:
    casing = CasingDimensions(bosses=2, fillet=0.0015)
    part = casing_sector(casing, size=0.0125, face_nodes=326)
    assert len(part.node_sets["left"]) == 326
    figures = quality(part)
    assert figures.smallest_jacobian > 0
    assert figures.smallest_sicn > 0.02


def test_bosses_are_among_the_plates_of_the_estimate() -> None:
    plates = _casing_plates(CasingDimensions(bosses=3), HookDimensions(), 16)
    area, thickness = plates[-1]
    assert area * thickness == pytest.approx(3 * outside(0.0125, 0.010, 0.604), rel=0.01)
