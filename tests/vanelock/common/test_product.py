"""Products survive a round trip through HDF5; what is not one is refused in one line."""

from dataclasses import dataclass, field

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product


@dataclass(frozen=True)
class Inner(Product):
    value: NDArray[np.complex128]


@dataclass(frozen=True)
class Outer(Product):
    name: str
    count: int
    ratio: float
    matrix: sp.csc_array
    length: NDArray[np.float64] = field(metadata={"unit": "m"})
    sets: dict[str, NDArray[np.int64]]
    inner: dict[int, Inner]
    labels: tuple[str, ...]
    flag: bool
    absent: NDArray[np.float64] | None = None


def example() -> Outer:
    return Outer(
        name="vane ψ",
        count=16,
        ratio=0.003,
        matrix=sp.csc_array([[1.0, 0.0], [2.5, 3.0]]),
        length=np.array([0.1, 0.2]),
        sets={"left face": np.array([3, 1, 2]), "none": np.empty(0, np.int64)},
        inner={0: Inner(np.array([1j])), 12: Inner(np.array([2.0 - 1j]))},
        labels=("a", "β"),
        flag=True,
    )


def test_round_trip(tmp_path):
    path = tmp_path / "product.h5"
    example().save(path)
    back = Outer.load(path)
    assert (back.name, back.count, back.ratio, back.flag) == ("vane ψ", 16, 0.003, True)
    assert back.labels == ("a", "β")
    assert back.absent is None
    assert sorted(back.inner) == [0, 12]
    np.testing.assert_array_equal(back.inner[12].value, [2.0 - 1j])
    np.testing.assert_array_equal(back.sets["left face"], [3, 1, 2])
    assert back.sets["none"].size == 0
    np.testing.assert_array_equal(back.matrix.toarray(), [[1.0, 0.0], [2.5, 3.0]])
    with h5py.File(path) as file:
        assert file["length"].attrs["unit"] == "m"


def test_saving_makes_folders_and_leaves_what_is_there_if_it_fails(tmp_path):
    path = tmp_path / "inner.h5"
    Inner(np.array([1.0 + 0j])).save(path)
    with pytest.raises(TypeError):
        Inner(object()).save(path)  # type: ignore[arg-type]
    np.testing.assert_array_equal(Inner.load(path).value, [1.0])
    assert [item.name for item in tmp_path.iterdir()] == ["inner.h5"]
    example().save(tmp_path / "new" / "there.h5")
    assert (tmp_path / "new" / "there.h5").is_file()
    (tmp_path / "taken").write_text("mine")
    with pytest.raises(InputError, match=r"taken.*cannot be written"):
        example().save(tmp_path / "taken" / "where.h5")
    assert (tmp_path / "taken").read_text() == "mine"


def test_what_is_no_product_is_refused(tmp_path):
    Inner(np.array([1.0 + 0j])).save(tmp_path / "inner.h5")
    (tmp_path / "text.h5").write_text("not HDF5")
    (tmp_path / "folder.h5").mkdir()
    with h5py.File(tmp_path / "hollow.h5", "w") as file:
        file.attrs["product"] = "Outer"
    whole = (tmp_path / "inner.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    cases = {
        "absent.h5": "no such file",
        "text.h5": "not a readable HDF5 file",
        "cut.h5": "not a readable HDF5 file",
        "inner.h5": "expected a Outer, found Inner",
        "hollow.h5": "not a vanelock Outer",
        "folder.h5": "is a folder, an HDF5 file is needed",
    }
    for name, message in cases.items():
        with pytest.raises(InputError, match=message) as caught:
            Outer.load(tmp_path / name)
        assert "\n" not in str(caught.value)
        assert name in str(caught.value)


def test_a_product_shows_itself_in_one_line():
    shown = repr(example())
    expected = (
        "Outer(name='vane ψ', count=16, ratio=0.003, matrix=<2 x 2 sparse, 3 entries>, "
        "length=<2 float64>, sets={left face, none}, inner={0, 12}, labels=('a', 'β'), flag=True)"
    )
    assert shown == expected
