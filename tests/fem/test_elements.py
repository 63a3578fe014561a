"""Stiffness, mass and loads of elements against scikit-fem, polynomials and mechanics."""

import dataclasses
import itertools
from dataclasses import replace
from math import factorial

import numpy as np
import pytest
import skfem
from scipy.spatial import KDTree
from skfem.helpers import dot
from skfem.io.meshio import INV_HEX_MAPPING
from skfem.models.elasticity import linear_elasticity

from tests.fem.conftest import CELLS, STEEL, bent
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.fem import Material, assemble, centrifugal, pressure, stress, thermal, traction
from vanelock.fem import elements as module
from vanelock.fem.elements import _tetrahedron_rule, reference_element
from vanelock.fem.loads import centroid, faces_of


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
    refused(message, Material, *values)


def test_unusable_part_is_refused(lattice):
    part = lattice((2, 1, 1))
    with pytest.raises(InputError, match=r"tetra10: fixed = 'flange': no such node set; it has x0"):
        assemble(part, STEEL, fixed="flange")
    everything = {"fixed": np.arange(len(part.points))}
    refused("clamps every node", assemble, dataclasses.replace(part, node_sets=everything), STEEL)
    with pytest.raises(InputError, match="cells have 10 nodes, tetra needs 4"):
        assemble(dataclasses.replace(part, cell_type="tetra"), STEEL)
    cells = part.cells.copy()
    cells[5, [1, 2]] = cells[5, [2, 1]]
    with pytest.raises(InputError, match="element 5 is turned inside out"):
        assemble(dataclasses.replace(part, cells=cells), STEEL)
    refused(r"no node set 'hub'; it has x0, x1, y0", assemble(part, STEEL).rows, "hub")


def test_unknown_cell_type_is_refused():
    refused(r"cell_type = 'wedge': the solid elements are tetra", reference_element, "wedge")


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


def block(lattice, cell_type, counts=(2, 3, 2)):
    part = lattice(counts, bent, cell_type, curved=True)
    return replace(part, node_sets={**part.node_sets, "all": np.arange(len(part.points))})


@pytest.mark.parametrize("cell_type", CELLS)
def test_pressure_all_round_squeezes_evenly_and_a_gradient_lifts(lattice, cell_type):
    # u = -p/(3λ + 2μ) x is the exact answer, which every element holds; the stiffness of elements
    # with curved sides is not integrated exactly.
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    (lame, shear), x = STEEL.lame, model.part.points
    f = pressure(model, "all", 1e6)
    bound = {"tetra10": 1e-4, "hexahedron20": 1e-6, "hexahedron27": 1e-6}.get(cell_type, 1e-12)
    squeezed = model.K @ (-1e6 / (3 * lame + 2 * shear) * x).ravel()
    np.testing.assert_allclose(squeezed, f, atol=bound * np.abs(f).max())
    moment = np.cross(x, f.reshape(-1, 3))
    assert np.linalg.norm(moment.sum(axis=0)) < 1e-13 * np.abs(moment).sum()
    lift = pressure(model, "all", 1e6 + 5e4 * x[:, 2]).reshape(-1, 3).sum(axis=0)
    volume = model.M.sum() / 3 / STEEL.rho  # Gauss: -∮ p n dA = -∫ ∇p dV
    accuracy = 1e-12 if cell_type in ("tetra", "tetra10") else 1e-3  # of the mass's own rule
    np.testing.assert_allclose(lift, [0, 0, -5e4 * volume], atol=accuracy * 5e4 * volume)


@pytest.mark.parametrize("cell_type", CELLS)
def test_a_free_body_grows_without_stress(lattice, cell_type):
    model = assemble(block(lattice, cell_type), STEEL, fixed=None)
    grown = 2e-3 * model.part.points
    f = thermal(model, 2e-3)
    np.testing.assert_allclose(model.K @ grown.ravel(), f, atol=1e-13 * np.abs(f).max())
    free = stress(model, grown, 2e-3)
    assert np.abs(free).max() < 1e-12 * STEEL.E * 2e-3
    held = stress(model, 0 * grown, np.full(len(grown), 2e-3))
    lame, shear = STEEL.lame
    np.testing.assert_allclose(held[:, :3], -(3 * lame + 2 * shear) * 2e-3, rtol=1e-12)


