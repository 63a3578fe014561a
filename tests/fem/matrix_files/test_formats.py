"""The same small model, written in every format by others, gives the same matrices exactly."""

import gzip
import io
import re
from codecs import BOM_UTF8
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from tests.fem.matrix_files.conftest import DATA, NODES, Model
from vanelock.fem import matrix_files
from vanelock.fem.matrix_files import Matrices, load_matrices


def check(found: Matrices, model: Model) -> None:
    """Labels in any order; entries exactly."""
    order = np.lexsort((found.direction, found.node))
    wanted = np.lexsort((model.direction, model.node))
    assert found.node[order].tolist() == model.node[wanted].tolist()
    assert found.direction[order].tolist() == model.direction[wanted].tolist()
    assert found.M is not None
    for ours, theirs in ((found.K, model.K), (found.M, model.M)):
        assert ours.format == "csc"
        assert np.array_equal(ours.toarray()[np.ix_(order, order)], theirs[np.ix_(wanted, wanted)])


def market(symmetry: str, dense: bool, packed: bool) -> Callable[[Path, Model], Matrices]:
    def load(folder: Path, model: Model) -> Matrices:
        paths = []
        for name, matrix in (("k", model.K), ("m", model.M)):
            held = io.BytesIO()
            shown = matrix if dense else sp.coo_array(matrix)
            scipy.io.mmwrite(held, shown, symmetry=symmetry, comment="a comment")
            path = folder / f"{name}.mtx{'.gz' if packed else ''}"
            path.write_bytes(gzip.compress(held.getvalue()) if packed else held.getvalue())
            paths.append(path)
        return load_matrices(*paths, dofs=model.write_mapping(folder))

    return load


def harwell(folder: Path, model: Model) -> Matrices:
    for name, matrix in (("k.hb", model.K), ("m.rb", model.M)):
        scipy.io.hb_write(folder / name, sp.csc_matrix(matrix))
    return load_matrices(folder / "k.hb", folder / "m.rb", dofs=model.write_dofs(folder))


def hbmat(folder: Path, model: Model) -> Matrices:
    """As HBMAT writes it: RSA, one number a line, the right-hand side after the matrix."""
    for name, matrix in (("k.matrix", model.K), ("m.matrix", model.M)):
        lower = sp.csc_array(np.tril(matrix))
        n, count = len(matrix), lower.nnz
        lines = [
            f"{'Stiffness Matrix from ANSYS FULL file':72s}{'':8s}",
            f"{3 * n + 1 + 2 * count:14d}{n + 1:14d}{count:14d}{count:14d}{n:14d}",
            f"RSA{'':11s}{n:14d}{n:14d}{count:14d}{0:14d}",
            f"{'(1I10)':16s}{'(1I10)':16s}{'(1D25.15)':20s}{'(1D25.15)':20s}",
            f"F{'':13s}{1:14d}{0:14d}",
            *(f"{k + 1:10d}" for k in lower.indptr),
            *(f"{k + 1:10d}" for k in lower.indices),
            *(f"{value:25.15E}".replace("E", "D") for value in lower.data),
            *(f"{0.0:25.15E}".replace("E", "D") for _ in range(n)),
        ]
        (folder / name).write_text("\n".join(lines) + "\n")
    return load_matrices(folder / "k.matrix", folder / "m.matrix", dofs=model.write_mapping(folder))


def touching(folder: Path, model: Model) -> Matrices:
    """Fixed columns without a space between numbers."""
    for name, matrix in (("k.hb", model.K), ("m.hb", model.M)):
        full = sp.csc_array(matrix)
        n, count = len(matrix), full.nnz

        def block(numbers: list[str], a_line: int) -> list[str]:
            return ["".join(numbers[k : k + a_line]) for k in range(0, len(numbers), a_line)]

        pointer = block([f"{k + 1:3d}" for k in full.indptr], 5)
        row = block([f"{k + 1:2d}" for k in full.indices], 7)
        values = block([f"{value:14.7E}" for value in full.data], 4)
        head = [
            "title",
            f"{0:14d}{len(pointer):14d}{len(row):14d}{len(values):14d}{0:14d}",
            f"RUA{'':11s}{n:14d}{n:14d}{count:14d}{0:14d}",
            f"{'(5I3)':16s}{'(7I2)':16s}{'(1P,4E14.7)':20s}",
        ]
        (folder / name).write_text("\n".join([*head, *pointer, *row, *values]) + "\n")
    return load_matrices(folder / "k.hb", folder / "m.hb", dofs=model.write_dofs(folder))


