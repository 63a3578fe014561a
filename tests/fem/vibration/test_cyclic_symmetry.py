"""Cyclic symmetry against the assembled ring."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial import KDTree

from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.fem import Material, Modes, assemble, cyclic_transform, modes
from vanelock.mesh import FileMesh

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def wedge(lattice, sectors, counts=(1, 2, 1), fixed=None):
    """Sector of a ring of lopsided blades: no symmetry but the rotation."""

    def place(p):
        x, y, z = p.T
        angle = 2 * np.pi / sectors * y + 0.2 * z  # a helical cut, and so slanted faces
        r = 0.3 + 0.1 * x + 0.02 * np.sin(2 * np.pi * y) * (x + 0.5 * z)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.05 * z + 0.02 * x * x])

    part = lattice(counts, place, sectors=sectors)
    sets = {"left": part.node_sets["y0"], "right": part.node_sets["y1"]}
    if fixed is not None:
        sets["fixed"] = part.node_sets[fixed]
    return dataclasses.replace(part, node_sets=sets)


def ring(part):
    """All sectors merged, and the (sectors, nodes) numbers of each sector's nodes in it."""
    n = part.sectors
    points = np.concatenate([part.points @ turn(n, j).T for j in range(n)])
    tree = KDTree(points)
    mates = tree.query_ball_point(points, 1e-9)
    lowest = np.array([min(near) for near in mates])
    first, number = np.unique(lowest, return_inverse=True)
    number = number.reshape(n, -1)
    sets = {}
    if "fixed" in part.node_sets:
        sets["fixed"] = np.unique(number[:, part.node_sets["fixed"]])
    cells = np.concatenate([number[j][part.cells] for j in range(n)])
    whole = dataclasses.replace(part, points=points[first], cells=cells, node_sets=sets, sectors=1)
    return whole, number


def check_spectrum(part):
    """Frequencies of all nodal diameters together are those of the ring."""
    full = assemble(ring(part)[0], STEEL)
    exact = scipy.linalg.eigh(full.K.toarray(), full.M.toarray(), eigvals_only=True)
    model, found = assemble(part, STEEL), []
    for k in range(part.sectors):
        T = cyclic_transform(model, k)
        assert np.iscomplexobj(T.data) == (2 * k % part.sectors != 0)
        K, M = (T.conj().T @ A @ T for A in (model.K, model.M))
        found.append(scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True))
    together = np.sort(np.concatenate(found))
    assert len(together) == len(exact)  # all of them
    scale = exact[6]  # the first elastic one of the free ring
    np.testing.assert_allclose(together, exact, rtol=1e-9, atol=1e-9 * scale)


@pytest.mark.parametrize("fixed", [None, "x0"])
@pytest.mark.parametrize("sectors", [2, 5, 6])
def test_every_nodal_diameter_together_gives_the_frequencies_of_the_ring(lattice, sectors, fixed):
    check_spectrum(wedge(lattice, sectors, (1, 6 if sectors == 2 else 2, 1), fixed))


@pytest.mark.parametrize("nodal_diameter", [0, 1, 2, 3, 4, 5, -1])
def test_wave_spread_over_the_ring_is_a_mode_of_it(lattice, nodal_diameter):
    part = wedge(lattice, 6, counts=(2, 2, 2), fixed="x0")
    whole, number = ring(part)
    full = assemble(whole, STEEL)
    found = modes(assemble(part, STEEL), 4, nodal_diameter)
    assert found.nodal_diameter == nodal_diameter
    for f, shape in zip(found.frequency, found.shapes.transpose(2, 0, 1), strict=True):
        field = np.full((len(whole.points), 3), np.nan, complex)
        for j in range(6):
            here = shape @ turn(6, j).T * np.exp(-2j * np.pi * nodal_diameter * j / 6)
            known = ~np.isnan(field[number[j]])
            assert (
                abs(field[number[j]][known] - here[known]).max(initial=0) < 1e-9 * abs(here).max()
            )
            field[number[j]] = here
        free = full.dofs >= 0
        x = np.empty(full.K.shape[0], complex)
        x[full.dofs[free]] = field[free]
        force = full.M @ x * (2 * np.pi * f) ** 2
        np.testing.assert_allclose(full.K @ x, force, atol=1e-8 * abs(force).max())
        assert (x.conj() @ full.M @ x).real == pytest.approx(6, rel=1e-10)  # one a sector


def test_opposite_waves_are_conjugate(lattice):
    model = assemble(wedge(lattice, 5), STEEL)
    assert abs(cyclic_transform(model, 2) - cyclic_transform(model, 3).conj()).max() < 1e-15
    assert abs(cyclic_transform(model, 2) - cyclic_transform(model, 7)).max() == 0
    assert abs(cyclic_transform(model, -2) - cyclic_transform(model, 3)).max() == 0


