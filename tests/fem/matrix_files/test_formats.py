"""The same small model, written in every format by others, gives the same matrices exactly."""

import gzip
import io
import re
from codecs import BOM_UTF8
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from numpy.typing import NDArray

from tests.fem.matrix_files.conftest import DATA, NODES, Model
from vanelock.fem.matrix_files import load_matrices

Given = tuple[tuple[Path, ...], dict[str, Any]]
"""What `load_matrices` is given: files of stiffness and mass, and options."""


def check(written: Given, model: Model) -> None:
    """Labels in any order; entries exactly."""
    found = load_matrices(*written[0], **written[1])
    order = np.lexsort((found.direction, found.node))
    wanted = np.lexsort((model.direction, model.node))
    assert found.node[order].tolist() == model.node[wanted].tolist()
    assert found.direction[order].tolist() == model.direction[wanted].tolist()
    assert found.M is not None
    for ours, theirs in ((found.K, model.K), (found.M, model.M)):
        assert ours.format == "csc"
        assert np.array_equal(ours.toarray()[np.ix_(order, order)], theirs[np.ix_(wanted, wanted)])


def both(folder: Path, model: Model, *names: str) -> Iterator[tuple[Path, NDArray[np.float64]]]:
    """Files of these names and what to write in them."""
    yield from zip([folder / name for name in names], (model.K, model.M), strict=True)


def market(symmetry: str, dense: bool, packed: bool) -> Callable[[Path, Model], Given]:
    def write(folder: Path, model: Model) -> Given:
        names = [f"{name}.mtx{'.gz' if packed else ''}" for name in "km"]
        for path, matrix in both(folder, model, *names):
            held = io.BytesIO()
            shown = matrix if dense else sp.coo_array(matrix)
            scipy.io.mmwrite(held, shown, symmetry=symmetry, comment="a comment")
            path.write_bytes(gzip.compress(held.getvalue()) if packed else held.getvalue())
        return (folder / names[0], folder / names[1]), {"dofs": model.write_mapping(folder)}

    return write


def harwell(folder: Path, model: Model) -> Given:
    for path, matrix in both(folder, model, "k.hb", "m.rb"):
        scipy.io.hb_write(path, sp.csc_matrix(matrix))
    return (folder / "k.hb", folder / "m.rb"), {"dofs": model.write_dofs(folder)}


def hbmat(folder: Path, model: Model) -> Given:
    """As HBMAT writes it: RSA, one number a line, the right-hand side after the matrix."""
    for path, matrix in both(folder, model, "k.matrix", "m.matrix"):
        lower = sp.csc_array(np.tril(matrix))
        n, count = len(matrix), lower.nnz
        lines = [
            f"{'Stiffness Matrix from ANSYS FULL file':72s}{'':8s}",
            f"{3 * n + 1 + 2 * count:14d}{n + 1:14d}{count:14d}{count:14d}{n:14d}",
            f"RSA{'':11s}{n:14d}{n:14d}{count:14d}{0:14d}",
            f"{'(1I10)':16s}{'(1I10)':16s}{'(1D25.15)':20s}{'(1D25.15)':20s}",
            f"F{'':13s}{1:14d}{0:14d}",
            *(f"{k + 1:10d}" for k in [*lower.indptr, *lower.indices]),
            *(f"{value:25.15E}".replace("E", "D") for value in [*lower.data, *np.zeros(n)]),
        ]
        path.write_text("\n".join(lines) + "\n")
    return (folder / "k.matrix", folder / "m.matrix"), {"dofs": model.write_mapping(folder)}