def abaqus(form: str) -> Callable[[Path, Model], Matrices]:
    def load(folder: Path, model: Model) -> Matrices:
        # Abaqus sorts by node; so do rows of the coordinate format.
        order = np.lexsort((model.direction, model.node))
        node, direction = model.node[order], model.direction[order]
        for name, matrix in (("k.mtx", model.K), ("m.mtx", model.M)):
            matrix = matrix[np.ix_(order, order)]
            lines = ["** Abaqus"] if form == "input" else []
            for i, j in zip(*np.nonzero(matrix), strict=True):
                if form == "input" and j <= i:
                    lines.append(
                        f"{node[i]},{direction[i] + 1}, {node[j]},{direction[j] + 1}, "
                        f"{matrix[i, j]:.14e}"
                    )
                elif form == "coordinate":
                    lines.append(f"{i + 1:8d} {j + 1:8d}  {matrix[i, j]:.14e}")
            (folder / name).write_text("\n".join(lines) + "\n")
        dofs = folder / "dofs.csv"
        rows = [f"{n},{d + 1}" for n, d in zip(node, direction, strict=True)]
        dofs.write_text("\n".join(["node,dof", *rows]) + "\n")
        return load_matrices(folder / "k.mtx", folder / "m.mtx", dofs=dofs)

    return load


def superelement(folder: Path, model: Model) -> Matrices:
    """One file with both matrices, four numbers a line, as *SUBSTRUCTURE MATRIX OUTPUT has it."""
    lines = [
        "** GENERATION OF SUBSTRUCTURE",
        "*USER ELEMENT,NODES=          3,LINEAR",
        "** ELEMENT NODES",
        "**" + ",".join(f"{node:10d}" for node in NODES) + ",",
        "         1,         2,         3",
    ]
    for kind, matrix in (("STIFFNESS", model.K), ("MASS", model.M)):
        lines.append(f"*MATRIX,TYPE={kind}")
        for i, row in enumerate(matrix):
            numbers = [f"{value:20.13e}" for value in row[: i + 1]]
            lines += [",".join(numbers[k : k + 4]) + "," for k in range(0, len(numbers), 4)]
    (folder / "sub.mtx").write_text("\n".join(lines) + "\n")
    return load_matrices(folder / "sub.mtx")


def pynastran(name: str) -> Callable[[Path, Model], Matrices]:
    def load(folder: Path, model: Model) -> Matrices:
        return load_matrices(DATA / name)

    return load


def free_fields(folder: Path, model: Model) -> Matrices:
    """One triangle in comma-separated fields, two entries a column's first continuation.

    Beside the loads, a rectangular matrix, which nobody asks for.
    """
    lines = ["SOL 103", "CEND", "BEGIN BULK", "DMIG,PAX,0,9,2,0,,,1", "DMIG,PAX,1,0,,11,1,10."]
    for name, matrix in (("KAAX", model.K), ("MAAX", model.M)):
        lines.append(f"DMIG,{name},0,6,2,0")
        for j in range(9):
            entries = [
                f"{model.node[i]},{model.direction[i] + 1},{matrix[i, j]},"
                for i in range(j, 9)
                if matrix[i, j]
            ]
            lines.append(f"DMIG,{name},{model.node[j]},{model.direction[j] + 1},,{entries[0]}")
            lines += ["," + ",".join(entries[k : k + 2]) for k in range(1, len(entries), 2)]
    (folder / "deck.bdf").write_text("\n".join([*lines, "ENDDATA"]) + "\n")
    return load_matrices(folder / "deck.bdf")


def npy(folder: Path, model: Model) -> Matrices:
    np.save(folder / "k.npy", model.K)
    np.save(folder / "m.npy", model.M)
    nodes = model.write_nodes(folder)
    return load_matrices(folder / "k.npy", folder / "m.npy", nodes=nodes)


def npz(folder: Path, model: Model) -> Matrices:
    np.savez_compressed(folder / "both.npz", K=model.K, M=model.M)
    return load_matrices(folder / "both.npz", dofs=model.write_dofs(folder))


