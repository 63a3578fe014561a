"""Outlines with fillets, and the solids revolved from them, against closed forms."""

import numpy as np
import pytest

from vanelock.mesh.generate import occ_solids
from vanelock.mesh.geometry.outline import Corner, Edge, edges
from vanelock.mesh.gmsh_session import session

QUARTER = 1 - np.pi / 4  # of r²: what a fillet covers in a right angle
CENTROID = (10 - 3 * np.pi) / (12 - 3 * np.pi)  # of r: its distance from either side


def sampled(outline: list[Edge], steps: int = 400) -> np.ndarray:
    """Points (k, 2) along the edges, arcs by the angle about their centres."""
    pieces = []
    for start, end, centre in outline:
        share = np.linspace(0, 1, steps, endpoint=False)[:, None]
        if centre is None:
            pieces.append(start + share * (end - start))
            continue
        first, last = (np.arctan2(*(place - centre)[::-1]) for place in (start, end))
        angle = first + share[:, 0] * ((last - first + np.pi) % (2 * np.pi) - np.pi)
        radius = np.linalg.norm(start - centre)
        pieces.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.concatenate(pieces)


def area(points: np.ndarray) -> float:
    x, y = points.T
    return float(abs(np.roll(x, -1) @ y - x @ np.roll(y, -1)) / 2)


def test_sharp_outlines_are_polygons() -> None:
    corners = [Corner(1.0, 0.0), Corner(2.0, 0.0), Corner(2.0, 1.0), Corner(1.0, 1.0)]
    found = edges(corners)
    assert len(found) == 4
    assert all(edge.centre is None for edge in found)
    starts, ends = (np.array([getattr(edge, name) for edge in found]) for name in ("start", "end"))
    assert np.array_equal(np.roll(starts, -1, axis=0), ends)
    assert area(starts) == 1


@pytest.mark.parametrize("angle", [40.0, 90.0, 130.0])
def test_arcs_are_tangent_to_both_sides(angle: float) -> None:
    """Ends of pieces lie a radius from the centre; the outer ones at the feet of perpendiculars."""
    turned = np.radians(angle)
    corners = [
        Corner(3.0, 1.0),
        Corner(1.0, 1.0, 0.2),
        Corner(1 + 2 * np.cos(turned), 1 + 2 * np.sin(turned)),
    ]
    arcs = [edge for edge in edges(corners) if edge.centre is not None]
    # One piece for each 45 deg of the angle by which the arc turns.
    assert len(arcs) == int(np.ceil((180 - angle) / 45))
    for start, end, centre in arcs:
        assert centre is not None
        assert np.linalg.norm([start - centre, end - centre], axis=1) == pytest.approx(0.2)
    centre = arcs[0].centre
    assert centre is not None
    sides = np.array([[1.0, 0.0], [np.cos(turned), np.sin(turned)]])
    for place, side in zip((arcs[0].start, arcs[-1].end), sides, strict=True):
        assert (place - centre) @ side == pytest.approx(0, abs=1e-14)
        r, z = place - 1.0
        assert side[0] * z - side[1] * r == pytest.approx(0, abs=1e-14)


def test_fillets_take_from_convex_and_give_to_concave_corners() -> None:
    """An L of area 3 with one concave corner and one convex corner rounded."""
    bend = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    for k, sign in ((3, 1), (0, -1)):
        corners = [Corner(*place, 0.3 if i == k else 0.0) for i, place in enumerate(bend)]
        found = area(sampled(edges(corners)))
        assert found == pytest.approx(3 + sign * QUARTER * 0.3**2, abs=1e-6)


def test_revolved_fillets_have_pappus_volume() -> None:
    """A step in a ring: the fillet's area times the way of its centroid."""
    step = [(0.5, 0.0), (0.7, 0.0), (0.7, 0.1), (0.6, 0.1), (0.6, 0.3), (0.5, 0.3)]
    fillet, half = 0.02, 0.2
    corners = [Corner(*place, fillet if i == 3 else 0.0) for i, place in enumerate(step)]
    with session("step") as gmsh:
        solid = occ_solids.revolve(gmsh, corners, half)
        gmsh.model.occ.synchronize()
        volume = gmsh.model.occ.getMass(*solid)
        kinds = [gmsh.model.getType(2, tag) for _, tag in gmsh.model.getEntities(2)]
    ring = half * ((0.7**2 - 0.5**2) * 0.1 + (0.6**2 - 0.5**2) * 0.2)
    added = QUARTER * fillet**2 * 2 * half * (0.6 + CENTROID * fillet)
    assert volume == pytest.approx(ring + added, rel=1e-9)
    assert kinds.count("Torus") == 2
