"""Outlines with fillets, and the solids revolved from them, against closed forms."""

import numpy as np
import pytest

from vanelock.mesh.generate import occ_solids
from vanelock.mesh.geometry.revolved import Corner, edges
from vanelock.mesh.gmsh_session import session

QUARTER = 1 - np.pi / 4  # of r²: what a fillet covers in a right angle
CENTROID = (10 - 3 * np.pi) / (12 - 3 * np.pi)  # of r: its distance from either side


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
