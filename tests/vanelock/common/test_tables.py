"""Products and tables, quantities with units: what terminal, CSV, HDF5 and machines are given."""

import math
from dataclasses import dataclass, field

import h5py
import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.common.quantities import _rpm, si
from vanelock.common.tables import FACTORS, Column, Table, counted, heads

SI = {
    "µm": "m", "mm": "m", "mm²": "m^2", "mm³": "m^3", "cm³": "m^3", "µJ": "J", "mW": "W",
    "MPa": "Pa", "ms": "s",
}  # fmt: skip


@pytest.mark.parametrize("unit", SI)
def test_factors_are_those_of_a_library_of_units(unit):
    of_si = si(f"1 {unit}", SI[unit])
    assert isinstance(of_si, float)
    assert Column("x", unit).shown(of_si) == pytest.approx(1)
    assert Column("x", f"{unit}/h").shown(of_si) == pytest.approx(1)
    assert set(FACTORS) == {*SI, "%"}
    assert Column("x", "%").shown(0.25) == 25


def table() -> Table:
    columns = (Column("case"), Column("peak", "µm", key="peak_um"), Column("H"), Column("x"))
    return Table("Cases", columns, [("a", 4e-5, np.int64(1200), None), ("b", math.nan, 3, None)])


def test_rows_in_si_are_shown_in_the_units_of_their_columns():
    assert table().shown == [["a", 40, 1200, None], ["b", None, 3, None]]
    assert table().record()["rows"][0] == {"case": "a", "peak_um": 40, "H": 1200, "x": None}
    assert table().by_head()["peak (µm)"] == [40, None]
    assert Column("area", "mm²") in (area := Table("", (Column("area", "mm²"),), [(1.0,)])).columns
    assert area.by_head() == {"area (mm^2)": [1e6]}


def test_whole_numbers_are_printed_in_full_others_to_four_digits_and_one_is_singular():
    plain, exact = Column("n"), Column("f", form=".6g")
    assert [plain.text(each) for each in (1234567, 12.34567, None, "text", True)] == [
        "1,234,567", "12.35", "-", "text", "yes",
    ]  # fmt: skip
    assert exact.text(12.34567) == "12.3457"
    found = [counted(*each) for each in ((1, "contact"), (0, "case"), (2000, "mesh"))]
    assert found == ["1 contact", "0 cases", "2,000 meshes"]


def test_columns_are_left_out_with_what_they_say_below():
    assert [column.head for column in table().without("peak_um", "H").columns] == ["case", "x"]
    assert table().without("case").rows[1] == [pytest.approx(math.nan, nan_ok=True), 3, None]
    assert [each.head for each in table().without_empty("H", "x").columns] == ["case", "peak", "H"]
    columns = (*heads("case"), Column("x", note="x: from 0"), Column("y", note="y: to 1"))
    said = Table("Cases", columns, [], ("a note",))
    assert said.lines == ["x: from 0; y: to 1.", "a note"]
    assert said.without("x").lines == ["y: to 1.", "a note"]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.05 mm", "m", 5e-5),
        ("20 um", "m", 2e-5),
        ("1.67e7 N/m", "N/m", 1.67e7),
        ("16.7 N/um", "N/m", 1.67e7),
        ("170 GPa", "Pa", 170e9),
        ("8.2 g/cm^3", "kg/m^3", 8200.0),
        ("0.25 kHz", "Hz", 250.0),
        ("1.5 kg*mm", "kg*m", 1.5e-3),
        (0.25, "m", 0.25),
    ],
)
def test_units(text, unit, value):
    assert si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "5 s", "mm", "", "5 parsnips", "9**9**9**9", "__import__('os')", "1 mm" + " " * 99,
        "nan m m", "9^9^9^9 m", "9⁹⁹⁹⁹⁹⁹⁹⁹⁹ m", "9 cubed cubed cubed m", "9**9**9 m", "(9)^(9)^9 m",
        "9e9^9",
    ],
)  # fmt: skip
def test_text_that_is_no_length_is_refused_and_arithmetic_not_evaluated(text):
    with pytest.raises(ValueError, match="expected a number in m"):
        si(text, "m")


def test_revolutions_are_not_radians():
    assert _rpm("16000 rpm") == _rpm("1.6e4rpm") == _rpm(16000) == 16000
    for text in ("270 Hz", "16000", "1.2.3 rpm", "rpm"):
        with pytest.raises(ValueError, match="expected a number in rpm"):
            _rpm(text)


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
