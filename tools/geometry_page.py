"""Write the tables of dimensions and sizes into docs/geometry.md and draw the drawings beside it.

Run by `python tools/geometry_page.py` after a dimension, its default or its limits, or the meshes
have changed; a test compares the dimensions on the page with those of the program.
"""

from collections.abc import Iterator
from pathlib import Path

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from vanelock import Study
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    VaneDimensions,
    casing_sector,
    vane_segment,
)
from vanelock.mesh.element_size import SIZES
from vanelock.render import style

DOCS = Path(__file__).resolve().parent.parent / "docs"
PAGE = DOCS / "geometry.md"
BEGIN = "<!-- {} from here to its end written by tools/geometry_page.py. -->\n"
END = "<!-- End of {}. -->\n"
TABLES: dict[str, type[BaseModel]] = {
    "vane": VaneDimensions,
    "vane.hook": HookDimensions,
    "casing": CasingDimensions,
}
"""Tables of the study file that hold dimensions."""

_UNITS = {"m": (1e3, "mm"), "deg": (1.0, "°"), "": (1.0, "")}


def main() -> None:
    """Bring page and drawings up to date."""
    text = PAGE.read_text("utf-8")
    for name, table in (("Dimensions", dimension_tables()), ("Sizes", size_table())):
        begin, end = BEGIN.format(name), END.format(name)
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n{table}\n{end}{rest.partition(end)[2]}"
    PAGE.write_text(text, "utf-8")
    from drawings.casing_sheet import casing_sheet
    from drawings.vane_sheet import vane_sheet

    sheet = (VaneDimensions(), CasingDimensions(), Study().ring.sectors)
    style.write(vane_sheet(*sheet, "vane segment"), DOCS / "pictures" / "drawing_vane.png")
    style.write(casing_sheet(*sheet, "casing sector"), DOCS / "pictures" / "drawing_casing.png")


def written(text: str, name: str) -> str:
    """What stands between the marks of a table."""
    return text.partition(BEGIN.format(name))[2].partition(END.format(name))[0]


def size_table() -> str:
    """What each named size makes of the default dimensions, as Markdown."""
    lines = [
        "| `mesh.size` | elements: vane, casing | dofs: vane + casing | nodes of a cyclic face |",
        "|---|---|---|---|",
    ]
    for size, lengths in SIZES.items():
        vane, casing = vane_segment(size=size), casing_sector(size=size)
        dofs = [3 * len(part.points) for part in (vane, casing)]
        shown = ", ".join(f"{1e3 * lengths[name]:g} mm" for name in ("vane", "casing"))
        faces = len(casing.node_sets["left"])
        total = f"{dofs[0]:,} + {dofs[1]:,} = {sum(dofs):,}"
        lines.append(f'| `"{size}"` | {shown} | {total} | {faces} |')
    return "\n".join([*lines, ""])


def dimension_tables() -> str:
    """Every dimension with default, what is allowed, and what it is, as Markdown."""
    return "\n".join(_table(name, model) for name, model in TABLES.items())


def _table(name: str, model: type[BaseModel]) -> str:
    lines = [f"### `[{name}]`", "", "| key | default | allowed | what it is |", "|---|---|---|---|"]
    lines += [f"| {' | '.join(cells)} |" for cells in _rows(model)]
    return "\n".join([*lines, ""])


def _rows(model: type[BaseModel]) -> Iterator[tuple[str, str, str, str]]:
    for name, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            continue  # a table of its own
        text, _, unit = (field.description or "").partition(" [")
        factor, shown = _UNITS[unit.rstrip("]")]
        default, low, high = (
            _number(value, factor, shown)
            for value in (field.default, _bound(field, "ge"), _bound(field, "le"))
        )
        yield f"`{name}`", default, f"{low} to {high}", text


def _bound(field: FieldInfo, kind: str) -> float:
    (found,) = (getattr(limit, kind) for limit in field.metadata if hasattr(limit, kind))
    return float(found)


def _number(value: float | None, factor: float, unit: str) -> str:
    if value is None:
        return "–"
    return f"{factor * value:.6g}" + (unit if unit == "°" else f" {unit}").rstrip()


if __name__ == "__main__":
    main()