def touching(folder: Path, model: Model) -> Given:
    """Fixed columns without a space between numbers."""
    for path, matrix in both(folder, model, "k.hb", "m.hb"):
        full = sp.csc_array(matrix)
        n, count = len(matrix), full.nnz
        pointer = in_lines([f"{k + 1:3d}" for k in full.indptr], 5)
        row = in_lines([f"{k + 1:2d}" for k in full.indices], 7)
        values = in_lines([f"{value:14.7E}" for value in full.data], 4)
        head = [
            "title",
            f"{0:14d}{len(pointer):14d}{len(row):14d}{len(values):14d}{0:14d}",
            f"RUA{'':11s}{n:14d}{n:14d}{count:14d}{0:14d}",
            f"{'(5I3)':16s}{'(7I2)':16s}{'(1P,4E14.7)':20s}",
        ]
        path.write_text("\n".join([*head, *pointer, *row, *values]) + "\n")
    return (folder / "k.hb", folder / "m.hb"), {"dofs": model.write_dofs(folder)}


def in_lines(words: list[str], count: int, between: str = "") -> list[str]:
    return [between.join(words[k : k + count]) for k in range(0, len(words), count)]


def abaqus(form: str) -> Callable[[Path, Model], Given]:
    def write(folder: Path, model: Model) -> Given:
        # Abaqus sorts by node; so do rows of the coordinate format.
        order = np.lexsort((model.direction, model.node))
        node, dof = model.node[order], model.direction[order] + 1
        for path, matrix in both(folder, model, "k.mtx", "m.mtx"):
            sparse = sp.coo_array(matrix[np.ix_(order, order)])
            lines = ["** Abaqus"] if form == "input" else []
            for i, j, value in zip(*sparse.coords, sparse.data, strict=True):
                if form == "coordinate":
                    lines.append(f"{i + 1:8d} {j + 1:8d}  {value:.14e}")
                elif j <= i:
                    lines.append(f"{node[i]},{dof[i]}, {node[j]},{dof[j]}, {value:.14e}")
            path.write_text("\n".join(lines) + "\n")
        dofs = folder / "dofs.csv"
        rows = [f"{n},{d}" for n, d in zip(node, dof, strict=True)]
        dofs.write_text("\n".join(["node,dof", *rows]) + "\n")
        return (folder / "k.mtx", folder / "m.mtx"), {"dofs": dofs}

    return write


def superelement(folder: Path, model: Model) -> Given:
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
            lines += [line + "," for line in in_lines(numbers, 4, ",")]
    (folder / "sub.mtx").write_text("\n".join(lines) + "\n")
    return (folder / "sub.mtx",), {}


def free_fields(folder: Path, model: Model) -> Given:
    """One triangle in comma-separated fields, two entries a column's first continuation.

    Beside the loads, a rectangular matrix, which nobody asks for.
    """
    lines = ["SOL 103", "CEND", "BEGIN BULK", "DMIG,PAX,0,9,2,0,,,1", "DMIG,PAX,1,0,,11,1,10."]
    label = [f"{n},{d + 1}" for n, d in zip(model.node, model.direction, strict=True)]
    for name, matrix in (("KAAX", model.K), ("MAAX", model.M)):
        lines.append(f"DMIG,{name},0,6,2,0")
        for j in range(9):
            entries = [f"{label[i]},{matrix[i, j]}," for i in range(j, 9) if matrix[i, j]]
            lines.append(f"DMIG,{name},{label[j]},,{entries[0]}")
            lines += ["," + line for line in in_lines(entries[1:], 2, ",")]
    (folder / "deck.bdf").write_text("\n".join([*lines, "ENDDATA"]) + "\n")
    return (folder / "deck.bdf",), {}


def npy(folder: Path, model: Model) -> Given:
    for path, matrix in both(folder, model, "k.npy", "m.npy"):
        np.save(path, matrix)
    return (folder / "k.npy", folder / "m.npy"), {"nodes": model.write_nodes(folder)}


def npz(folder: Path, model: Model) -> Given:
    np.savez_compressed(folder / "both.npz", K=model.K, M=model.M)
    return (folder / "both.npz",), {"dofs": model.write_dofs(folder)}


def sparse_npz(form: str) -> Callable[[Path, Model], Given]:
    def write(folder: Path, model: Model) -> Given:
        for path, matrix in both(folder, model, "k.npz", "m.npz"):
            sp.save_npz(path, sp.coo_array(matrix).asformat(form))
        return (folder / "k.npz", folder / "m.npz"), {"dofs": model.write_dofs(folder)}

    return write


