"""Node order of the elements, against gmsh's meshes and against polynomials."""

import itertools
from math import factorial
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.fem.elements import _tetrahedron_rule, reference_element

DEGREE = {"tetra": 1, "tetra10": 2, "hexahedron": 1, "hexahedron20": 2, "hexahedron27": 2}


@pytest.mark.parametrize("cell_type", DEGREE)
def test_basis_reproduces_polynomials_from_their_values_at_the_nodes(cell_type):
    # This fixes which basis function belongs to which node.
    e = reference_element(cell_type)
    points = e.values @ e.nodes
    for powers in itertools.product(range(3), repeat=3):
        if sum(powers) > DEGREE[cell_type]:
            continue
        np.testing.assert_allclose(
            e.values @ np.prod(e.nodes**powers, axis=1), np.prod(points**powers, axis=1), atol=1e-14
        )
        for axis in range(3):
            lower = np.maximum(np.array(powers) - np.eye(3, dtype=int)[axis], 0)
            np.testing.assert_allclose(
                e.gradients[:, :, axis] @ np.prod(e.nodes**powers, axis=1),
                powers[axis] * np.prod(points**lower, axis=1),
                atol=1e-13,
            )
    assert e.weights.sum() == pytest.approx(1 / 6 if cell_type.startswith("tetra") else 1)


@pytest.mark.parametrize("cell_type", DEGREE)
def test_nodes_of_a_gmsh_mesh_lie_where_the_reference_cell_says(cell_type, tmp_path: Path):
    # gmsh and VTK number the mid-edge nodes of the higher-order elements differently; meshio, and
    # so a Part, uses VTK's order.
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 1.0, 0.7, 0.4)
        gmsh.model.occ.synchronize()
        if cell_type.startswith("hexa"):
            for curve in gmsh.model.getEntities(1):
                gmsh.model.mesh.setTransfiniteCurve(curve[1], 3)
            gmsh.model.mesh.setTransfiniteAutomatic()
        else:
            gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", cell_type == "hexahedron20")
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(DEGREE[cell_type])
        gmsh.write(str(tmp_path / "box.msh"))
    finally:
        gmsh.finalize()
    mesh = meshio.read(tmp_path / "box.msh")
    points = mesh.points[mesh.cells_dict[cell_type]]
    assert len(points) >= 8
    e = reference_element(cell_type)
    origin = points[:, 0]
    axes = points[:, [1, 2, 3] if cell_type.startswith("tetra") else [1, 3, 4]] - origin[:, None]
    expected = origin[:, None] + e.nodes @ axes
    np.testing.assert_allclose(points, expected, atol=1e-12)


def test_unknown_cell_type_is_refused():
    with pytest.raises(InputError, match=r"cell_type = 'wedge': the solid elements are tetra"):
        reference_element("wedge")


def test_moments_of_the_tetrahedron_s_rule_are_exact_to_degree_five_and_no_further():
    """Of x^a y^b z^c, a! b! c! / (a + b + c + 3)!."""
    points, weights = _tetrahedron_rule()
    assert len(weights) == 14
    assert weights.min() > 0
    assert np.column_stack([1 - points.sum(axis=1), points]).min() > 0
    for powers in itertools.product(range(6), repeat=3):
        exact = np.prod([factorial(n) for n in powers]) / factorial(sum(powers) + 3)
        if sum(powers) <= 5:
            assert weights @ np.prod(points**powers, axis=1) == pytest.approx(exact, abs=1e-16)
    assert abs(weights @ points[:, 0] ** 6 - factorial(6) / factorial(9)) > 1e-6