def test_columns_are_the_dofs_that_do_not_belong_to_the_right_face(lattice):
    part = wedge(lattice, 5)
    model = assemble(part, STEEL)
    T = cyclic_transform(model, 1).toarray()
    right = np.unique(model.rows("right"))
    others = np.setdiff1d(np.arange(len(T)), right)
    np.testing.assert_array_equal(T[others], np.eye(len(others)))
    u_left = np.array([0.3, -0.2j, 1.1])
    y = np.zeros(len(others), complex)
    node = 3
    y[np.searchsorted(others, model.rows("left")[node])] = u_left
    expected = turn(5) @ u_left * np.exp(-2j * np.pi / 5)
    np.testing.assert_allclose((T @ y)[model.rows("right")[node]], expected, atol=1e-15)


def test_clamped_nodes_on_the_faces(lattice):
    part = wedge(lattice, 6, counts=(2, 2, 2))
    left, right = part.node_sets["left"], part.node_sets["right"]
    both = np.concatenate([left[:4], right[:4]])
    found = []
    for clamped in (both, left[:4], right[:4]):  # holding one of two mates holds the other
        sets = part.node_sets | {"fixed": clamped}
        found.append(modes(assemble(dataclasses.replace(part, node_sets=sets), STEEL), 3, 2))
        np.testing.assert_allclose(found[-1].frequency, found[0].frequency, rtol=1e-10)
        assert abs(found[-1].shapes[both]).max() == 0
    free = modes(assemble(part, STEEL), 3, 2).frequency
    assert free[0] < 0.9 * found[0].frequency[0]


@pytest.mark.parametrize("sectors", [2, 4])
def test_nodes_on_the_axis(lattice, sectors):
    # Quarters (or halves) of a square block meet on its axis.
    width = 1 if sectors == 4 else 2
    part = lattice((2, 2 * width, 1), lambda p: (p - [0, (width - 1) / 2, 0]) * [1, width, 0.4])
    p = part.points
    if sectors == 4:
        left = part.node_sets["y0"]  # (x, 0, z) is turned onto (0, x, z)
    else:
        left = np.flatnonzero((p[:, 0] == 0) & (p[:, 1] <= 0))
    image = p[left] @ turn(sectors).T
    right = KDTree(p).query(image)[1]
    part = dataclasses.replace(part, node_sets={"left": left, "right": right}, sectors=sectors)
    assert np.count_nonzero(left == right) == 3
    check_spectrum(part)


def test_modes_survive_their_file(lattice, tmp_path):
    found = modes(assemble(wedge(lattice, 6), STEEL), 3, 1)
    found.save(tmp_path / "modes.h5")
    again = Modes.load(tmp_path / "modes.h5")
    np.testing.assert_array_equal(again.frequency, found.frequency)
    np.testing.assert_array_equal(again.shapes, found.shapes)
    assert again.nodal_diameter == 1


def test_faces_that_do_not_match_are_refused(lattice):
    part = wedge(lattice, 6)
    model = assemble(part, STEEL)
    with pytest.raises(InputError, match="turned by 2π/7: the faces must match node by node"):
        cyclic_transform(model, 1, sectors=7)
    with pytest.raises(InputError, match="sectors = 1: cyclic symmetry needs at least 2"):
        cyclic_transform(model, 1, sectors=1)

    def without(**sets):
        return dataclasses.replace(model, part=dataclasses.replace(part, node_sets=sets))

    left, right = part.node_sets["left"], part.node_sets["right"]
    with pytest.raises(InputError, match="needs a node set 'right'"):
        cyclic_transform(without(left=left), 1)
    with pytest.raises(InputError, match=r"nodes in `left`, .* in `right`: they must match"):
        cyclic_transform(without(left=left, right=right[1:]), 1)
    with pytest.raises(InputError, match="right node .* lies"):
        cyclic_transform(without(left=left, right=right[::-1]), 1)


def test_a_mesh_from_a_file_is_one_sector_once_their_number_is_given(lattice):
    part = wedge(lattice, 5, fixed="x0")
    numbers = (np.arange(n) + 1 for n in (len(part.points), len(part.cells)))
    mesh = FileMesh(
        source="wedge.inp", points=part.points, numbers=next(numbers), cells=part.cells,
        elements=next(numbers), cell_type=part.cell_type, node_sets=part.node_sets, face_sets={},
        absent={},
    )  # fmt: skip
    model = assemble(mesh, STEEL)
    expected = modes(assemble(part, STEEL), 3, nodal_diameter=2).frequency
    found = modes(model, 3, nodal_diameter=2, sectors=5).frequency
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    with pytest.raises(InputError, match=r"wedge.inp: sectors = 1: cyclic symmetry needs at le"):
        modes(model, 3, nodal_diameter=2)
    whole = dataclasses.replace(mesh, node_sets={})
    with pytest.raises(InputError, match=r"wedge.inp: cyclic symmetry needs a node set 'left'"):
        modes(assemble(whole, STEEL), 3, nodal_diameter=2, sectors=5)
