"""Exact numbers of nodes on the casing's cyclic faces."""

import numpy as np
import pytest

from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh import CasingDimensions, HookDimensions, Part, casing_sector, quality

FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])  # of a tetrahedron
WIDE = CasingDimensions(length=0.23, outer_radius=0.6052, flange_thickness=0.0127, rail_front=0.055)


def face_corners(part: Part, side: str) -> np.ndarray:
    """Triangles (t, 3) whose corners lie on a cyclic face."""
    triangles = part.cells[:, FACES].reshape(-1, 3)
    return np.asarray(triangles[np.isin(triangles, part.node_sets[side]).all(axis=1)])


def check_faces(part: Part, wanted: int) -> None:
    """The number of nodes, the match, and F = 4V - 3 - B of a face without holes."""
    left, right = part.node_sets["left"], part.node_sets["right"]
    assert len(np.unique(left)) == len(np.unique(right)) == wanted
    apart = part.points[left] @ turn(part.sectors).T - part.points[right]
    assert np.abs(apart).max() < 1e-12 * np.hypot(*part.points[left].T[:2]).max()
    triangles = face_corners(part, "left")
    sides, count = np.unique(
        np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1),
        axis=0,
        return_counts=True,
    )
    corners, border = len(np.unique(triangles)), int((count == 1).sum())
    assert 4 * corners - 3 - border == corners + len(sides) == wanted


@pytest.mark.parametrize(("size", "wanted", "changes", "sectors"), [
    (0.010, 326, CasingDimensions(), 16), (0.0125, 300, CasingDimensions(), 18),
    (0.0095, 400, WIDE, 12),
])  # fmt: skip
def test_cyclic_faces_have_the_number_of_nodes_asked_for(
    size: float, wanted: int, changes: CasingDimensions, sectors: int
) -> None:
    part = casing_sector(changes, HookDimensions(), sectors, size, face_nodes=wanted)
    check_faces(part, wanted)
    figures = quality(part)
    assert figures.smallest_jacobian > 0
    assert figures.smallest_sicn > 0.02


def test_every_number_in_reach_is_found_and_is_the_same_mesh_again() -> None:
    """One of each remainder of division by four, which the boundary's count must answer."""
    parts = [casing_sector(size=0.020, face_nodes=wanted) for wanted in (150, 151, 152, 153, 150)]
    for part, wanted in zip(parts, (150, 151, 152, 153), strict=False):
        check_faces(part, wanted)
    assert np.array_equal(parts[0].points, parts[-1].points)
    assert np.array_equal(parts[0].cells, parts[-1].cells)


def test_a_face_keeps_the_rest_of_the_casing() -> None:
    """Only the face's edges are divided otherwise: elements elsewhere follow the size."""
    free, exact = (
        casing_sector(size=0.010, face_nodes=number, stretch=1) for number in (None, 326)
    )
    assert len(exact.points) == pytest.approx(len(free.points), rel=0.02)


@pytest.mark.parametrize(("size", "wanted", "text"), [
    (0.025, 326, r"elements of 25 mm .* has about 1\d\d nodes: allowed are \d+ to 1\d\d; 3"),
    (0.010, 2000, r"elements of 10 mm .* has about 3\d\d nodes: .*; 2000 suits mesh.size = 2."),
    (0.010, 50, r"elements of 10 mm .* has about 3\d\d nodes: .*; with other mesh.size \d\d "),
    (0.050, 50_000, r"elements of 50 mm .*; with other mesh.size \d\d to about 1\d{4}$"),
])  # fmt: skip
def test_numbers_out_of_reach_are_refused_with_the_sizes_that_suit(
    size: str | float, wanted: int, text: str
) -> None:
    with pytest.raises(InputError, match=rf"^mesh\.face_nodes = {wanted}: with {text}") as caught:
        casing_sector(size=size, face_nodes=wanted)
    assert "\n" not in str(caught.value)


def test_the_size_suggested_gives_the_number() -> None:
    with pytest.raises(InputError) as caught:
        casing_sector(size=0.025, face_nodes=326)
    size = 1e-3 * float(str(caught.value).rpartition("mesh.size = ")[2].removesuffix(" mm"))
    check_faces(casing_sector(size=size, face_nodes=326), 326)