def test_what_acts_on_clamped_nodes_is_left_out(lattice):
    part = block(lattice, "tetra10")
    free = assemble(part, STEEL, fixed=None)
    held = assemble(part, STEEL, fixed="x0")
    rows = held.dofs >= 0
    for load in (
        lambda model: pressure(model, "all", 1e6),
        lambda model: thermal(model, 1e-3),
        lambda model: centrifugal(model, 100.0),
    ):
        assert np.array_equal(load(free).reshape(-1, 3)[rows], load(held)[held.dofs[rows]])


def test_what_does_not_belong_to_a_part_is_refused(lattice):
    model = assemble(block(lattice, "tetra10"), STEEL, fixed=None)
    n = len(model.part.points)
    for call, words in (
        (lambda: pressure(model, "back", 1.0), "no node set 'back'; it has all, x0, x1"),
        (lambda: pressure(model, "x0", np.ones(3)), f"pressure of shape .3,.: needed is .* .{n},."),
        (lambda: pressure(model, "x0", np.nan), "pressure must be finite"),
        (lambda: thermal(model, np.ones((n, 3))), "thermal strain of shape"),
        (lambda: thermal(model, np.inf), "thermal strain must be finite"),
        (lambda: centrifugal(model, np.nan), "speed = nan rad/s: must be finite"),
    ):
        refused(words, call)
    edge = replace(model.part, node_sets={"edge": np.arange(2)})
    with pytest.raises(InputError, match="no face of the surface has all its nodes in 'edge'"):
        pressure(replace(model, part=edge), "edge", 1.0)


FORCE, MOMENT = np.array([3.0, -20.0, 7.0]), np.array([0.1, 0.4, -0.2])


@pytest.mark.parametrize("cell_type", ["tetra", "tetra10", "hexahedron", "hexahedron27"])
def test_force_and_moment_are_those_given(lattice, cell_type):
    model = assemble(lattice((2, 3, 2), bent, cell_type, curved=True), STEEL, fixed=None)
    faces = faces_of(model.part, "x1")
    middle = centroid(model, faces)
    f = traction(model, faces, FORCE, MOMENT).reshape(-1, 3)
    arm = model.part.points - middle
    np.testing.assert_allclose(f.sum(axis=0), FORCE, rtol=1e-12)
    np.testing.assert_allclose(np.cross(arm, f).sum(axis=0), MOMENT, rtol=1e-11)
    away = np.setdiff1d(np.arange(len(f)), faces)
    assert not f[away].any()


def test_across_a_flat_face_a_force_is_an_even_pressure_and_a_moment_a_linear_one(lattice):
    part = lattice((2, 3, 2), lambda p: p * [0.4, 0.3, 0.2], "tetra10")
    model = assemble(part, STEEL, fixed=None)
    faces, x = faces_of(model.part, "x1"), model.part.points
    area, inertia = 0.3 * 0.2, 0.2 * 0.3**3 / 12
    even = traction(model, faces, [-5.0, 0.0, 0.0])
    np.testing.assert_allclose(even, pressure(model, "x1", 5.0 / area), atol=1e-13)
    bending = traction(model, faces, [0.0, 0.0, 0.0], [0.0, 0.0, 2.0])
    linear = pressure(model, "x1", 2.0 / inertia * (x[:, 1] - 0.15))
    np.testing.assert_allclose(bending, linear, atol=1e-12)


def test_wrong_resultants_and_no_faces_are_refused(lattice):
    model = assemble(lattice((1, 1, 1), bent, "tetra"), STEEL, fixed=None)
    side, none = faces_of(model.part, "x1"), np.empty((0, 3), int)
    for faces, force, message in (
        (side, [np.inf, 0, 0], "three finite numbers each"),
        (side, [1.0, 0.0], "three finite numbers each"),
        (none, FORCE, "traction: no faces are given"),
    ):
        refused(message, traction, model, faces, force, [0, 0, 0])
