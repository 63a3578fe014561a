"""What cannot be used is refused in one line that names the file."""

import gzip
import io
import pickle
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from tests.fem.matrix_files.conftest import Model
from vanelock.common.errors import InputError
from vanelock.fem.matrix_files import load_matrices, load_nodes, load_pairs, tables

BANNER = "%%MatrixMarket matrix coordinate real symmetric\n"
GOOD = BANNER + "3 3 3\n1 1 2\n2 2 2\n3 3 2\n"
ARRAY = "%%MatrixMarket matrix array real {}\n3 3\n"
LABELS = "node,direction\n1,x\n1,y\n1,z\n"
ONE_COLUMN = (
    "DMIG    KAAX    0       6       2\nDMIG    KAAX    1       1               1       {}\n"
)

TEXTS = {
    "10^12 entries": ("k.mtx", BANNER + "9 9 1000000000000\n1 1 1\n", "1,000,000,000,000 ent"),
    "10^12 rows": (
        "k.mtx", BANNER + "2000000000000 2000000000000 1\n1 1 1\n", "2,000,000,000,000 rows"
    ),
    "10^12 in an array": (
        "k.mtx", "%%MatrixMarket matrix array real general\n1000000 1000000\n1\n", "announced"
    ),
    "rows without entries": ("k.mtx", BANNER + "5000 5000 1\n" + "1 1 1\n" + " " * 9000, "only 1"),
    "nan": ("k.mtx", GOOD.replace("2 2 2", "2 2 nan"), "finite"),
    "inf": ("k.mtx", GOOD.replace("2 2 2", "2 2 inf"), "finite"),
    "negative index": ("k.mtx", GOOD.replace("2 2 2", "-2 2 2"), ""),
    "text": ("k.mtx", GOOD.replace("2 2 2", "2 two 2"), ""),
    "twice": ("k.mtx", GOOD.replace("2 2 2", "3 3 2"), "given twice"),
    "pattern": ("k.mtx", GOOD.replace("real", "pattern"), "pattern"),
    "skew": ("k.mtx", GOOD.replace("symmetric", "skew-symmetric"), "skew-symmetric"),
    "not square": ("k.mtx", GOOD.replace("3 3 3", "3 4 3"), "square"),
    "no banner": ("k.mtx", GOOD.removeprefix(BANNER), 'like sizes, "3 3 3": the banner of a'),
    "index 0": ("k.mtx", "0 0 2.\n1 1 2.\n", "row or column 0 is outside: they count from 1"),
    "half a file": ("k.mtx", GOOD[:-8], ""),
    "all zero": ("k.mtx", GOOD.replace(" 2\n", " 0\n"), "zero"),
    "not symmetric": (
        "k.mtx", GOOD.replace("symmetric", "general").replace("1 1 2", "1 2 2"), "not symmetric"
    ),
    "empty": ("k.mtx", "", "empty"),
    "binary": ("k.mtx", "1 2\0 3", "not a text"),
    "abaqus, internal node": ("k.mtx", "-3,1, -3,1, 4.0\n", "internal"),
    "abaqus, freedom": ("k.mtx", "3,11, 3,11, 4.0\n", "freedom 11"),
    "abaqus, text": ("k.mtx", "3,1, 3,1, 4.0\n3,x, 3,1, 4.0\n", ""),
    "abaqus, vast": ("k.mtx", "1 1 1.0\n900000000 900000000 1.0\n", "only 2"),
    "abaqus, differs": ("k.mtx", "1,1,1,2,4.0\n1,2,1,1,5.0\n", "differs"),
    "abaqus, all fixed": ("k.mtx", "1,1,1,1,1e36\n", "fixed"),
    "superelement, entries": (
        "k.mtx",
        "*USER ELEMENT, NODES=1\n** ELEMENT NODES\n** 7\n1,2\n*MATRIX,TYPE=STIFFNESS\n1,2\n",
        "triangle of 2",
    ),
    "superelement, place": (
        "k.mtx",
        "*USER ELEMENT, NODES=1\n** ELEMENT NODES\n** 7\n1\n4,1\n*MATRIX,TYPE=STIFFNESS\n1\n",
        "place 4",
    ),
    "harwell, short": ("k.hb", "title\n1 1 1 1\nRSA 3 3 3 0\n(1I3) (1I3) (1E9.3)\n1\n", ""),
    "harwell, vast": (
        "k.hb",
        "t\n9 3 3 3\nRSA 9000000000 9000000000 3 0\n(1I3) (1I3) (1E9.3)\n1\n1\n1\n1\n",
        "",
    ),
    "harwell, elements": ("k.hb", "t\n1 1 1 1\nRSE 3 3 3 0\n(1I3) (1I3) (1E9.3)\n1\n", "RSE"),
    "dmig, no head": ("k.pch", "DMIG,KAAX,1,1,,1,1,2.\n", "head"),
    "dmig, rectangular": ("k.pch", "DMIG    KAAX    0       9       2\n", "form 9"),
    "dmig, a large head of one line": (
        "k.pch", "DMIG*   KAAX" + 19 * " " + "0" + 15 * " " + "6" + 15 * " " + "2\n", "no entries"
    ),
    "dmig, digits that are none": ("k.pch", ONE_COLUMN.format("1       1_0"), "1_0"),
    "dmig, none": ("k.bdf", "GRID,1,,0.,0.,0.\n", "no matrix"),
    "more numbers than announced": ("k.mtx", GOOD + "1 2 1\n", "4 lines of 3"),
    "half a row": ("k.mtx", GOOD.replace("2 2 2", "2.5 2 2"), "2.5"),
    "array of too few": ("k.mtx", ARRAY.format("symmetric") + "1.0\n" * 5, "5 lines"),
    # SciPy's reader crashes on these.
    "array of too many": ("k.mtx", ARRAY.format("symmetric") + "1.0\n" * 46, ""),
    "full array of too many": ("k.mtx", ARRAY.format("general") + "1.0\n" * 49, ""),
    "not npz": ("k.npz", "PK nothing", "npz"),
    "not npy": ("k.npy", "nothing", "NumPy"),
    "not mat": ("k.mat", "nothing" * 40, "mat"),
    "not hdf5": ("k.h5", "nothing" * 40, "HDF5"),
    "not full": ("k.full", "nothing" * 400, "full"),
}  # fmt: skip


