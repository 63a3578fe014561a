"""Pages say what the program has: every key, dimension and message, and the tables' words."""

import ast
import re
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import matplotlib.image
import numpy as np
import pytest

from vanelock import Study
from vanelock.common.checked import _known_keys
from vanelock.input.schema.structure.own_mesh import CasingSet, VaneSet
from vanelock.nonlinear import Contact, Options, Response, System, frequency_response
from vanelock.results.figures.curves import NOTE
from vanelock.results.files.writer import Results
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


def test_the_page_is_up_to_date():
    assert (ROOT / "docs" / "keys.md").read_text("utf-8") == PAGE, "run python tools/keys_page.py"


def test_every_key_is_described_in_full():
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


def test_every_key_of_the_template_is_one_of_the_schema_s():
    given, _ = TOOL["template"]()
    in_use = {key for key, each in given.items() if each.active}
    assert len(in_use) > 60
    assert in_use <= set(_known_keys(Study))


def test_the_glossary_has_the_words_of_the_tables():
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


def test_the_tables_are_up_to_date():
    assert (
        GEOMETRY["written"](TEXT, "Dimensions").strip() == GEOMETRY["dimension_tables"]().strip()
    ), "run tools/geometry_page.py"


def test_every_named_size_is_shown():
    rows = GEOMETRY["written"](TEXT, "Sizes").strip().splitlines()[2:]
    assert [row.split("|")[1].strip(' `"') for row in rows] == list(GEOMETRY["SIZES"])


@pytest.mark.parametrize("part", ["vane", "casing"])
def test_its_drawings_are_there(part):
    name = f"drawing_{part}.png"
    assert f"(pictures/{name})" in TEXT
    picture = matplotlib.image.imread(ROOT / "docs" / "pictures" / name)
    assert picture.shape[1] > 2000
    assert picture.min() < 0.2


ADVICE = (ROOT / "docs" / "not_converged.md").read_text("utf-8")
REPORTED = re.compile(
    r"did not converge|DID NOT CONVERGE|NOT CONVERGED|NOT DETERMINED|no converged|not converged \("
    r"|needs a converged|point[^.]* converged|no solution|something is not held|rigid[- ]body"
    r"|end of the frequency range|WARNING"
)
ELSEWHERE = {
    NOTE,  # a caption
    "WARNING: ",  # taken off a warning, or put before one
}


def messages() -> set[str]:
    """The fixed parts of every text in the code about convergence, docstrings apart."""
    found = set()
    stages = [init.parent for init in (ROOT / "vanelock").glob("*/__init__.py")]
    for source in [path for stage in stages for path in stage.rglob("*.py")]:
        tree = ast.parse(source.read_text("utf-8"))
        plain = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                parts = [p.value for p in node.values if isinstance(p, ast.Constant)]
                plain |= {id(p) for p in node.values}
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                parts = [] if id(node) in plain else [node.value]
            else:
                continue
            found |= {str(part) for part in parts if REPORTED.search(str(part))}
    return {each for each in found - ELSEWHERE if "a cell is unknown" not in each}


def test_every_message_is_on_the_page():
    """Its longest run of words, since what is around differs from place to place."""
    found = messages()
    assert len(found) > 15
    page = " ".join(ADVICE.replace("`", "").split())
    missing = {text for text in found if core(text) not in page}
    assert missing == set(), "say in docs/not_converged.md what it means and what to try"


def core(text: str) -> str:
    """The part between punctuation that is about convergence."""
    parts = filter(REPORTED.search, re.split(r"[,;:()]|\.(?=\s|$)", text))
    return next(parts, text).strip(" ;:,.()")


def test_every_message_on_the_page_has_an_advice():
    rows = [line for line in ADVICE.splitlines() if line.startswith("|") and "---" not in line]
    cells = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]
    assert len(cells) > 20
    assert [row[0] for row in cells if len(row) != 3 or not row[2]] == []


def spring(stiffness: float) -> System:
    """A mass of 1 kg on a contact that is pressed."""
    pressed = Contact(normal=0, kn=stiffness, preload=1e-3 * stiffness)
    return System.from_matrices([[1.0]], [[0.0]], [pressed], damping_ratio=0.01, force={0: 1.0})


@pytest.mark.parametrize("lost", [(), (0, 2)])
def test_what_the_page_looks_closer_with_takes_the_system_of_the_case(tmp_path, monkeypatch, lost):
    """As written, on a sweep whose first case is stiffer, with points lost and without."""
    snippet = next(s for s in re.findall(r"^```python\n(.*?)^```$", ADVICE, re.M | re.S))
    first, second = spring(4e6), spring(1e6)
    found: Response = frequency_response(second, [100.0, 120.0, 140.0], Options(1))
    converged = ~np.isin(np.arange(3), lost)
    results = Results(tmp_path / "runs" / "my" / "results.h5")
    results.path.parent.mkdir(parents=True)
    with results.edit("system", "response/mu=0.15") as file:
        results.put_system(file, "system", first)
        results.put(file, "response/mu=0.15", replace(found, converged=converged))
        results.put_system(file, "response/mu=0.15/system", second)
    results.flush()
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(snippet, names)
    assert ("again" in names) == bool(lost)
    if lost:
        expected = found.amplitude[list(lost)]
        np.testing.assert_allclose(names["again"].amplitude, expected, rtol=1e-8)