def mat(sparse: bool) -> Callable[[Path, Model], Given]:
    def write(folder: Path, model: Model) -> Given:
        make = sp.csc_array if sparse else np.asarray
        held = {"Kr": make(model.K), "Mr": make(model.M), "name": "a model"}
        scipy.io.savemat(folder / "both.mat", held, do_compression=sparse)
        return (folder / "both.mat",), {"dofs": model.write_dofs(folder)}

    return write


def mat73(folder: Path, model: Model) -> Given:
    """As MATLAB's version 7.3 lays them out: full transposed, sparse in a group."""
    with h5py.File(folder / "both.mat", "w", userblock_size=512) as file:
        file["K"] = model.K.T
        columns, group = sp.csc_array(model.M), file.create_group("M")
        for item in (file["K"], group):
            item.attrs["MATLAB_class"] = np.bytes_("double")
        group.attrs["MATLAB_sparse"] = np.uint64(9)
        group["data"] = columns.data
        group["ir"], group["jc"] = columns.indices.astype("u8"), columns.indptr.astype("u8")
    with open(folder / "both.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return (folder / "both.mat",), {"dofs": model.write_dofs(folder)}


def hdf5(folder: Path, model: Model) -> Given:
    with h5py.File(folder / "both.h5", "w") as file:
        file["part/stiff"] = model.K
        file["part/heavy"] = model.M
    options = {"dofs": model.write_dofs(folder), "names": {"mass": "part/heavy"}}
    return (Path(f"{folder / 'both.h5'}:/part/stiff"),), options


WRITERS: dict[str, Callable[[Path, Model], Given]] = {
    "Matrix Market, general": market("general", False, False),
    "Matrix Market, symmetric": market("symmetric", False, False),
    "Matrix Market, packed": market("symmetric", False, True),
    "Matrix Market, array": market("general", True, False),
    "Matrix Market, symmetric array": market("symmetric", True, False),
    "Harwell-Boeing, SciPy": harwell, "Harwell-Boeing, HBMAT": hbmat,
    "Harwell-Boeing, numbers that touch": touching, "Abaqus, matrix input": abaqus("input"),
    "Abaqus, coordinate": abaqus("coordinate"), "Abaqus, superelement": superelement,
    "DMIG, pyNastran, small": lambda *_: ((DATA / "pynastran_small.bdf",), {}),
    "DMIG, pyNastran, large": lambda *_: ((DATA / "pynastran_large.pch",), {}),
    "DMIG, free fields": free_fields, "NumPy": npy, "NumPy, several": npz,
    "SciPy, csc": sparse_npz("csc"), "SciPy, csr": sparse_npz("csr"),
    "SciPy, coo": sparse_npz("coo"), "SciPy, bsr": sparse_npz("bsr"),
    "SciPy, dia": sparse_npz("dia"), "MATLAB 5": mat(False), "MATLAB 5, sparse": mat(True),
    "MATLAB 7.3": mat73, "HDF5": hdf5,
}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_same_model(name: str, model: Model, tmp_path: Path) -> None:
    check(WRITERS[name](tmp_path, model), model)


@pytest.mark.parametrize("name", [name for name in WRITERS if name[:4] in ("Matr", "Abaq", "DMIG")])
def test_exponents_called_d_behind_a_byte_order_mark(
    name: str, model: Model, tmp_path: Path
) -> None:
    paths, options = WRITERS[name](tmp_path, model)
    new = tuple(tmp_path / path.name for path in paths)
    for path, respelt in zip(paths, new, strict=True):
        packed, held = path.suffix == ".gz", path.read_bytes()
        text = gzip.decompress(held) if packed else held
        text = BOM_UTF8 + re.sub(rb"(?<=\d)[eE](?=[+-]?\d)", b"D", text)
        respelt.write_bytes(gzip.compress(text) if packed else text)
    check((new, options), model)
