"""The page on geometry shows the dimensions that the program has."""

import runpy
from pathlib import Path
from typing import Any

import matplotlib.image
import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE: dict[str, Any] = runpy.run_path(str(ROOT / "tools" / "geometry_page.py"))
TEXT = (ROOT / "docs" / "geometry.md").read_text("utf-8")


def test_the_tables_are_up_to_date() -> None:
    assert PAGE["written"](TEXT, "Dimensions").strip() == PAGE["dimension_tables"]().strip(), (
        "run tools/geometry_page.py"
    )


def test_every_named_size_is_shown() -> None:
    rows = PAGE["written"](TEXT, "Sizes").strip().splitlines()[2:]
    assert [row.split("|")[1].strip(' `"') for row in rows] == list(PAGE["SIZES"])


@pytest.mark.parametrize("part", ["vane", "casing"])
def test_its_drawings_are_there(part: str) -> None:
    name = f"drawing_{part}.png"
    assert f"(pictures/{name})" in TEXT
    picture = matplotlib.image.imread(ROOT / "docs" / "pictures" / name)
    assert picture.shape[1] > 2000
    assert picture.min() < 0.2
