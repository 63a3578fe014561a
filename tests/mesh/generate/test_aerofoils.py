"""Aerofoils in rows and columns with fillets; which of several meshes is kept."""

import numpy as np
import pytest

from tests.refusals import refused
from vanelock.common.cyclic import rotation
from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions, quality, vane_segment
from vanelock.mesh.element_size import SLENDER
from vanelock.mesh.generate import mesher
from vanelock.mesh.generate.aerofoils import _divide_filleted, arc_rows, divisions
from vanelock.mesh.generate.mesher import _level
from vanelock.mesh.generate.vane import _vane_solid
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.root_fillet import _SLANT, feet, strips, volume
from vanelock.mesh.gmsh_session import session
from vanelock.stages.parts.loads import _aerofoil_faces

# Thin aerofoils, 320 in the ring: between them coarse elements would find no way of their own.
THIN = VaneDimensions(
    aerofoils=2,
    chord=0.008,
    thickness=0.0006,
    edge_thickness=0.0003,
    interlock_slant=30,
    root_fillet=0.0,
)


SHARP = VaneDimensions(aerofoils=2, root_fillet=0.0)


def edge_corners(vane, sectors, size):
    """Corner nodes (a, k, 3) where the sides of each aerofoil end, each in its own axes."""
    part = vane_segment(vane, sectors, size)
    corners = part.points[np.unique(part.cells[:, :4])]
    ends = []
    for angle in aerofoil.angles(vane, sectors):
        turned = (corners - [0, 0, vane.hook.mid_plane]) @ rotation(angle)
        for side in (0, 1):
            for station in (-1.0, 1.0):
                line = aerofoil.outline(vane, np.array([station]))[side, 0]
                ends.append(turned[np.linalg.norm(turned[:, 1:] - line, axis=1) < 1e-6])
    return part, ends


@pytest.mark.parametrize(("vane", "sectors"), [(SHARP, 16), (THIN, 160)])
def test_edges_of_aerofoils_carry_a_node_at_the_end_of_every_row(vane, sectors):
    size = 0.025
    part, ends = edge_corners(vane, sectors, size)
    found = divisions(vane, size)
    assert (found.rows % 2, found.columns % 2) == (0, 0)
    low, high = vane.inner_shroud_outer_radius, vane.outer_shroud_inner_radius
    for line in ends:
        inside = line[np.hypot(line[:, 0], line[:, 1]) > low - 1e-6]
        assert len(inside) == found.rows + 1
        height = np.sort(inside[:, 0])
        step = np.diff(height)
        even = (high - low) / (2 * (found.rows - 2 * found.outer))  # of rows of one height
        assert step.max() < 1.1 * even
        assert even < min(size, SLENDER * vane.edge_thickness)
        assert step.max() < 1.07 * SLENDER * vane.edge_thickness
        # Short at the shrouds, or for thin edges short everywhere.
        longest = step.max() if 4 * found.outer > found.rows else size
        assert step[0] < 0.6 * longest
        assert step[-1] < 0.6 * longest
        for share in (0.25, 0.5, 0.75):  # output nodes stand there
            wanted = height[0] + share * np.ptp(height)
            assert abs(height - wanted).min() < 1e-3 * np.ptp(height)
    assert quality(part).smallest_sicn > 0.05


def test_camber_and_thin_edges_ask_for_more_columns_and_rows():
    usual = VaneDimensions()
    assert divisions(usual, 0.03) == (12, 4, 4)  # 135 mm by 47 mm
    assert divisions(usual, 0.012) == (16, 5, 8)
    assert divisions(VaneDimensions(lean=25), 0.012) == (22, 7, 8)  # 149 mm along the leaning edge
    assert divisions(VaneDimensions(camber=0.0), 0.05) == (6, 2, 2)
    assert divisions(VaneDimensions(camber=0.3), 0.05) == (6, 2, 4)
    assert divisions(VaneDimensions(edge_thickness=3e-4), 0.03) == (32, 8, 4)  # evenly
    assert divisions(VaneDimensions(edge_thickness=6e-4), 0.012) == (18, 5, 8)


