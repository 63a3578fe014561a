"""Write docs/keys.md, every key of the study file, from its schema and its commented template.

Run by `python tools/keys_page.py` after a key, its default, its limits or its comment has changed;
a test compares the page with what the program has.
"""

import json
import re
import types
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from vanelock import Study, template_text
from vanelock.mesh import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.element_size import LARGEST, SIZES, SMALLEST

PAGE = Path(__file__).resolve().parent.parent / "docs" / "keys.md"
HEAD = """# Every key of the study file

Every key has a default, so a study names only what it changes; `vanelock init --all` writes all of
them with their comments. Numbers are in SI units (m, kg, N, Pa, Hz; angles in degrees), and text
may carry another unit: `"0.05 mm"`, `"170 GPa"`. What does not fit is refused before anything is
computed, in one line that names the key, the value and what is allowed. Dimensions have
[a page of their own](geometry.md), as have [names of node sets](own_mesh.md).

A dash as default means that the key is not set; the text says what happens then. This page is made
by `python tools/keys_page.py` from the program itself.
"""
MODULUS = "number 1000 to 1e+15 Pa, or pairs `[[degC, Pa], ...]`, ascending; -273.15 to 5,000 degC"
STIFFNESS = "number > 0, ≤ 1e+15 N/m, or text > 0, ≤ 1e+20 N/m^3"
SETS = "a table by [set](own_mesh.md): its name in the mesh file, or a list of its node numbers"
BOUNDS = "or a table, `{ key = [low, high] }`"
SPREAD = "a number 0 to 1, or a list of one a segment, each > -1 to 10"
WORDS: dict[str, str] = {
    "mesh.size": ", ".join(f'`"{name}"`' for name in SIZES)
    + f", or a length from {1e3 * SMALLEST:g} mm to {1e3 * LARGEST:g} mm",
    "outputs.gauges[].direction": '`"span"`, `"chord"`, or an angle from -180 to 180 deg',
    "material.vane.E": MODULUS,
    "material.casing.E": MODULUS,
    "temperature.vane": "a number, degC, or pairs `[[rpm, degC], ...]`",
    "temperature.casing": "a number, degC, or pairs `[[rpm, degC], ...]`",
    "loads.pressure": "a table by set: a pressure to 1e9 Pa, or a CSV file of x, y, z, pressure",
    **{f"joints.{j}.{k}": STIFFNESS for j in ("hook", "interlock") for k in ("kn", "kt")},
    **{f"{part}.sets": SETS for part in ("vane", "casing")},
    "rom.modes": "whole number 1 to 1,000, or two, `[vane, casing]`",
    "mistuning.keys": f"a table by key of a joint, or `vane.frequency`: {SPREAD}",
    "optimise.parameters": f"a list of keys, [those that can be optimised](optimise.md), {BOUNDS}",
    "outputs.monitor": '`"<vane or casing> output <number>[, <component>]"`, the component '
    "`radial`, `circumferential` or `axial`",
    "outputs.gauges": "a list of tables, see below",
    "measured": "tables, see below",
    "damped_modes.influence": "a list of `[segment, real, imaginary]`",
    "wear.dwells": "a list of tables, see below",
    "wear.dwells[].frequency": "number > 0, ≤ 1e+06 Hz, or a range `[low, high]`",
    **{
        f"scatter.keys.{law}": "two numbers" for law in ("uniform", "normal", "lognormal", "within")
    },
    "fit.parameters": f"a list of keys, [those that can be fitted](measured.md), {BOUNDS}",
}
"""What is allowed where the schema checks by a function of its own."""
SWEEP = """A swept key takes the place of the one value: any key that holds a number or a choice of
words, in quotes, with the list of its values. The cases are the product of all lists. Those of
`[rows]` have equal lengths and vary together: a case for each place in them, times those of
`[sweep]`. See [sweeps.md](sweeps.md)."""
SWEPT = ("sweep", "rows")
BY_KEY = {
    "scatter.keys": 'A table by key, such as `"joints.interlock.mu" = { normal = [0.3, 0.05], '
    "within = [0, 1] }`, with one of the first three.",
}
"""What is said above a table whose own keys are names of keys."""
OWN_MESH = """Its dimensions are on [their page](geometry.md). Instead of them, a mesh of yours,
whose node sets are on [another](own_mesh.md):"""
ELSEWHERE = (VaneDimensions, HookDimensions, CasingDimensions)
"""Tables of dimensions, which have a page of their own."""
UNITS = re.compile(r"^(?:deg|N/m\^3|N/m|N|Hz|rpm|degC)[,;] (?=\w)")