def refused(path: Path, labels: str = LABELS) -> str:
    """The line with which a file of matrices is refused."""
    (path.parent / "dofs.csv").write_text(labels)
    with pytest.raises(InputError) as caught:
        load_matrices(path, dofs=path.parent / "dofs.csv")
    (line,) = str(caught.value).splitlines()
    return line


@pytest.mark.parametrize("case", TEXTS)
def test_broken_text(case: str, tmp_path: Path) -> None:
    name, text, expected = TEXTS[case]
    (tmp_path / name).write_text(text)
    message = refused(tmp_path / name)
    assert name in message
    assert expected in message


def bomb(path: Path) -> None:
    """Entries of zeros without an end, a thousandth of their size."""
    path.write_bytes(gzip.compress(GOOD.encode() + b"\n" * (64 << 20)))


def cut(path: Path) -> None:
    path.write_bytes(gzip.compress(GOOD.encode())[:-12])


def header_of_a_terabyte(path: Path) -> None:
    held = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        held, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
    )
    path.write_bytes(held.getvalue() + bytes(80))


def unfinished_header(path: Path) -> None:
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (3L, (3), }"
    path.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)


def zipped_zeros(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("K.npy", bytes(64 << 20))


class Trap:
    """Runs when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
        return (exec, ("raise SystemExit('unpickled')",))


def pickled(path: Path) -> None:
    np.save(path, np.array([[Trap()]], object), allow_pickle=True)


def bare_pickle(path: Path) -> None:
    path.write_bytes(pickle.dumps(Trap()))


def cells(path: Path) -> None:
    held = np.empty((3, 3), object)
    held[:] = 1.0
    scipy.io.savemat(path, {"K": held})


def outside(path: Path) -> None:
    with h5py.File(path.with_name("other.h5"), "w") as other:
        other["K"] = np.eye(3)
    with h5py.File(path, "w") as file:
        file["K"] = h5py.ExternalLink("other.h5", "/K")


def never_written(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("K", (10**6, 10**6), "f8", chunks=(1000, 1000))


FILES = {
    "packed bomb": ("k.mtx.gz", bomb, "unpacks to more"),
    "packed, cut": ("k.mtx.gz", cut, "not a whole"),
    "npy of a terabyte": ("k.npy", header_of_a_terabyte, "bytes"),
    "npy, unfinished": ("k.npy", unfinished_header, "not NumPy's format"),
    "npz of zeros": ("k.npz", zipped_zeros, "claim"), "objects": ("k.npy", pickled, "objects"),
    "a pickle": ("k.npy", bare_pickle, "NumPy"), "cells": ("k.mat", cells, "no matrix"),
    "a link": ("k.h5", outside, "link to another file"),
    "data never written": ("k.h5", never_written, "packed, and more than"),
}  # fmt: skip


@pytest.mark.parametrize("case", FILES)
def test_broken_file(case: str, tmp_path: Path) -> None:
    name, write, expected = FILES[case]
    write(tmp_path / name)
    message = refused(tmp_path / name)
    assert name in message
    assert expected in message


def test_link_to_another_file_is_refused_by_name(tmp_path: Path) -> None:
    outside(tmp_path / "k.h5")
    assert "link to another file" in refused(Path(f"{tmp_path / 'k.h5'}:K"))


@pytest.mark.parametrize(("labels", "expected"), [
    ("node,direction\n1,x\n1,x\n1,z\n", "labels two rows"),
    ("node,direction\n1,x\n1,y\n", "2 lines"),
    ("node,direction\n-1,x\n1,y\n1,z\n", "numbered from 1"),
    ("node,direction\n1,x\n1,up\n1,z\n", "up"), ("node,dof\n1,1\n1,7\n1,3\n", "1 to 6"),
    ("row,node,dof\n1,1,1\n1,1,2\n3,1,3\n", "each once"), ("node\n1\n2\n3\n", "no column"),
    ("node,direction\n1.5,x\n1,y\n1,z\n", "whole numbers"),
])  # fmt: skip
def test_labels(labels: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "k.mtx").write_text(GOOD)
    message = refused(tmp_path / "k.mtx", labels)
    assert expected in message
    assert "dofs.csv" in message or "k.mtx" in message


def test_labels_and_sizes_that_do_not_agree(model: Model, tmp_path: Path) -> None:
    def said(stiffness: str, *mass: str, **options: Any) -> str:
        paths = [tmp_path / f"{name}.mtx" for name in "km"]
        for path, text in zip(paths, (stiffness, *mass), strict=False):
            path.write_text(text)
        with pytest.raises(InputError) as caught:
            load_matrices(*paths[: 1 + len(mass)], **options)
        return str(caught.value)

    mapping = tmp_path / "k.mapping"
    mapping.write_text("Eqn Node DOF\n1 1 UX\n2 1 TEMP\n3 1 UZ\n")
    assert "k.mapping: line 3: TEMP" in said(GOOD, dofs=mapping)
    assert "give dofs" in said(GOOD)
    other = said("1,1,1,1,4.0\n2,1,2,1,4.0\n", "1,1,1,1,4.0\n3,1,3,1,4.0\n")
    assert re.search(r"m\.mtx: node 3, direction x is not in .*k\.mtx", other)
    np.save(tmp_path / "k.npy", model.K)
    np.save(tmp_path / "m.npy", model.M[:6, :6])
    nodes = model.write_nodes(tmp_path)
    with pytest.raises(InputError, match=r"m\.npy: 6 rows, but .*k\.npy has 9"):
        load_matrices(tmp_path / "k.npy", tmp_path / "m.npy", nodes=nodes)
    for unit in ("furlongs per fortnight", "kg", "0 mm", "mm**9**9**9", ""):
        with pytest.raises(InputError, match="length"):
            load_matrices(tmp_path / "k.npy", nodes=nodes, length=unit)


@pytest.mark.parametrize(("kind", "text", "expected"), [
    ("nodes", "1 2 x", "x"), ("nodes", "1 2 1", "twice"), ("nodes", "0", "0"),
    ("nodes", "-4", "-4"), ("nodes", "# none\n", "no nodes"), ("nodes", "1.5", "1.5"),
    ("nodes", "99999999999999999999", "node's number"), ("pairs", "a,b\n1\n", "line 2"),
    ("pairs", "a,a\n1,2\n", "twice"), ("pairs", "1,2\n3,4\n", "column names"),
    ("pairs", "a,b\n1,nan\n2,3\n", "nan"), ("pairs", "a,b\n", "no rows"),
    ("pairs", "a,b\n1,\n", "line 2"), ("pairs", "a\n1\ninf\n", "inf"),
    ("pairs", "a\n1\n1e999\n", "1e999"),
])  # fmt: skip
def test_lists_of_nodes_and_pairs(kind: str, text: str, expected: str, tmp_path: Path) -> None:
    path = tmp_path / f"{kind}.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        (load_nodes if kind == "nodes" else load_pairs)(path)
    assert path.name in str(caught.value)
    assert expected in str(caught.value)


def test_names_of_columns_are_compared_in_proportion_to_their_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last of them is named twice; comparing each with each would take n² / 2."""
    compared = []

    class Name(str):
        __slots__ = ()
        __hash__ = str.__hash__

        def __eq__(self, other: object) -> bool:
            compared.append(other)
            return str.__eq__(self, other)

    names = [Name(f"c{i}") for i in range(1000)] + [Name("c999")]
    monkeypatch.setattr(tables, "_cells", lambda *_: names)
    (tmp_path / "pairs.csv").write_text("names\n")
    with pytest.raises(InputError, match="column 'c999' is named twice"):
        load_pairs(tmp_path / "pairs.csv")
    assert len(compared) < 10 * len(names)
