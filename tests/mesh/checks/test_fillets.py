"""Fillets of rails and hooks: what they add, where they end, and which are refused."""

from typing import Any

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    Part,
    VaneDimensions,
    casing_sector,
    check_fit,
    hook_overlap,
    quality,
    vane_segment,
)
from vanelock.mesh.refinement.dof_estimate import check_size

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


@pytest.mark.parametrize(
    ("vane", "casing", "expected"),
    [
        (
            {},
            {"fillet": 0.002},
            "casing.fillet = 0.002 m: between casing.groove_bottom and vane.foot_front at most "
            "0.0015 m fits",
        ),
        (
            {"fillet": 0.0018},
            {},
            "vane.fillet = 0.0018 m: between casing.groove_mouth and vane.leg_front at most "
            "0.0015 m fits",
        ),
        (
            {},
            {"fillet": 0.004},
            "casing.fillet = 0.004 m: between vane.hook.lip_radius and vane.hook.roof_radius at "
            "most 0.00375 m fits",
        ),
        (
            {},
            {"fillet": 0.003, "inner_radius": 0.595},
            "casing.fillet = 0.003 m: between vane.hook.roof_radius and casing.inner_radius at "
            "most 0.0025 m fits",
        ),
        (
            {"fillet": 0.006},
            {},
            "vane.fillet = 0.006 m: between vane.outer_shroud_outer_radius and "
            "vane.hook.lip_radius at most 0.00525 m fits",
        ),
        (
            {"fillet": 0.002, "leg_rear": 0.0985},
            {},
            "vane.fillet = 0.002 m: between vane.leg_rear and its mirror image at most 0.00125 m",
        ),
        (
            {"fillet": 0.001, "outer_shroud_front": 0.0828},
            {},
            "vane.fillet = 0.001 m: between vane.outer_shroud_front and vane.leg_front at most "
            "0.0007 m fits",
        ),
        (
            {"fillet": 0.001, "outer_shroud_front": 0.0835},
            {},
            "vane.fillet = 0.001 m: between vane.outer_shroud_front and vane.leg_front none fits",
        ),
    ],
)
def test_fillets_that_do_not_fit_are_refused(
    vane: dict[str, Any], casing: dict[str, Any], expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        check_fit(VaneDimensions(**vane), CasingDimensions(**casing), 16)
    assert str(caught.value).startswith(expected)
    assert "\n" not in str(caught.value)


def test_largest_fillets_that_fit_are_meshed() -> None:
    """At the limits of either part alone, where sides of half a millimetre are left."""
    for part in (
        casing_sector(CasingDimensions(fillet=0.00375), size=0.03),
        vane_segment(VaneDimensions(fillet=0.00525, **ONE), size=0.03),
    ):
        assert quality(part).smallest_jacobian > 0


def test_fillets_too_small_for_any_mesh_or_for_this_one_are_refused() -> None:
    for model in (VaneDimensions, CasingDimensions):
        assert model(fillet=0.0).fillet == 0
        assert model(fillet=0.0005).fillet == 0.0005
        with pytest.raises(ValueError, match=r"fillet = 0\.0001 m: must be 0 or at least 0\.0005"):
            model(fillet=0.0001)
    expected = (
        r"^casing\.fillet = 0\.001 m: too small for elements of 25 mm: allowed are 0, 0\.00125 m "
        r"and more, or mesh\.size up to 0\.02 m$"
    )
    small = CasingDimensions(fillet=0.001)
    with pytest.raises(InputError, match=expected):
        casing_sector(small, size=0.025)
    with pytest.raises(InputError, match=expected):
        check_size(0.025, VaneDimensions(), small, 16)
    with pytest.raises(InputError, match=r"^vane\.fillet = 0\.001 m: too small"):
        vane_segment(VaneDimensions(fillet=0.001), size=0.041)
    check_size(0.039, VaneDimensions(fillet=0.001), None, 16)  # half as long where fillets are
    check_size(0.02, VaneDimensions(fillet=0.001), small, 16)