def sparse_npz(form: str) -> Callable[[Path, Model], Matrices]:
    def load(folder: Path, model: Model) -> Matrices:
        for name, matrix in (("k.npz", model.K), ("m.npz", model.M)):
            sp.save_npz(folder / name, sp.coo_array(matrix).asformat(form))
        paths = folder / "k.npz", folder / "m.npz"
        return load_matrices(*paths, dofs=model.write_dofs(folder))

    return load


def mat(sparse: bool) -> Callable[[Path, Model], Matrices]:
    def load(folder: Path, model: Model) -> Matrices:
        make = sp.csc_array if sparse else np.asarray
        held = {"Kr": make(model.K), "Mr": make(model.M), "name": "a model"}
        scipy.io.savemat(folder / "both.mat", held, do_compression=sparse)
        return load_matrices(folder / "both.mat", dofs=model.write_dofs(folder))

    return load


def mat73(folder: Path, model: Model) -> Matrices:
    """As MATLAB's version 7.3 lays them out: full transposed, sparse in a group."""
    with h5py.File(folder / "both.mat", "w", userblock_size=512) as file:
        file["K"] = model.K.T
        file["K"].attrs["MATLAB_class"] = np.bytes_("double")
        columns = sp.csc_array(model.M)
        group = file.create_group("M")
        group.attrs["MATLAB_class"] = np.bytes_("double")
        group.attrs["MATLAB_sparse"] = np.uint64(9)
        for name, part in (
            ("data", columns.data), ("ir", columns.indices), ("jc", columns.indptr)
        ):  # fmt: skip
            group[name] = part if name == "data" else part.astype(np.uint64)
    with open(folder / "both.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return load_matrices(folder / "both.mat", dofs=model.write_dofs(folder))


def hdf5(folder: Path, model: Model) -> Matrices:
    with h5py.File(folder / "both.h5", "w") as file:
        file["part/stiff"] = model.K
        file["part/heavy"] = model.M
    inside = Path(f"{folder / 'both.h5'}:/part/stiff")
    return load_matrices(inside, dofs=model.write_dofs(folder), names={"mass": "part/heavy"})


WRITERS = {
    "Matrix Market, general": market("general", False, False),
    "Matrix Market, symmetric": market("symmetric", False, False),
    "Matrix Market, packed": market("symmetric", False, True),
    "Matrix Market, array": market("general", True, False),
    "Matrix Market, symmetric array": market("symmetric", True, False),
    "Harwell-Boeing, SciPy": harwell, "Harwell-Boeing, HBMAT": hbmat,
    "Harwell-Boeing, numbers that touch": touching, "Abaqus, matrix input": abaqus("input"),
    "Abaqus, coordinate": abaqus("coordinate"), "Abaqus, superelement": superelement,
    "DMIG, pyNastran, small": pynastran("pynastran_small.bdf"),
    "DMIG, pyNastran, large": pynastran("pynastran_large.pch"), "DMIG, free fields": free_fields,
    "NumPy": npy, "NumPy, several": npz, "SciPy, csc": sparse_npz("csc"),
    "SciPy, csr": sparse_npz("csr"), "SciPy, coo": sparse_npz("coo"),
    "SciPy, bsr": sparse_npz("bsr"), "SciPy, dia": sparse_npz("dia"), "MATLAB 5": mat(False),
    "MATLAB 5, sparse": mat(True), "MATLAB 7.3": mat73, "HDF5": hdf5,
}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_same_model(name: str, model: Model, tmp_path: Path) -> None:
    check(WRITERS[name](tmp_path, model), model)


@pytest.mark.parametrize("name", [name for name in WRITERS if name[:4] in ("Matr", "Abaq", "DMIG")])
def test_exponents_called_d_behind_a_byte_order_mark(
    name: str, model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def respelt(*paths: Path, **options: Path) -> Matrices:
        new = [tmp_path / path.name for path in paths]
        for path, place in zip(paths, new, strict=True):
            unpacked = gzip.open if path.suffix == ".gz" else open
            with unpacked(path, "rb") as file:
                held = re.sub(rb"(?<=\d)[eE](?=[+-]?\d)", b"D", file.read())
            place.write_bytes((gzip.compress if path.suffix == ".gz" else bytes)(BOM_UTF8 + held))
        return matrix_files.load_matrices(*new, **options)

    monkeypatch.setitem(WRITERS[name].__globals__, "load_matrices", respelt)
    check(WRITERS[name](tmp_path, model), model)