@dataclass(frozen=True)
class TemplateKey:
    """What the template says of a key: its value as written there, whether it is set, comment."""

    value: str
    active: bool
    comment: str


def template() -> tuple[dict[str, TemplateKey], dict[str, str]]:
    """Keys of the template by their dotted names, and the paragraph above each table."""
    keys: dict[str, TemplateKey] = {}
    above: dict[str, str] = {}
    table, last = "", ""
    pending: list[str] = []
    for line in template_text(all_keys=True).splitlines():
        head = re.match(r"(# )?\[\[?([\w.]+)\]\]?\s*(?:#\s*(.*))?$", line)
        pair = re.match(r'(# )?("[\w.]+"|\w+) = (.*)$', line)
        if not line.strip():
            pending, last = [], ""
        elif head:
            table, last = head[2], ""
            intro = " ".join([*pending, head[3] or ""]).strip()
            above[table] = above.get(table) or intro
            pending = []
        elif pair:
            value, comment = _split(pair[3])
            last = f"{table}.{pair[2]}".lstrip(".")
            keys.setdefault(
                last, TemplateKey(value, not pair[1], " ".join([*pending, comment]).strip())
            )
            pending = []
        elif line.startswith(" ") and last:
            more = line.strip().lstrip("#").strip()
            before = keys[last]
            keys[last] = TemplateKey(
                before.value, before.active, f"{before.comment} {more}".strip()
            )
        else:
            pending.append(line.lstrip("#").strip())
    return keys, above


def _split(text: str) -> tuple[str, str]:
    """A value and the comment behind it; a # in quotes belongs to the value."""
    found = re.match(r'((?:"[^"]*"|[^"#])*?)\s*(?:#\s*(.*))?$', text)
    return (found[1], found[2] or "") if found else (text, "")


def page() -> str:
    """The whole page."""
    keys, above = template()
    parts = [HEAD]
    for name, models in _tables(Study, ""):
        intro = above.get(name.replace("[]", ""), "") if not name.endswith("gauges[]") else ""
        shown = [model for model in models if model not in ELSEWHERE]
        bodies = [_table(list(_rows(name, model, keys))) for model in shown]
        if not any(bodies) and (not intro or not shown):
            continue
        title = "Top of the file" if not name else f"`[{name.replace('[]', '')}]`"
        if name.endswith("[]"):
            title = f"Each of `{name[:-2]}`"
        if name in BY_KEY:
            title, intro = f"Each of `{name}`", BY_KEY[name]
        parts += [f"## {title}", ""]
        parts += [f"{_prose(_sentence(intro))}\n"] if intro else []
        parts += [] if shown == models else [OWN_MESH, ""]
        parts += bodies
        if not name:
            parts += ["## `[sweep]` and `[rows]`", "", SWEEP, ""]
    return "\n".join(parts)


def _tables(model: type[BaseModel], prefix: str) -> Iterator[tuple[str, list[type[BaseModel]]]]:
    """Every table with the models that it may be, in the order of the schema."""
    yield prefix, [model]
    for name, field in model.model_fields.items():
        models = list(_models(field.annotation))
        if not models:
            continue
        many = any(get_origin(each) is tuple for each in _parts(field.annotation))
        full = f"{prefix}.{name}".lstrip(".") + ("[]" if many else "")
        yield full, models
        inner: dict[str, list[type[BaseModel]]] = {}
        for each in models:
            for place, found in list(_tables(each, full))[1:]:
                inner.setdefault(place, []).extend(x for x in found if x not in inner[place])
        yield from inner.items()


def _parts(annotation: Any) -> Iterator[Any]:
    """An annotation and all that it is made of, unions and marks apart."""
    yield annotation
    if get_origin(annotation) in (Annotated, Union, types.UnionType, tuple, dict):
        for each in get_args(annotation):
            yield from _parts(each)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    for each in _parts(annotation):
        if isinstance(each, type) and issubclass(each, BaseModel):
            yield each


def _table(rows: list[tuple[str, str, str, str]]) -> str:
    if not rows:
        return ""
    lines = ["| key | default | allowed | what it is |", "|---|---|---|---|"]
    return "\n".join([*lines, *(f"| {' | '.join(cells)} |" for cells in rows), ""])


def _rows(
    table: str, model: type[BaseModel], keys: dict[str, TemplateKey]
) -> Iterator[tuple[str, str, str, str]]:
    for name, field in model.model_fields.items():
        many = any(get_origin(each) is tuple for each in _parts(field.annotation))
        if (list(_models(field.annotation)) and not many) or (not table and name in SWEPT):
            continue
        key = f"{table}.{name}".lstrip(".")
        said = keys.get(key.replace("[]", ""), TemplateKey("", False, ""))
        yield f"`{name}`", _default(field, said), allowed(key, field), _what(field, said)