def test_a_node_stands_in_every_row_of_a_mitre() -> None:
    vane = VaneDimensions(aerofoils=1, root_fillet=0.003, lean=5.0, twist=6.0)
    part = vane_segment(vane, size="coarse")
    corners = part.points[np.unique(part.cells[:, :4])] - [0, 0, vane.hook.mid_plane]
    rows = divisions(vane, 0.03).rows
    assert arc_rows(vane) == 3
    for angle in aerofoil.angles(vane, 16):
        turned = corners @ rotation(angle)
        for outer in (False, True):
            for strip, foot in zip(strips(vane, outer), feet(vane, outer), strict=True):
                arc = strip.arc(0, np.linspace(0, 1, 2001))
                off = np.linalg.norm(turned[:, None] - arc[None, ::20], axis=2).min(axis=1)
                near = turned[off < 1e-4]
                exact = np.linalg.norm(near[:, None] - arc[None], axis=2).min(axis=1)
                assert np.sum(exact < 2e-6) == 4
                assert np.linalg.norm(turned - foot, axis=1).min() < 1e-6
        side = aerofoil.outline(vane, np.array([-1.0]))[0, 0]
        line = turned[np.abs(turned[:, 2] - side[1]) < 2e-3]
        assert len(line) >= rows - 1


def test_faces_that_are_missing_are_reported() -> None:
    expected = r"^vane\.root_fillet = 0\.003 m: \d+ faces between the shrouds instead of 96"
    vane = VaneDimensions(root_fillet=0.003)
    with session("vane") as gmsh:
        _vane_solid(gmsh, VaneDimensions(), 16)
        gmsh.model.occ.synchronize()
        refused(expected, _divide_filleted, gmsh, vane, 16, 0.025)


STRAIGHT = VaneDimensions(aerofoils=2, twist=0.0, lean=0.0, root_fillet=0.0)


@pytest.fixture(scope="module")
def straight():
    return vane_segment(STRAIGHT, sectors=16, size="coarse")


def area(part, faces):
    corners = part.points[faces[:, :3]]
    edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.linalg.norm(np.cross(*edges), axis=1).sum() / 2


def test_each_is_a_prism_s_mantle_by_ascending_angle(straight):
    part = straight
    outline = aerofoil.around(STRAIGHT, pieces=400)
    perimeter = np.linalg.norm(np.diff(outline, axis=0, append=outline[:1]), axis=1).sum()
    span = STRAIGHT.outer_shroud_inner_radius - STRAIGHT.inner_shroud_outer_radius
    found = _aerofoil_faces(part, STRAIGHT)
    angle = [np.arctan2(*part.points[faces].mean(axis=(0, 1))[1::-1]) for faces in found]
    assert len(found) == 2
    assert angle[0] < angle[1]
    for faces in found:
        assert area(part, faces) == pytest.approx(perimeter * span, rel=0.01)


def test_root_fillets_are_counted_in(straight):
    filleted = STRAIGHT.model_copy(update={"root_fillet": 0.003})
    both = ((STRAIGHT, straight), (filleted, vane_segment(filleted, sectors=16, size="coarse")))
    areas = [
        sum(area(part, faces) for faces in _aerofoil_faces(part, dimensions))
        for dimensions, part in both
    ]
    assert areas[0] * 0.97 < areas[1] < areas[0] * 1.03


def test_another_number_of_aerofoils_is_refused(straight):
    with pytest.raises(InputError, match="2 surfaces between the shrouds, not one an aerofoil"):
        _aerofoil_faces(straight, STRAIGHT.model_copy(update={"aerofoils": 3}))


EVEN = {"camber": 0.0, "stagger": 0.0, "aerofoils": 1}


def section(vane):
    """Area of a section without camber: parabolas along it and round its edges."""
    mean = vane.edge_thickness + 2 / 3 * (vane.thickness - vane.edge_thickness)
    return (vane.chord - vane.edge_thickness) * mean + 2 / 3 * vane.edge_thickness**2


def added(vane):
    """Volume of a fillet on a flat shroud, whose section has a perimeter P and kinks of 26.6°.

    An offset by d adds Pd + Kd² to the section's area; a convex curve that turns by 2π has
    K = π, of which each kink's angle φ counts tan(φ/2) for φ/2.
    """
    outline = aerofoil.around(vane, pieces=400)
    perimeter = np.linalg.norm(np.diff(outline, axis=0, append=outline[:1]), axis=1).sum()
    kink = np.arctan(0.5) - np.arctan(
        2 * (vane.thickness - vane.edge_thickness) / (vane.chord - vane.edge_thickness)
    )
    rounding = np.pi + 4 * (np.tan(kink / 2) - kink / 2)
    r = vane.root_fillet
    height = np.linspace(0, r * np.cos(_SLANT), 4001)
    offset = r - np.sqrt(r**2 - (r * np.cos(_SLANT) - height) ** 2)
    return np.trapezoid(perimeter * offset + rounding * offset**2, height)


