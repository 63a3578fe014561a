"""Fillets of rails and hooks: what they add, where they end, and which are refused."""

from typing import Any

import numpy as np
import pytest

from vanelock.mesh import (
    CasingDimensions,
    Part,
    VaneDimensions,
    casing_sector,
    hook_overlap,
    quality,
    vane_segment,
)

FILLET = 0.0015
ONE: dict[str, Any] = {"aerofoils": 1, "root_fillet": 0}


def made(name: str, fillet: float, size: float) -> Part:
    if name == "casing":
        return casing_sector(CasingDimensions(fillet=fillet), size=size)
    return vane_segment(VaneDimensions(fillet=fillet, **ONE), size=size)


@pytest.mark.parametrize("name", ["casing", "vane"])
def test_fillets_fill_their_corners(name: str) -> None:
    """Nodes in the corner's square lie on or behind the arc, which has its own on every piece."""
    part = made(name, FILLET, 0.025)
    figures = quality(part)
    assert figures.smallest_jacobian > 0
    assert figures.smallest_sicn > 0.02
    r, z = np.hypot(*part.points.T[:2]), part.points[:, 2]
    centres = {
        "casing": [
            (0.600, 0.058, -1, -1),
            (0.600, 0.082, -1, 1),
            (0.592, 0.066, -1, 1),
            (0.584, 0.066, 1, 1),
        ],
        "vane": [(0.573, 0.0885, 1, 1), (0.573, 0.084, 1, -1), (0.584, 0.084, -1, -1)],
    }[name]
    both = [*centres, *((radius, 0.2 - at, out, -along) for radius, at, out, along in centres)]
    for radius, at, out, along in both:
        across, deep = out * (r - radius) / FILLET, along * (z - at) / FILLET
        inside = (across > -1e-6) & (deep > -1e-6) & (across < 1 + 1e-6) & (deep < 1 + 1e-6)
        distance = np.hypot(1 - across[inside], 1 - deep[inside])
        assert distance.min() > 0.85  # 0.92 on a chord of 45 degrees, 0.71 on one of 90
        on = np.abs(distance - 1) < 1e-3
        angle = np.degrees(np.arctan2(1 - across[inside][on], 1 - deep[inside][on]))
        for expected in (0, 45, 90):
            assert np.sum(np.abs(angle - expected) < 0.1) > 10, (radius, at, expected)


def test_fillets_add_pappus_volume() -> None:
    """Area of each times its centroid's way, 0.2234 r off its cylinder, on arcs of two parabolas.

    A quadratic side through both ends and the middle of 45 degrees encloses 2/3 of chord times
    height instead of the circle's segment, which leaves 0.29 % more in the corner.
    """
    eighth = np.pi / 8
    segment = 2 / 3 * 2 * np.sin(eighth) * (1 - np.cos(eighth))
    area = FILLET**2 * (1 - np.sin(2 * eighth) - 2 * segment)
    assert area / FILLET**2 == pytest.approx(1.0029 * (1 - np.pi / 4), rel=1e-4)
    off = (10 - 3 * np.pi) / (12 - 3 * np.pi) * FILLET
    radii = [0.600 - off, 0.600 - off, 0.592 - off, 0.584 + off]
    plain, rounded = (quality(made("casing", fillet, 0.0125)).volume for fillet in (0.0, FILLET))
    expected = 2 * sum(area * np.pi / 8 * radius for radius in radii)
    # Some sides are straightened where elements are thin.
    assert rounded - plain == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize("wanted", [326, 301])
def test_faces_with_fillets_have_the_number_of_nodes_asked_for(wanted: int) -> None:
    part = casing_sector(CasingDimensions(fillet=FILLET), size=0.0125, face_nodes=wanted)
    left, right = (part.points[part.node_sets[side]] for side in ("left", "right"))
    assert len(left) == wanted
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    turned = left @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    assert np.abs(turned - right).max() < 1e-12 * 0.625
    # Two pieces of each of the eight arcs, so that their middles are corner nodes.
    middle = FILLET * (1 - np.sqrt(0.5))
    places = np.column_stack([np.hypot(left[:, 0], left[:, 1]), left[:, 2]])
    for radius, z in [(0.600 - middle, 0.058 - middle), (0.584 + middle, 0.066 + middle)]:
        for at in (z, 0.2 - z):
            assert np.linalg.norm(places - [radius, at], axis=1).min() < 1e-9


def test_contact_patches_end_where_the_fillets_begin() -> None:
    """A groove rounded as far as the foot reaches into it, and a foot whose fillet is as large."""
    vane, casing = VaneDimensions(fillet=0.0015), CasingDimensions(fillet=0.003)
    assert hook_overlap(VaneDimensions(), CasingDimensions()) == (0.068, 0.082)
    moved = VaneDimensions(foot_front=0.065, leg_front=0.080)
    assert hook_overlap(moved, CasingDimensions()) == (0.066, 0.080)
    assert hook_overlap(vane, casing) == pytest.approx((0.069, 0.082))
    assert hook_overlap(VaneDimensions(fillet=0.004), casing) == pytest.approx((0.069, 0.080))
    part = casing_sector(casing, size=0.025)
    for name in ("hook_front", "hook_rear"):
        weights = part.patches[name]
        assert weights.shape == (30, len(part.points))
        assert np.abs(weights.sum(axis=1) - 1).max() < 1e-12
        means = weights @ part.points
        at = np.abs(means[:, 2] - 0.1)
        assert at == pytest.approx(np.full(30, 0.1 - 0.0755), abs=1e-12)
