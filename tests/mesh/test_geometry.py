"""Dimensions, places, outlines and volumes in closed form; estimates of what a mesh has."""

import numpy as np
import pytest

from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    check_fit,
    on_aerofoil,
    quality,
    vane_segment,
)
from vanelock.mesh.element_size import element_size
from vanelock.mesh.generate import occ_solids
from vanelock.mesh.generate.mesher import matching
from vanelock.mesh.geometry.aerofoil import around, output_points
from vanelock.mesh.geometry.revolved import Corner
from vanelock.mesh.gmsh_session import session
from vanelock.mesh.refinement import (
    MOST,
    casing_dofs,
    check_size,
    vane_dofs,
)


def test_lengths_and_angles_take_units() -> None:
    vane = VaneDimensions(chord="54 mm", stagger="0.5 rad", hook={"roof_radius": "59.2 cm"})
    assert vane.chord == pytest.approx(0.054, rel=1e-15)
    assert vane.stagger == pytest.approx(28.64788975654116, rel=1e-14)
    assert vane.hook.roof_radius == pytest.approx(0.592, rel=1e-15)


def test_every_dimension_says_what_it_is() -> None:
    for model in (VaneDimensions, CasingDimensions, HookDimensions):
        for name, field in model.model_fields.items():
            assert name == "hook" or len(field.description or "") > 15, name


@pytest.mark.parametrize("slant", [-30.0, 0.0, 55.0, 60.0])
def test_refused_chord_is_the_one_that_reaches_the_interlock(slant: float) -> None:
    """The limit against the distance of every profile point from the shroud's slanted end."""
    dimensions = VaneDimensions(interlock_slant=slant, outer_shroud_extent=0.999)

    def distance(chord: float) -> float:
        # Half a turn about the radial axis takes the left end to the right one.
        points = around(dimensions.model_copy(update={"chord": chord}), pieces=24)
        across, axial = np.concatenate([points, -points]).T
        angle = np.pi / 16 * 3 / 4 + np.arctan(across / 0.421)  # of the outermost aerofoil
        x, y = np.hypot(0.421, across) * np.array([np.cos(angle), np.sin(angle)])
        end = np.array([-np.sin(np.pi / 16), np.cos(np.pi / 16)]) @ [x, y]
        return float((axial * np.sin(np.radians(slant)) - end * np.cos(np.radians(slant))).min())

    low, high = 0.01, 0.12
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if distance(middle) > 5e-4 else (low, middle)
    casing = CasingDimensions()
    wide = {"inner_shroud_front": 0.01, "outer_shroud_front": 0.01}
    changed = dimensions.model_copy(update=wide)
    check_fit(changed.model_copy(update={"chord": low - 1e-6}), casing, 16)
    with pytest.raises(InputError, match=r"^vane\.chord"):
        check_fit(changed.model_copy(update={"chord": low + 1e-6}), casing, 16)


def test_sizes_have_names_and_limits() -> None:
    assert element_size("medium", "casing") == 0.0125
    assert element_size("medium", "vane") == 0.016
    assert element_size(0.01, "vane") == 0.01
    refused('^mesh.size = "tiny": allowed are "coarse", "medium",', element_size, "tiny", "vane")
    for size in (0.0, -0.01, 1.0, float("nan")):
        refused(r"^mesh\.size = .* m: must lie between 0.001 and", element_size, size, "vane")


def test_nodes_off_their_places_are_an_error() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    every = np.arange(3)
    assert matching(points, every, points[[2, 0, 1]] + 1e-9, "x").tolist() == [2, 0, 1]
    with pytest.raises(InputError, match="^casing force: 3 nodes, expected 2$"):
        matching(points, every, points[:2], "casing force")
    with pytest.raises(InputError, match="^vane key: a node lies 0.001 m off its place$"):
        matching(points, every, points + np.array([0.001, 0, 0]), "vane key")
    refused("two places share a node", matching, points, every, points[[0, 0, 1]], "vane key")


VANE = VaneDimensions()


