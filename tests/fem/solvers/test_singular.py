"""Free motions in words: rigid-body motions against mechanisms, whose number is known."""

import dataclasses
import re

import numpy as np
import pytest
import scipy.sparse as sp

from tests.fem.conftest import STEEL
from vanelock.common.errors import InputError
from vanelock.fem import (
    SingularError,
    assemble,
    backends,
    cyclic_transform,
    factorise,
    free_motion,
)

every_backend = pytest.mark.parametrize("backend", backends())


def words(model, rows=None, backend=None):
    """What is said of the model's stiffness over some rows, or transformed by a matrix."""
    K = model.K
    if sp.issparse(rows):
        K = rows.conj().T @ K @ rows
    elif rows is not None:
        K = K[rows][:, rows]
    with pytest.raises(SingularError) as caught:
        factorise(K, backend)
    with pytest.raises(InputError, match="rows: 1 of them; the matrix has"):
        free_motion(model, caught.value, np.arange(1))
    return free_motion(model, caught.value, rows)


def without(part, keep):
    """The cells of a part that are kept, and their nodes."""
    cells = part.cells[keep]
    used = np.unique(cells)
    number = np.full(len(part.points), -1)
    number[used] = np.arange(len(used))
    sets = {k: number[np.intersect1d(v, used)] for k, v in part.node_sets.items()}
    return dataclasses.replace(part, points=part.points[used], cells=number[cells], node_sets=sets)


@every_backend
def test_free_part_has_six_rigid_motions(lattice, backend):
    model = assemble(lattice((3, 2, 2), lambda p: p * [0.3, 0.2, 0.1] + 5), STEEL)
    assert words(model, backend=backend) == (
        "tetra10: free to move as a rigid body: 6 motions not held; "
        "hold a set of nodes or give a negative shift"
    )


@every_backend
def test_hinge_leaves_one_rigid_motion(lattice, backend):
    # Held along the edge x = y = 0: it turns about the axis z, and the far edge moves most.
    part = lattice((3, 2, 2), lambda p: p * [0.3, 0.1, 0.1])
    part.node_sets["edge"] = np.intersect1d(part.node_sets["x0"], part.node_sets["y0"])
    clamped = words(assemble(part, STEEL, fixed="edge"), backend=backend)
    model = assemble(part, STEEL)
    held = model.rows("edge").ravel()
    rows = np.setdiff1d(np.arange(model.K.shape[0]), held)
    for said in (clamped, words(model, rows, backend)):
        assert "free to move as a rigid body: 1 motion not held, node " in said
        assert re.search(r"\(x = 0.3, y = 0.1, z = [\d.]+\) in x, y the most; hold a set", said)
        assert "without stiffness" not in said


@every_backend
def test_two_bodies_that_hang_at_an_edge_are_a_mechanism(lattice, backend):
    # Of 2 x 2 boxes in the plane two opposite ones: they share the edge x = y = 0.5.
    part = lattice((2, 2, 1))
    centre = part.points[part.cells].mean(axis=1)
    part = without(part, (centre[:, 0] < 0.5) == (centre[:, 1] < 0.5))
    said = words(assemble(part, STEEL, fixed="x0"), backend=backend)
    swinging = np.sum((part.points[:, :2] > 0.5).any(axis=1) & (part.points[:, 0] >= 0.5))
    named = re.search(
        r"^tetra10: 1 motion of some nodes without stiffness: node \d+ \(x = 1, y = 1, z = \S+\) "
        r"in x, y, node .* and (\d+) other nodes; join or hold these nodes$",
        said,
    )
    assert named is not None
    assert int(named.group(1)) == swinging - 3
    free = words(assemble(part, STEEL), backend=backend)
    assert "rigid body: 6 motions not held; 1 motion of some nodes without stiffness" in free


def softened(model, gone):
    """The model without any stiffness in some dofs."""
    K = model.K.tolil()
    K[gone, :] = 0
    K[:, gone] = 0
    return dataclasses.replace(model, K=K.tocsc())


@every_backend
def test_node_without_stiffness_is_named(lattice, backend):
    part = lattice((2, 1, 1), lambda p: p * [0.3, 0.1, 0.1])
    model = assemble(part, STEEL, fixed="x0")
    node = int(part.node_sets["x1"][4])
    said = words(softened(model, model.dofs[node][[0, 2]]), backend=backend)
    x, y, z = part.points[node]
    assert said == (
        f"tetra10: 2 motions of some nodes without stiffness: node {node} (x = {x:g}, y = {y:g}, "
        f"z = {z:g}) in x, z; join or hold these nodes"
    )


@pytest.mark.parametrize(("count", "others"), [(4, "1 other node"), (5, "2 other nodes")])
def test_nodes_beyond_the_third_are_counted(lattice, count, others):
    part = lattice((2, 1, 1), lambda p: p * [0.3, 0.1, 0.1])
    model = assemble(part, STEEL, fixed="x0")
    said = words(softened(model, model.dofs[part.node_sets["x1"][:count], 0]))
    assert f"{count} motions of some nodes without stiffness" in said
    assert said.count(" in x") == 3
    assert said.endswith(f" and {others}; join or hold these nodes")


@every_backend
@pytest.mark.parametrize(("diameter", "free"), [(0, 2), (1, 2), (2, 0)])
def test_ring_is_free_in_waves_of_diameter_zero_and_one(lattice, backend, diameter, free):
    # A ring moves along its axis and turns about it in the wave of diameter 0; in that of
    # diameter 1 it moves across and tilts.
    def bend(p):
        angle = p[:, 1] * 2 * np.pi / 9
        radius = 1 + 0.3 * p[:, 0]
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * p[:, 2]])

    part = lattice((2, 2, 2), bend, sectors=9)
    part.node_sets.update(left=part.node_sets["y0"], right=part.node_sets["y1"])
    model = assemble(part, STEEL)
    T = cyclic_transform(model, diameter)
    if free:
        assert f"rigid body: {free} motions not held, node" in words(model, T, backend)
    else:
        K = T.conj().T @ model.K @ T
        assert factorise(K, backend).size == K.shape[0]
