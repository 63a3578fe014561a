"""Pages on keys and geometry say what the program has; the glossary has the tables' words."""

import re
import runpy
from pathlib import Path
from typing import Any, get_args

import matplotlib.image
import pytest

from vanelock import Study
from vanelock.common.checked import _known_keys
from vanelock.input.schema.structure.own_mesh import CasingSet, VaneSet
from vanelock.results.listing import CASE_COLUMNS

ROOT = Path(__file__).resolve().parents[2]
TOOL: dict[str, Any] = runpy.run_path(str(ROOT / "tools" / "keys_page.py"))
PAGE = TOOL["page"]()


def rows(text: str) -> dict[str, list[str]]:
    """Cells of every row by the key's full name."""
    found, table = {}, ""
    for line in text.splitlines():
        if line.startswith(("## ", "### ")):
            inside = re.search(r"`\[?([\w.]+)\]?`", line)
            table = inside[1] if inside else ""
        elif line.startswith("| `"):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            found[f"{table}.{cells[0].strip('`')}".lstrip(".")] = cells
    return found


def test_the_page_is_up_to_date() -> None:
    assert (ROOT / "docs" / "keys.md").read_text("utf-8") == PAGE, "run python tools/keys_page.py"


def test_every_key_is_described_in_full() -> None:
    dimensions = (ROOT / "docs" / "geometry.md").read_text("utf-8").partition("<!-- End of Dim")[0]
    described = rows(dimensions) | rows(PAGE)
    every = _known_keys(Study)
    leaves = {
        key.replace(".<name>", "")
        for key in every
        if not any(other.startswith(f"{key}.") for other in every)
    }
    # names of node sets are in the table of their page
    page = (ROOT / "docs" / "own_mesh.md").read_text("utf-8")
    sets = {*get_args(VaneSet), *get_args(CasingSet)}
    assert {name for name in sets if f"`{name}`" not in page} == set()
    # lists of tables have a row of their own beside their keys' rows; [settled] has no keys
    assert {key for key in leaves if key not in described} == {"sweep", "rows", "settled"}
    assert {key: cells for key, cells in described.items() if not all(cells)} == {}
    assert {key for key, cells in described.items() if cells[2] in {"any", "number any"}} == set()


def test_every_key_of_the_template_is_one_of_the_schema_s() -> None:
    given, _ = TOOL["template"]()
    in_use = {key for key, each in given.items() if each.active}
    assert len(in_use) > 60
    assert in_use <= set(_known_keys(Study))


def test_the_glossary_has_the_words_of_the_tables() -> None:
    """Every head of the responses' table is a term, or says what it is by itself."""
    glossary = (ROOT / "docs" / "glossary.md").read_text("utf-8")
    heads = [column.head for column in CASE_COLUMNS]
    assert len(heads) > 15
    plain = {"case", "H", "μ", "slip", "open", "converged", "time"}
    terms = " ".join(re.findall(r"^\| (.*?) \|", glossary, re.MULTILINE)).lower()
    words = {word for head in set(heads) - plain for word in head.lower().split()}
    assert {word for word in words if word.rstrip("s") not in terms} <= {
        "lower", "upper", "bound", "vibratory", "stress", "hcf", "to", "per", "dissipated",
    }  # fmt: skip


GEOMETRY: dict[str, Any] = runpy.run_path(str(ROOT / "tools" / "geometry_page.py"))
TEXT = (ROOT / "docs" / "geometry.md").read_text("utf-8")


def test_the_tables_are_up_to_date() -> None:
    assert (
        GEOMETRY["written"](TEXT, "Dimensions").strip() == GEOMETRY["dimension_tables"]().strip()
    ), "run tools/geometry_page.py"


def test_every_named_size_is_shown() -> None:
    rows = GEOMETRY["written"](TEXT, "Sizes").strip().splitlines()[2:]
    assert [row.split("|")[1].strip(' `"') for row in rows] == list(GEOMETRY["SIZES"])


@pytest.mark.parametrize("part", ["vane", "casing"])
def test_its_drawings_are_there(part: str) -> None:
    name = f"drawing_{part}.png"
    assert f"(pictures/{name})" in TEXT
    picture = matplotlib.image.imread(ROOT / "docs" / "pictures" / name)
    assert picture.shape[1] > 2000
    assert picture.min() < 0.2
