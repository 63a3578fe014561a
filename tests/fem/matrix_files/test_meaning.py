"""What the numbers mean: units, held freedoms, generalised coordinates, Ansys's own file."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from ansys.mapdl.reader import examples, read_binary

from tests.fem.matrix_files.conftest import Model
from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import load_matrices, load_nodes, load_pairs


def test_ansys_full_file() -> None:
    """Frequencies in Hz that the library lists for this file of its examples."""
    found = load_matrices(Path(examples.fullfile))
    assert found.M is not None
    squared = scipy.linalg.eigh(
        found.K.toarray(), found.M.toarray(), eigvals_only=True, subset_by_index=[0, 19]
    )
    listed = [
        1283.20036921, 1283.20036921, 5781.97486169, 6919.39887714, 6919.39887714, 10172.61497694,
        16497.85701889, 16497.85701889, 17343.9939669, 27457.18472747, 27457.18472747,
        28908.52552073, 30326.16886062, 39175.76412419, 39175.76412419, 40503.70406456,
        49819.91597612, 51043.03965541, 51043.03965541, 52193.86143879,
    ]  # fmt: skip
    assert np.sqrt(squared) / (2 * np.pi) == pytest.approx(listed, rel=1e-7)
    # 963 freedoms, of which the clamped face's 63 are left out.
    full = read_binary(examples.fullfile)
    labels, k, _ = full.load_km(sort=True)
    whole = k + sp.triu(k, 1).T
    place = {tuple(label): row for row, label in enumerate(labels.tolist())}
    rows = [place[key] for key in zip(found.node.tolist(), found.direction.tolist(), strict=True)]
    assert len(rows) == 900
    assert np.array_equal(whole.toarray()[np.ix_(rows, rows)], found.K.toarray())


def test_all_six_directions_of_a_node_are_read_from_a_full_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stands for Ansys's library is what it gives."""
    label = np.column_stack([np.full(6, 4), np.arange(6)])
    matrices = {"K": sp.diags_array(np.arange(1.0, 7.0)), "M": None}
    monkeypatch.setattr(
        "vanelock.fem.matrix_files.ansys_full._contents",
        lambda source: (label, label[1:2], 0, matrices),
    )
    (tmp_path / "k.full").write_bytes(b"0")
    found = load_matrices(tmp_path / "k.full")
    assert found.node.tolist() == [4] * 5
    assert found.direction.tolist() == [0, 2, 3, 4, 5]
    assert found.K.diagonal().tolist() == [1, 3, 4, 5, 6]
    label[5, 1] = 6
    refused("displacements and rotations of nodes are read", load_matrices, tmp_path / "k.full")


def test_units_leave_frequencies_alone(model: Model, tmp_path: Path) -> None:
    """A bar in mm, t and N has in SI the frequencies that it has there."""
    np.savez(tmp_path / "km.npz", K=model.K, M=model.M, C=2 * model.M)
    nodes = model.write_nodes(tmp_path)
    found = load_matrices(tmp_path / "km.npz", nodes=nodes, length="mm", mass_unit="t", force="N")
    assert found.M is not None
    assert found.C is not None
    assert found.K.toarray() == pytest.approx(1e3 * model.K)  # N/mm
    assert found.M.toarray() == pytest.approx(1e3 * model.M)  # t
    assert found.C.toarray() == pytest.approx(2e3 * model.M)  # N s/mm
    assert found.position is not None
    assert found.position[2].tolist() == pytest.approx([1e-3, 2e-3, 0])
    assert found.position_node.tolist() == [11, 4, 7]


def test_units_of_rotations_and_of_modal_coordinates(tmp_path: Path) -> None:
    """A rotation's moment is in N mm; a coordinate of unit modal mass keeps ω² and 1."""
    np.savez(tmp_path / "km.npz", K=np.diag([7.0, 5.0, 400.0]), M=np.diag([3.0, 2.0, 1.0]))
    (tmp_path / "dofs.csv").write_text("node,direction\n1,x\n1,rz\n1,modal\n")
    found = load_matrices(
        tmp_path / "km.npz", dofs=tmp_path / "dofs.csv", length="mm", mass_unit="t"
    )
    assert found.M is not None
    assert found.K.diagonal() == pytest.approx([7e3, 5e-3, 400])
    assert found.M.diagonal() == pytest.approx([3e3, 2e-3, 1])
    assert found.node.tolist() == [1, 1, 0]
    assert found.direction.tolist() == [0, 5, 6]


def test_abaqus_boundary_conditions_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "k.mtx").write_text("1,1,1,1,1e36\n2,1,1,1,-3.0\n2,1,2,1,5.0\n3,1,3,1,2.0\n")
    (tmp_path / "m.mtx").write_text("1,1,1,1,8.0\n2,1,2,1,6.0\n")
    found = load_matrices(tmp_path / "k.mtx", tmp_path / "m.mtx")
    assert found.M is not None
    assert found.node.tolist() == [2, 3]
    assert found.K.toarray().tolist() == [[5, 0], [0, 2]]
    assert found.M.toarray().tolist() == [[6, 0], [0, 0]]  # node 3 has no mass