def test_places_lie_on_the_profile_between_the_shrouds_and_normals_point_away():
    nodes = output_points(VANE, 16)  # at mid-chord of the convex side
    for span, node in zip((0.25, 0.5, 0.75), nodes, strict=True):
        place = on_aerofoil(VANE, 16, 2, span, 0.5, "suction")
        assert np.linalg.norm(place.position - node) < 1e-14
    for number in (1, 4):
        for span, radius in enumerate(
            (VANE.inner_shroud_outer_radius, VANE.outer_shroud_inner_radius)
        ):
            at = on_aerofoil(VANE, 16, number, span, 0.3, "pressure").position
            assert np.hypot(*at[:2]) == pytest.approx(radius, rel=1e-14)
    convex, concave = (on_aerofoil(VANE, 16, 3, 0.4, 0.5, s) for s in ("suction", "pressure"))
    apart = convex.position - concave.position
    along = [np.linalg.norm(apart), convex.normal @ apart, -concave.normal @ apart]
    assert along == pytest.approx([VANE.thickness] * 3, rel=1e-3)


def test_directions_are_tangents_and_turn_from_span_to_chord():
    places = [on_aerofoil(VANE, 16, 1, 0.3, c, "suction", "chord") for c in (0.2, 0.2 + 1e-6)]
    span = on_aerofoil(VANE, 16, 1, 0.3, 0.2, "suction", "span").direction
    step = places[1].position - places[0].position
    step -= (step @ span) * span  # the shroud that the span counts from is round
    assert places[0].direction == pytest.approx(step / np.linalg.norm(step), abs=1e-4)
    assert places[0].direction @ places[0].normal == pytest.approx(0, abs=1e-12)
    half = on_aerofoil(VANE, 16, 1, 0.3, 0.2, "suction", 30.0).direction
    assert half == pytest.approx(
        np.cos(np.pi / 6) * span + np.sin(np.pi / 6) * places[0].direction, abs=1e-12
    )
    # From front to rear: the trailing edge lies at the larger z.
    assert places[0].direction[2] > 0


@pytest.mark.parametrize(("given", "message"), [
    ({"aerofoil": 5}, "aerofoil = 5: allowed are 1 to 4"),
    ({"span": 1.2}, "span = 1.2: allowed are 0 to 1"),
    ({"chord": -0.1}, "chord = -0.1: allowed are 0 to 1"),
])  # fmt: skip
def test_what_is_refused(given, message):
    refused(message, on_aerofoil, VANE, 16, **{"aerofoil": 1, "span": 0.5, "chord": 0.5} | given)


QUARTER = 1 - np.pi / 4  # of r²: what a fillet covers in a right angle


CENTROID = (10 - 3 * np.pi) / (12 - 3 * np.pi)  # of r: its distance from either side


@pytest.mark.parametrize(("corner", "sign"), [(3, 1), (4, -1)], ids=["concave", "convex"])
def test_revolved_fillets_have_pappus_volume(corner: int, sign: int) -> None:
    """A step in a ring: the fillet's area times the way of its centroid."""
    step = [(0.5, 0.0), (0.7, 0.0), (0.7, 0.1), (0.6, 0.1), (0.6, 0.3), (0.5, 0.3)]
    fillet, half = 0.02, 0.2
    corners = [Corner(*place, fillet if i == corner else 0.0) for i, place in enumerate(step)]
    with session("step") as gmsh:
        solid = occ_solids.revolve(gmsh, corners, half)
        gmsh.model.occ.synchronize()
        volume = gmsh.model.occ.getMass(*solid)
        kinds = [gmsh.model.getType(2, tag) for _, tag in gmsh.model.getEntities(2)]
    ring = half * ((0.7**2 - 0.5**2) * 0.1 + (0.6**2 - 0.5**2) * 0.2)
    added = sign * QUARTER * fillet**2 * 2 * half * (0.6 + sign * CENTROID * fillet)
    assert volume == pytest.approx(ring + added, rel=1e-9)
    assert kinds.count("Torus") == 2


def turned(angle, *rectangles):
    """Volume of rectangles (r from, r to, z from, z to) turned by an angle."""
    return sum(angle * (b**2 - a**2) / 2 * (d - c) for a, b, c, d in rectangles)


def test_a_casing_s_is_that_of_shell_flanges_and_rails():
    """All dimensions but those of the fillets and bosses, none of them at its default."""
    casing = CasingDimensions(
        length=0.206, inner_radius=0.601, outer_radius=0.606, flange_radius=0.631,
        flange_thickness=0.0127, rail_inner_radius=0.579, rail_front=0.056, groove_bottom=0.067,
        groove_mouth=0.083,
    )  # fmt: skip
    hook = HookDimensions(roof_radius=0.593, lip_radius=0.5845, mid_plane=0.103)
    part, angle = casing_sector(casing, sectors=20, hook=hook, size="coarse"), 2 * np.pi / 20
    shell = turned(angle, (0.601, 0.606, 0, 0.206))
    flange = turned(angle, (0.606, 0.631, 0, 0.0127))
    rail = turned(angle, (0.579, 0.601, 0.056, 0.083)) - turned(
        angle, (0.5845, 0.593, 0.067, 0.083)
    )
    assert part.cad_volume == pytest.approx(shell + 2 * flange + 2 * rail, rel=1e-9)
    assert quality(part).volume == pytest.approx(part.cad_volume, rel=1e-6)  # curved like it


