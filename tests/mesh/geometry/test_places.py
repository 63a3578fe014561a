"""Named nodes stand where the dimensions say, whatever the mesh."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    vane_segment,
)
from vanelock.mesh.generate.mesher import matching


def test_named_nodes_stay_where_they_are_when_the_mesh_changes() -> None:
    one = VaneDimensions(aerofoils=1, root_fillet=0)
    coarse, fine = (vane_segment(one, size=size) for size in (0.03, 0.02))
    assert len(fine.points) > 1.5 * len(coarse.points)
    for name in ("hook_front", "hook_rear", "key", "interlock_left", "output"):
        mine, other = (part.points[part.node_sets[name]] for part in (coarse, fine))
        assert np.array_equal(mine, other)


def test_other_grooves_move_the_bands_of_both_parts() -> None:
    hook = HookDimensions(roof_radius=0.593, lip_radius=0.5835, band_extent=0.8)
    vane = vane_segment(VaneDimensions(hook=hook, aerofoils=1, root_fillet=0), 16, "coarse")
    casing = casing_sector(CasingDimensions(outer_radius=0.605), hook, 16, "coarse")
    for name in ("hook_front", "hook_rear", "key"):
        mine, mate = (p.points[p.node_sets[name]] for p in (vane, casing))
        assert np.abs(mine - mate).max() < 1e-12
    radius = np.hypot(*mine[:, :2].T)
    assert radius == pytest.approx(np.array([0.593, 0.5835, 0.593, 0.5835]), rel=1e-12)


def test_nodes_off_their_places_are_an_error() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    every = np.arange(3)
    assert matching(points, every, points[[2, 0, 1]] + 1e-9, "x").tolist() == [2, 0, 1]
    with pytest.raises(InputError, match="^casing force: 3 nodes, expected 2$"):
        matching(points, every, points[:2], "casing force")
    with pytest.raises(InputError, match="^vane key: a node lies 0.001 m off its place$"):
        matching(points, every, points + np.array([0.001, 0, 0]), "vane key")
    with pytest.raises(InputError, match="two places share a node"):
        matching(points, every, points[[0, 0, 1]], "vane key")