def test_nastran_superelement(tmp_path: Path) -> None:
    """A Craig-Bampton part of one free node: no stiffness there, modes as scalar points."""
    head = "DMIG    {0}    0       6       2\n"
    column = "DMIG*   {0}            {1:>16}{2:>16}\n*       {3:>16}{4:>16}{5:>16}\n"
    text = head.format("KAAX") + column.format("KAAX", 901, 0, 901, 0, "4.0D+02")
    text += head.format("MAAX") + column.format("MAAX", 5, 1, 5, 1, "3.+0")
    text += column.format("MAAX", 5, 1, 901, 0, "-5.0-1")
    text += column.format("MAAX", 901, 0, 901, 0, "1.0")
    (tmp_path / "part.pch").write_text(text)
    found = load_matrices(tmp_path / "part.pch")
    assert found.M is not None
    assert found.node.tolist() == [5, 0]
    assert found.direction.tolist() == [0, 6]
    assert found.K.toarray().tolist() == [[0, 0], [0, 400]]
    assert found.M.toarray().tolist() == [[3, -0.5], [-0.5, 1]]


def test_calculix_superelement_with_a_freedom_a_place(tmp_path: Path) -> None:
    """CalculiX lists a node once for each retained direction."""
    (tmp_path / "sub.mtx").write_text(
        "** GENERATION OF SUBSTRUCTURE\n*USER ELEMENT,NODES=         3,LINEAR\n"
        "** ELEMENT NODES\n**        12,        12,        31,\n         1\n"
        "         2,         3\n         3,         2\n*MATRIX,TYPE=STIFFNESS\n"
        " 4.0,\n 1.0, 5.0,\n 0.0, 2.0, 6.0,\n"
    )
    found = load_matrices(tmp_path / "sub.mtx")
    assert found.M is None
    assert found.node.tolist() == [12, 12, 31]
    assert found.direction.tolist() == [0, 2, 1]
    assert found.K.toarray().tolist() == [[4, 1, 0], [1, 5, 2], [0, 2, 6]]


def test_hermitian(tmp_path: Path) -> None:
    """A cyclic sector's matrix is complex; its lower triangle is the conjugate of the upper."""
    (tmp_path / "k.mtx").write_text(
        "%%MatrixMarket matrix coordinate complex hermitian\n2 2 3\n1 1 4 0\n2 1 1 2\n2 2 5 0\n"
    )
    (tmp_path / "dofs.csv").write_text("node,direction\n1,x\n1,y\n")
    found = load_matrices(tmp_path / "k.mtx", dofs=tmp_path / "dofs.csv")
    assert found.K.toarray().tolist() == [[4, 1 - 2j], [1 + 2j, 5]]


def test_complex_stiffness_of_structural_damping_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "k.npy", (1 + 0.02j) * np.diag([1.0, 2.0]))
    (tmp_path / "dofs.csv").write_text("node,direction\n1,x\n1,y\n")
    refused("not Hermitian", load_matrices, tmp_path / "k.npy", dofs=tmp_path / "dofs.csv")


def test_printed_to_few_digits(tmp_path: Path) -> None:
    """Round-off of the last printed digit is made symmetric; more is refused."""
    (tmp_path / "dofs.csv").write_text("node,direction\n1,x\n1,y\n")
    for off, fine in ((1e-9, True), (1e-7, False)):
        np.save(tmp_path / "k.npy", [[2.0, 1 + off], [1.0, 2.0]])
        if fine:
            found = load_matrices(tmp_path / "k.npy", dofs=tmp_path / "dofs.csv").K.toarray()
            assert found[0, 1] == found[1, 0] == pytest.approx(1 + off / 2, abs=1e-15)
        else:
            with pytest.raises(InputError, match=r"entries \(.*\) differ"):
                load_matrices(tmp_path / "k.npy", dofs=tmp_path / "dofs.csv")


def test_lists(tmp_path: Path) -> None:
    (tmp_path / "nodes.txt").write_text("contact nodes\n 12, 7;9 # the tip\n\n4\n")
    assert load_nodes(tmp_path / "nodes.txt").tolist() == [12, 7, 9, 4]
    (tmp_path / "pairs.csv").write_text(
        "# by hand\nown;mate;gap;side\n1;2;0.5;left\n3;4;-1;right\n"
    )
    pairs = load_pairs(tmp_path / "pairs.csv")
    assert pairs["own"].tolist() == [1, 3]
    assert pairs["own"].dtype == np.int64
    assert pairs["gap"].tolist() == [0.5, -1]
    assert pairs["side"].tolist() == ["left", "right"]
