"""Which faces of a vane's surface are an aerofoil's: their area and order."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import VaneDimensions, vane_segment
from vanelock.mesh.geometry import aerofoil
from vanelock.mesh.geometry.aerofoil import aerofoil_faces

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
    found = aerofoil_faces(part, STRAIGHT)
    angle = [np.arctan2(*part.points[faces].mean(axis=(0, 1))[1::-1]) for faces in found]
    assert len(found) == 2
    assert angle[0] < angle[1]
    for faces in found:
        assert area(part, faces) == pytest.approx(perimeter * span, rel=0.01)


def test_root_fillets_are_counted_in(straight):
    filleted = STRAIGHT.model_copy(update={"root_fillet": 0.003})
    both = ((STRAIGHT, straight), (filleted, vane_segment(filleted, sectors=16, size="coarse")))
    areas = [
        sum(area(part, faces) for faces in aerofoil_faces(part, dimensions))
        for dimensions, part in both
    ]
    assert areas[0] * 0.97 < areas[1] < areas[0] * 1.03


def test_another_number_of_aerofoils_is_refused(straight):
    with pytest.raises(InputError, match="2 surfaces between the shrouds, not one an aerofoil"):
        aerofoil_faces(straight, STRAIGHT.model_copy(update={"aerofoils": 3}))
