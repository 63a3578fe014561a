"""Tables on lines of any width: nothing breaks, nothing is lost but what is minor."""

import numpy as np
import pytest

from vanelock.common.tables import Column, Table
from vanelock.pipeline.text_table import _digits, text_lines, wrapped

FOUND = 3, 6.309e-5, 252.021, 0.4752, 8e-4, "63/63"
CASES = Table(
    "Responses of a very long name of an output node, circumferential",
    (
        Column("case"),
        Column("H", minor=True),
        Column("peak", "µm"),
        Column("at", "Hz", ".6g"),
        Column("relative to free"),
        Column("dissipated", "µJ", note="dissipated: by friction in a cycle, of one sector"),
        Column("converged", minor=True),
    ),
    [
        (f"mu={mu},interference={i}um,engine_order={order}", *FOUND)
        for mu in ("0.15", "0.3")
        for i in (4, 17)
        for order in (1, 3)
    ],
    ("warning: a part is held by no closed contact at rest; where it lies is not determined",),
)


def test_a_table_stands_under_its_heads_and_units() -> None:
    columns = (Column("joint"), Column("n", "N", ".2f"), Column("safety factor", form=".1f"))
    table = Table("A title", columns, (("hook", 280.126, None),), ("a note [µm]",))
    assert text_lines(table) == [
        "",
        "A title",
        "             n  safety",
        " joint     [N]  factor",
        " ─────────────────────",
        " hook   280.13       -",
        "a note [um]",
    ]


@pytest.mark.parametrize("width", [40, 60, 80, 100, 140, 200])
def test_lines_fit_and_words_are_whole(width: int) -> None:
    lines = text_lines(CASES, width)
    assert max(map(len, lines)) <= width
    whole = {
        word for line in text_lines(CASES) for part in line.split() for word in part.split(",")
    }
    for line in lines:
        for part in line.split():
            assert set(part.split(",")) <= whole | {"─" * len(part)}
    # Every number that is not minor is there for each of the eight cases.
    text = "\n".join(lines)
    for number in ("63.09", "252.021", "0.4752", "800"):
        assert text.count(number) == 8


def test_folded_rows_begin_with_their_names_and_long_reasons_are_on_several_lines():
    columns = Column("a"), *(Column(f"number {i}") for i in range(6))
    table = Table("T", columns, [("row", *[12345.0] * 6)])
    lines = text_lines(table, 30)
    assert sum(line.startswith(" row ") for line in lines) == 3
    assert max(map(len, lines)) <= 30
    why = "the mesh of the vane cannot be made: " + "its sides cross; " * 9
    columns = Column("case"), Column("tried"), Column("why")
    table = Table("FAILED cases", columns, [("mu=0.3", 2, why)])
    lines = text_lines(table, 60)
    assert max(map(len, lines)) <= 60
    assert sum("its sides" in line for line in lines) >= 3
    assert len([line for line in lines if line.startswith(" mu=0.3")]) == 1


def test_lines_break_after_commas_and_spaces_alone_and_no_rows_leave_heads():
    assert wrapped("mu=0.15,interference=4um", 10) == ["mu=0.15,", "interference=4um"]
    assert wrapped("", 10) == [""]
    table = Table("Inputs that differ", [Column("key"), Column("value")], [])
    assert text_lines(table, 80)[:3] == ["", "Inputs that differ", " key  value"]


def test_a_column_has_the_same_decimals() -> None:
    plain = Column("peak", "µm")
    assert _digits(plain, [132.8, 6.3, None, 0.0]) == ["132.8", "6.3", "-", "0.0"]
    assert _digits(plain, [257.4, 1.437]) == ["257.40", "1.44"]
    assert _digits(Column("mu", form=".3g"), [0.3, 0.15]) == ["0.30", "0.15"]
    assert _digits(Column("f", form=".6g"), [1319.0, 1348.55]) == ["1319.00", "1348.55"]
    # One that would be left with a single digit keeps its own.
    assert _digits(plain, [132.8, 0.0123]) == ["132.8", "0.0123"]
    assert _digits(plain, [9.99999, 1.5]) == ["10.0", "1.5"]
    assert _digits(Column("error", form=".0e"), [6e-7, np.nan]) == ["6e-07", "nan"]
