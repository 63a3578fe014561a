"""The skin of hand-made parts against their geometry."""

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.render.scenes.surface import packed, surface


def volume(points, triangles):
    """Volume inside a closed skin whose triangles wind outwards (divergence theorem)."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.sum(a * np.cross(b, c)) / 6


def area(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def prism_volume(sectors, steps, inner, outer, length):
    """Volume of a sector whose arcs are `steps` straight chords."""
    step = 2 * np.pi / sectors / steps
    return steps * 0.5 * np.sin(step) * (outer**2 - inner**2) * length


@pytest.mark.parametrize("corners_only", [False, True])
@pytest.mark.parametrize("cell_type", ["tetra", "tetra10"])
def test_skin_of_a_sector_encloses_its_volume(sector, cell_type, corners_only):
    part = sector(sectors=8, divisions=(2, 4, 3))
    cells = part.cells[:, :4] if cell_type == "tetra" else part.cells
    part = Part("casing", part.points, cells, cell_type, part.node_sets, {}, 8)
    skin = surface(part, corners_only=corners_only)
    points = part.points[skin.nodes]
    expected = prism_volume(8, 4, 0.5, 0.6, 0.1)
    assert volume(points, skin.triangles) == pytest.approx(expected, rel=1e-12)


def test_cyclic_faces_have_their_area_and_the_outline_is_the_edges(sector):
    """Four straight edges along z, four along r, and four arcs of chords of 11.25 degrees."""
    part = sector(sectors=8)
    skin = surface(part)
    hidden = skin.triangles[skin.cyclic]
    assert area(part.points[skin.nodes], hidden) == pytest.approx(2 * 0.1 * 0.1, rel=1e-12)
    part = sector(sectors=8, divisions=(2, 4, 3))
    skin = surface(part)
    points = part.points[skin.nodes]
    length = np.linalg.norm(np.diff(points[skin.outline], axis=1), axis=2).sum()
    arcs = 2 * 4 * 2 * np.sin(np.pi / 8 / 4) * (0.5 + 0.6)
    assert length == pytest.approx(4 * 0.1 + 4 * 0.1 + arcs, rel=1e-12)


def hexahedron(cell_type):
    """One brick 1 x 2 x 3 of that type, its nodes where meshio puts them."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(x, y, 1) for x, y, _ in corners]
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
    pairs += [(0, 4), (1, 5), (2, 6), (3, 7)]
    c = np.array(corners, float)
    edges = np.array([(c[i] + c[j]) / 2 for i, j in pairs])
    faces = [(0, 0.5, 0.5), (1, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 1, 0.5), (0.5, 0.5, 0)]
    faces += [(0.5, 0.5, 1), (0.5, 0.5, 0.5)]
    count = {"hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27}[cell_type]
    points = np.vstack([c, edges, np.array(faces)])[:count] * np.array([1.0, 2.0, 3.0])
    return Part("brick", points, np.arange(count)[None], cell_type, {}, {}, 1)


@pytest.mark.parametrize(
    ("cell_type", "nodes"), [("hexahedron", 8), ("hexahedron20", 20), ("hexahedron27", 26)]
)
def test_bricks(cell_type, nodes):
    part = hexahedron(cell_type)
    skin = surface(part)
    points = part.points[skin.nodes]
    assert len(skin.nodes) == nodes
    assert volume(points, skin.triangles) == pytest.approx(6.0, rel=1e-12)
    assert area(points, skin.triangles) == pytest.approx(22.0, rel=1e-12)
    for edges, expected in ((skin.outline, 24.0), (skin.mesh_edges, 24.0)):
        length = np.linalg.norm(np.diff(points[edges], axis=1), axis=2).sum()
        assert length == pytest.approx(expected, rel=1e-12)


def test_other_elements_are_refused():
    part = Part("brick", np.eye(3), np.array([[0, 1, 2]]), "triangle", {}, {}, 1)
    with pytest.raises(InputError, match="brick: element type triangle: pictures know tetra"):
        surface(part)


@pytest.mark.parametrize(("columns", "count"), [(2, 50), (3, 2_000_000), (4, 200), (4, 1_000_000)])
def test_rows_are_told_apart_by_one_number(columns, count):
    random = np.random.default_rng(columns)
    rows = random.integers(0, min(count, 12), (3000, columns)) + count - min(count, 12)
    _, first, counts = np.unique(rows, axis=0, return_index=True, return_counts=True)
    found = np.unique(packed(rows, count), return_index=True, return_counts=True)
    np.testing.assert_array_equal(np.sort(found[1]), np.sort(first))
    np.testing.assert_array_equal(found[2][found[1].argsort()], counts[first.argsort()])