@pytest.mark.parametrize("radius", [0.0005, 0.003])
def test_volume_is_that_of_the_section_and_two_fillets(radius):
    vane = VaneDimensions(**EVEN, root_fillet=radius)
    span = vane.outer_shroud_inner_radius - vane.inner_shroud_outer_radius
    plain = section(vane) * span
    assert volume(vane) == pytest.approx(plain + 2 * added(vane), rel=2e-5)
    assert volume(vane) - plain == pytest.approx(2 * added(vane), rel=1e-2)


ALL = [(finer, split) for split in (False, True) for finer in (1.0, 0.98, 0.96, 0.93, 0.9, 0.86)]


@pytest.mark.parametrize(("qualities", "expected"), [
    ([0.2], [(1.0, False)]),  # the size asked for, where it serves
    ([0.01, 0.2], [(1.0, False), (0.98, False)]),
    # None at all, then an element without height.
    ([-1.0, 0.0, 0.051], [(1.0, False), (0.98, False), (0.96, False)]),
    ([0.01] * 6 + [0.051], [*ALL[:6], (1.0, True)]),  # elements are split only then
    ([0.01, 0.031, *[0.0] * 4], [*ALL[:6], (0.98, False)]),  # or not, and the best made again
    ([0.01, 0.029, *[0.0] * 10], [*ALL, (0.98, False)]),
    ([0.01] * 11 + [0.015], ALL),  # it is there already
])  # fmt: skip
def test_sizes_are_tried_until_one_serves(monkeypatch, qualities, expected):
    tried = []

    def attempt(gmsh, size, local, stretch, same_faces, finer, split):
        tried.append((size * finer, split))
        quality = qualities[(len(tried) - 1) % len(qualities)]
        if quality < 0:
            raise Exception("no mesh")  # as gmsh does
        return quality

    monkeypatch.setattr(mesher, "_attempt", attempt)
    mesher._tetrahedra(None, 1.0)
    assert tried == expected


def test_what_cannot_be_meshed_at_any_size_says_why(monkeypatch):
    def attempt(gmsh, size, local, stretch, same_faces, finer, split):
        raise Exception(f"no mesh at {finer * size}")

    monkeypatch.setattr(mesher, "_attempt", attempt)
    with pytest.raises(Exception, match="no mesh at 1.0"):
        mesher._tetrahedra(None, 1.0)


A, B, C, D, E = range(1, 6)


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def pyramid(gmsh, height, diagonal_held=False):
    """Two tetrahedra under a square, over which a third one lies, whose sides are the face's."""
    model = gmsh.model
    curve = model.addDiscreteEntity(1)
    face, *walls = (model.addDiscreteEntity(2) for _ in range(5))
    body = model.addDiscreteEntity(3)
    places = np.array([*SQUARE, (0.5, 0.5, -1)], float)
    places[[0, 2], 2] = height
    model.mesh.addNodes(3, body, [A, B, C, D, E], places.ravel())
    if diagonal_held:
        model.mesh.addElementsByType(curve, 1, [], [A, C])
    model.mesh.addElementsByType(face, 2, [], [A, B, C, A, C, D])
    for wall, ends in zip(walls, [(A, B), (B, C), (C, D), (D, A)], strict=True):
        model.mesh.addElementsByType(wall, 2, [], [*ends, E])
    model.mesh.addElementsByType(body, 4, [], [A, B, C, D, A, B, D, E, B, C, D, E])
    return face, body


def sets_of(gmsh, kind, count, entity):
    _, nodes = gmsh.model.mesh.getElementsByType(kind, entity)
    return {frozenset(row) for row in np.reshape(nodes, (-1, count)).tolist()}


FLAT = [(A, B, D, E), (B, C, D, E)]


@pytest.mark.parametrize(("height", "held", "counted", "left", "face_left"), [
    (1e-9, False, 0, FLAT, [(A, B, D), (B, C, D)]),  # the other diagonal
    (-0.01, False, 1, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
    (1e-9, True, 1, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
    # As on the ridge of a rounded edge: sound.
    (-0.2, False, 0, [*FLAT, (A, B, C, D)], [(A, B, C), (A, C, D)]),
])  # fmt: skip
def test_an_element_goes_unless_it_has_height_or_a_curve_runs_along_it(
    height, held, counted, left, face_left
):
    with session("pyramid") as gmsh:
        face, body = pyramid(gmsh, height, held)
        assert _level(gmsh) == counted
        assert sets_of(gmsh, 4, 4, body) == set(map(frozenset, left))
        assert sets_of(gmsh, 2, 3, face) == set(map(frozenset, face_left))
