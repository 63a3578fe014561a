"""The skin that the view draws: its nodes, its shading, what it weighs."""

import numpy as np

from vanelock import report
from vanelock.report import views


def volume_inside(body):
    """By Gauss: the place's flow out of a closed skin is three times what it holds."""
    a, b, c = body.points[body.triangles].transpose(1, 0, 2)
    return np.sum(np.cross(b - a, c - a) * (a + b + c)) / 18


def test_body_of_a_part_lies_on_its_skin(coarse):
    for part in coarse:
        body, nodes = report.body_of(part)
        assert np.array_equal(body.points, part.points[nodes])
        assert body.sectors == part.sectors
        assert body.name == part.name
        whole = part.points[part.cells[:, :4]]
        edges = whole[:, 1:] - whole[:, :1]
        assert np.isclose(volume_inside(body), np.linalg.det(edges).sum() / 6, rtol=1e-9)


def test_large_skin_is_thinned_over_its_own_nodes(lattice):
    def plate(place):
        return np.array([0.2, 0.1, 0.004]) * place

    part = lattice((48, 32, 2), plate, "hexahedron")
    whole, every = report.body_of(part)
    body, nodes = report.body_of(part, most=2000)
    assert len(whole.triangles) > 6000
    assert 700 < len(body.triangles) <= 2000
    assert set(nodes) < set(every)
    assert np.array_equal(body.points, part.points[nodes])
    # The plate is thinner than a cell of the grid and keeps its two sides and all its corners.
    assert np.array_equal(body.points.min(axis=0), whole.points.min(axis=0))
    assert np.array_equal(body.points.max(axis=0), whole.points.max(axis=0))
    assert np.isclose(volume_inside(body), 0.2 * 0.1 * 0.004, rtol=0.02)
    assert np.isclose(volume_inside(whole), 0.2 * 0.1 * 0.004, rtol=1e-9)
    assert len(body.outline) > 40


def test_cube_is_crisp_and_its_faces_are_flat():
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), -1).reshape(-1, 3)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    split, numbered, normals = views.shaded(corners.astype(float), triangles)
    assert len(split) == 24  # each corner once for each of its three faces
    assert np.array_equal(split[numbered], triangles)
    outward = corners[split[numbered]].mean(axis=1) - 0.5
    assert np.all(np.einsum("tci,ti->tc", normals[numbered], outward) > 0)
    assert np.array_equal(np.sort(np.abs(normals), axis=1), np.tile([0.0, 0.0, 1.0], (24, 1)))


def test_cylinder_is_smooth_around_and_crisp_at_its_rim():
    count = 24
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.vstack([np.c_[rim, np.zeros(count)], np.c_[rim, np.ones(count)], [[0, 0, 1]]])
    i = np.arange(count)
    j = (i + 1) % count
    side = np.vstack([np.c_[i, j, count + j], np.c_[i, count + j, count + i]])
    lid = np.c_[count + i, count + j, np.full(count, 2 * count)]
    split, _, normals = views.shaded(points, np.vstack([side, lid]))
    assert len(split) == 3 * count + 1
    upright = np.abs(normals[:, 2]) > 0.5
    assert upright.sum() == count + 1
    exact = np.c_[points[split[~upright], :2], np.zeros((~upright).sum())]
    # The triangles about a point are not mirrored, so its mean normal leans by some degrees.
    assert np.all(np.sum(normals[~upright] * exact, axis=1) > np.cos(np.radians(360 / count / 2)))


def test_view_is_compact(coarse):
    skins = [report.body_of(part) for part in coarse]
    shapes = tuple(
        part.points[nodes] * (1 + 2j) for part, (_, nodes) in zip(coarse, skins, strict=True)
    )
    motions = tuple(report.Motion(f"mode {k}", 1, shapes, 250.0) for k in range(4))
    scene = views.scene(report.View([body for body, _ in skins], motions, "Motion"))

    def weight(value):
        if isinstance(value, str):
            return len(value)
        children = value.values() if isinstance(value, dict) else value
        return sum(map(weight, children)) if isinstance(value, dict | list) else 20

    points = sum(len(body.points) for body, _ in skins)
    assert weight(scene) < 220 * points  # four motions; a ring of its own sectors would be 16 times