def _default(field: FieldInfo, said: TemplateKey) -> str:
    if said.active:
        return f"`{said.value}`"
    if field.is_required():
        return "must be given"
    if field.default is None or field.default in ((), {}) or field.default_factory is not None:
        return f"–, such as `{said.value}`" if said.value and len(said.value) < 60 else "–"
    value = field.default
    if isinstance(value, tuple):
        words = all(isinstance(each, str) for each in value)
        return f"`{json.dumps(value)}`" if words or not said.value else f"`{said.value}`"
    if isinstance(value, float) and _unit(field.description) == "m":
        return f'`"{_number(value, "m")}"`'
    return f"`{json.dumps(value)}`"


def allowed(key: str, field: FieldInfo) -> str:
    """What a key may be, in words."""
    if key in WORDS:
        return WORDS[key]
    unit = _unit(field.description)
    parts = [field.annotation, *list(_parts(field.annotation))]
    choices = [each for each in parts if get_origin(each) is Literal]
    if choices:
        return ", ".join(f'`"{choice}"`' for choice in get_args(choices[0]))
    if bool in parts:
        return "`true`, `false`"
    marks = list(_marks(field))
    if str in parts and not any(get_origin(each) is tuple for each in parts):
        return "text"
    for mark in marks:
        unit = unit or _unit(getattr(mark, "description", None))
    low = _bound(marks, "ge", "gt")
    high = _bound(marks, "le", "lt")
    kind = "whole number" if int in parts and float not in parts else "number"
    words = _between(low, high, unit) or "any"
    if any(get_origin(each) is tuple for each in parts):
        nested = sum(get_origin(each) is tuple for each in parts[1:]) > 1
        listed = "list of pairs" if nested else "list"
        return f"{listed}, {kind}s {words}"
    return f"{kind} {words}" if words != "any" or kind != "number" else "a number"


def _marks(field: FieldInfo) -> Iterator[Any]:
    """Every limit on a field or inside its annotation."""
    yield from field.metadata
    for each in _parts(field.annotation):
        if get_origin(each) is Annotated:
            for mark in each.__metadata__:
                yield mark
                yield from getattr(mark, "metadata", ())


def _bound(marks: list[Any], closed: str, opened: str) -> tuple[Any, bool] | None:
    for mark in marks:
        for name in (closed, opened):
            if getattr(mark, name, None) is not None and not isinstance(mark, FieldInfo):
                return getattr(mark, name), name == opened
    return None


def _between(low: tuple[Any, bool] | None, high: tuple[Any, bool] | None, unit: str) -> str:
    if low and high and not low[1] and not high[1]:
        return f"{_number(low[0], unit if unit == 'm' else '')} to {_number(high[0], unit)}"
    words = []
    if low:
        shown = _number(low[0], "" if high or low[0] == 0 else unit)
        words.append(f"{'>' if low[1] else '≥'} {shown}")
    if high:
        words.append(f"{'<' if high[1] else '≤'} {_number(high[0], unit)}")
    elif low and low[0] == 0 and unit:
        words.append(unit)
    return ", ".join(words)


def _number(value: float, unit: str = "") -> str:
    if unit == "m":
        value, unit = 1e3 * value, "mm"
    text = f"{value:,}" if isinstance(value, int) and abs(value) < 1e7 else f"{value:g}"
    return f"{text} {unit}".rstrip()


def _unit(description: str | None) -> str:
    found = re.search(r"\[([^\]\d,]+(?:\^\d+)?[^\],]*)\]$", description or "")
    return found[1] if found else ""


def _what(field: FieldInfo, said: TemplateKey) -> str:
    text = re.sub(r" \[[^\]]*\]$", "", field.description or "")
    comment = UNITS.sub("", said.comment)
    if not _words(comment) <= _words(text):
        text = comment if _words(text) <= _words(comment) else f"{text}: {comment}"
    return _prose(text.rstrip(":"))


def _words(text: str) -> set[str]:
    """What a text says, without small words and endings."""
    return {word[:5] for word in re.findall(r"[a-z]{4,}", text.lower())} - {"where", "with"}


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}".rstrip(".") + "."


def _prose(text: str) -> str:
    """Safe in a Markdown table; pages of docs become links."""
    text = text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")
    return re.sub(
        r"`vanelock manual ((?:\w+/)?(\w+))`",
        lambda it: f"[{it[2].replace('_', ' ')}]({it[1]}.md)",
        text,
    )


def main() -> None:
    """Bring the page up to date."""
    PAGE.write_text(page(), "utf-8")


if __name__ == "__main__":
    main()
