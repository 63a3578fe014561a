"""Stiffness, mass and reference elements against scikit-fem, polynomials and mechanics."""

import dataclasses
import itertools
from math import factorial

import numpy as np
import pytest
import skfem
from scipy.spatial import KDTree
from skfem.helpers import dot
from skfem.io.meshio import INV_HEX_MAPPING
from skfem.models.elasticity import linear_elasticity

from tests.fem.conftest import STEEL, bent
from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble
from vanelock.fem import elements as module
from vanelock.fem.elements import _tetrahedron_rule, reference_element


def skfem_basis(part):
    """scikit-fem's basis, and (nodes, 3) its number of each of the part's dofs."""
    make = {
        "tetra": (skfem.MeshTet1, skfem.ElementTetP1, slice(None), 2),
        "tetra10": (skfem.MeshTet2, skfem.ElementTetP2, slice(None), 5),
        "hexahedron": (skfem.MeshHex1, skfem.ElementHex1, INV_HEX_MAPPING[:8], 3),
        "hexahedron27": (skfem.MeshHex2, skfem.ElementHex2, INV_HEX_MAPPING, 5),
    }
    mesh, element, order, degree = make[part.cell_type]
    points, weights = _tetrahedron_rule()
    basis = skfem.Basis(
        mesh(part.points.T, part.cells.T[order]),
        skfem.ElementVector(element()),
        intorder=degree,
        quadrature=(points.T, weights) if part.cell_type == "tetra10" else None,
    )
    near = KDTree(part.points)
    distance, node = near.query(basis.doflocs.T)
    assert distance.max() < 1e-12
    numbers = np.empty((len(part.points), 3), int)
    for component in range(3):
        mine = np.unique(basis.element_dofs[component::3])
        numbers[node[mine], component] = mine
    return basis, numbers


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron27"])
def test_entries_equal_those_of_scikit_fem(lattice, cell_type, curved):
    part = lattice((3, 2, 2), bent, cell_type, curved)
    model = assemble(part, STEEL)
    basis, numbers = skfem_basis(part)
    mass = skfem.BilinearForm(lambda u, v, w: STEEL.rho * dot(u, v))
    for mine, form in ((model.K, linear_elasticity(*STEEL.lame)), (model.M, mass)):
        theirs = form.assemble(basis).tocsc()[numbers.ravel()][:, numbers.ravel()]
        back = np.argsort(model.dofs.ravel())
        theirs = theirs[back][:, back]
        assert abs(mine - theirs).max() < 1e-12 * abs(theirs).max()
        assert abs(mine - mine.T).max() == 0


def test_clamped_nodes_lose_their_rows(lattice):
    part = lattice((3, 2, 2), bent)
    free = assemble(part, STEEL)
    sets = part.node_sets | {"fixed": part.node_sets["x0"]}
    clamped = assemble(dataclasses.replace(part, node_sets=sets), STEEL)
    keep = np.setdiff1d(np.arange(free.K.shape[0]), free.dofs[sets["fixed"]])
    assert abs(clamped.K - free.K[keep][:, keep]).max() == 0
    assert abs(clamped.M - free.M[keep][:, keep]).max() == 0
    assert np.all(clamped.dofs[sets["fixed"]] == -1)
    np.testing.assert_array_equal(np.sort(clamped.dofs[clamped.dofs >= 0]), np.arange(len(keep)))
    by_name = assemble(part, STEEL, fixed="x0")
    assert abs(clamped.K - by_name.K).max() == 0
    unclamped = assemble(clamped.part, STEEL, fixed=None)
    assert abs(unclamped.K - free.K).max() == 0
    x = np.arange(len(keep), dtype=float)
    field = clamped.field(x)
    np.testing.assert_array_equal(field[clamped.dofs >= 0], x[clamped.dofs[clamped.dofs >= 0]])
    assert np.all(field[sets["fixed"]] == 0)
    np.testing.assert_array_equal(clamped.rows("x1"), clamped.dofs[sets["x1"]])


def test_result_does_not_depend_on_the_blocks(lattice, monkeypatch):
    part = lattice((3, 3, 3), bent)
    whole = assemble(part, STEEL)
    monkeypatch.setattr(module, "_BLOCK", 7)
    parts = assemble(part, STEEL)
    assert abs(whole.K - parts.K).max() < 1e-15 * abs(whole.K).max()
    assert abs(whole.M - parts.M).max() < 1e-15 * abs(whole.M).max()


@pytest.mark.parametrize(("values", "message"), [
    ((-1.0, 0.3, 1.0), r"material.E = -1: Young's modulus must be > 0 Pa"),
    ((float("nan"), 0.3, 1.0), r"material.E = nan"),
    ((1.0, 0.5, 1.0), r"material.nu = 0.5: Poisson's ratio must be in \(-1, 0.5\)"),
    ((1.0, 0.3, 0.0), r"material.rho = 0: density must be > 0"),
])  # fmt: skip
def test_impossible_material_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        Material(*values)


def test_unusable_part_is_refused(lattice):
    part = lattice((2, 1, 1))
    with pytest.raises(InputError, match=r"tetra10: fixed = 'flange': no such node set; it has x0"):
        assemble(part, STEEL, fixed="flange")
    everything = {"fixed": np.arange(len(part.points))}
    with pytest.raises(InputError, match="clamps every node"):
        assemble(dataclasses.replace(part, node_sets=everything), STEEL)
    with pytest.raises(InputError, match="cells have 10 nodes, tetra needs 4"):
        assemble(dataclasses.replace(part, cell_type="tetra"), STEEL)
    cells = part.cells.copy()
    cells[5, [1, 2]] = cells[5, [2, 1]]
    with pytest.raises(InputError, match="element 5 is turned inside out"):
        assemble(dataclasses.replace(part, cells=cells), STEEL)
    with pytest.raises(InputError, match=r"no node set 'hub'; it has x0, x1, y0"):
        assemble(part, STEEL).rows("hub")


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