def test_a_vane_s_is_that_of_shrouds_and_aerofoils():
    vane = VaneDimensions(
        aerofoils=3, chord=0.049, thickness=0.0055, edge_thickness=0.0026, camber=0.0, stagger=5.0,
        root_fillet=0.0, inner_shroud_inner_radius=0.411, inner_shroud_outer_radius=0.434,
        inner_shroud_front=0.071, outer_shroud_inner_radius=0.566, outer_shroud_outer_radius=0.574,
        outer_shroud_front=0.059, outer_shroud_extent=0.95, foot_front=0.0675, leg_front=0.0845,
        leg_rear=0.0895,
    )  # fmt: skip
    pitch = 2 * np.pi / 16
    part = vane_segment(vane, size="coarse")
    # The slanted faces are each other's image, so that the inner shroud fills the whole pitch.
    plate = turned(0.95 * pitch, (0.566, 0.574, 0.059, 0.141))
    leg = turned(0.95 * pitch, (0.574, 0.592, 0.0845, 0.0895), (0.584, 0.592, 0.0675, 0.0845))
    shrouds = plate + 2 * leg + turned(pitch, (0.411, 0.434, 0.071, 0.129))
    mean = 0.0026 + 2 / 3 * (0.0055 - 0.0026)  # of a parabola; parabolas round the edges
    section = (0.049 - 0.0026) * mean + 2 / 3 * 0.0026**2
    volume = shrouds + 3 * section * (0.566 - 0.434)
    assert part.cad_volume == pytest.approx(volume, rel=3e-4)
    assert quality(part).volume == pytest.approx(part.cad_volume, rel=3e-3)


def test_an_aerofoil_that_leans_has_its_outer_end_at_the_larger_angle():
    vane = VaneDimensions(aerofoils=1, lean=9.0, twist=6.0, root_fillet=0)
    part = vane_segment(vane, size="coarse")
    r, angle = np.hypot(*part.points[:, :2].T), np.arctan2(part.points[:, 1], part.points[:, 0])
    between = (r > 0.440) & (r < 0.560)
    height, sideways = r[between] * np.cos(angle[between]), r[between] * np.sin(angle[between])
    slope = np.polyfit(height, sideways, 1)[0]
    assert slope == pytest.approx(np.tan(np.radians(9.0)), rel=0.1)


@pytest.mark.parametrize(("vane_size", "vane", "size", "casing"), [
    # degrees of freedom of meshes that are too large to be made in a test
    (0.010, 124470, 0.006, 108777),
    (0.008, 193971, 0.005, 161760),
    (0.006, 354099, 0.004, 259428),
])  # fmt: skip
def test_estimates_are_near_large_meshes(
    vane_size: float, vane: int, size: float, casing: int
) -> None:
    assert vane_dofs(VaneDimensions(), 16, vane_size) == pytest.approx(vane, rel=0.1)
    estimated = casing_dofs(CasingDimensions(), HookDimensions(), 16, size)
    assert estimated == pytest.approx(casing, rel=0.2)


def test_too_large_meshes_are_refused_with_the_smallest_size() -> None:
    vane, casing = VaneDimensions(root_fillet=0), CasingDimensions()
    dofs = vane_dofs(vane, 16, 0.002) + casing_dofs(casing, vane.hook, 16, 0.002, 3)
    with pytest.raises(InputError) as caught:
        check_size(0.002, vane, casing, 16)
    message = str(caught.value)
    assert message.startswith(
        f"mesh.size = 2 mm: about {round(dofs, -5):,.0f} degrees of freedom: at most {MOST:,} "
    )
    assert message.endswith(" mm here")
    smallest = 1e-3 * float(message.partition("sizes from ")[2].split()[0])
    assert smallest == pytest.approx(0.004, abs=2e-4)
    check_size(smallest, vane, casing, 16)
    with pytest.raises(InputError):
        check_size(smallest - 1e-4, vane, casing, 16)
    # A name is refused as well where the parts are large.
    large = CasingDimensions(outer_radius=4.9, flange_radius=5.0)
    refused(r'^mesh\.size = "medium": about', check_size, "medium", vane, large, 6)
