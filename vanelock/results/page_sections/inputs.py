"""The inputs of a run on its page: what differs from the defaults first, then everything."""

from collections.abc import Iterator, Sequence

from vanelock.common.tables import Table, heads
from vanelock.input.cases.values import Given
from vanelock.input.schema.distributions import Distribution
from vanelock.input.schema.structure.loads import grows
from vanelock.input.schema.study import Study
from vanelock.input.settings import SCATTERING, Setting, as_text, meaning, settings
from vanelock.report import Section, Text
from vanelock.stages.parts.temperatures import described

MAIN = (
    "ring.sectors",
    "vane.aerofoils",
    "vane.mesh",
    "casing.mesh",
    "material.vane.E",
    "material.casing.E",
    "mesh.size",
    "response.friction",
    "joints.hook.kn",
    "joints.hook.kt",
    "joints.hook.mu",
    "joints.hook.interference",
    "joints.interlock",
    "joints.interlock.kn",
    "joints.interlock.kt",
    "joints.interlock.mu",
    "joints.interlock.interference",
    "excitation.engine_order",
    "excitation.force",
    "excitation.unbalance",
    "damping.ratio",
    "response.mode",
    "response.harmonics",
    "response.coupling",
)
"""Keys that a reader wants to know whether or not they are the defaults."""
APART = ("name", "outputs.")
"""Keys that change nothing that is computed."""
VARIED = ("sweep.", "rows.", SCATTERING)
"""What cases differ in, which has tables of its own."""
VALUE = heads("key", "what it is", "value")


def inputs(given: Given, cases: Sequence[Given] = ()) -> Section:
    """What a study or scene sets; the `cases` know the temperatures of their responses."""
    if not isinstance(given, Study):
        found = [each for each in settings(given) if not each.key.startswith(VARIED)]
        varied = (*given.sweep, *given.rows, *(given.scatter.keys if given.scatter else ()))
        apart = (*APART, *varied)
        chosen = [each for each in found if each.changed and not each.key.startswith(apart)]
        set_so = Table("Set differently from defaults", VALUE, _rows(chosen))
        return Section("Inputs", [*_varied(given), set_so])
    return _of_study(given, [each for each in cases if isinstance(each, Study)])


def _of_study(study: Study, cases: Sequence[Study]) -> Section:
    found = [each for each in settings(study) if not each.key.startswith(VARIED)]
    changed = [each for each in found if each.changed and not each.key.startswith(APART)]
    blocks: list[Text | Table] = list(_varied(study))
    varied = {*study.sweep, *study.rows, *(study.scatter.keys if study.scatter else ())}
    if changed:
        blocks.append(
            Table(
                "Set differently from the defaults",
                heads("key", "what it is", "this study", "default"),
                _rows(changed, with_default=True),
            )
        )
    else:
        blocks.append(Text("Nothing else differs from the defaults."))
    plain = study.model_dump(mode="json")
    main = [e for e in found if e.key in MAIN and e.value is not None and e.key not in varied]
    if plain["excitation"]["unbalance"] is None:
        force = Setting("excitation.force", study.excitation.force_per_node, None)
        main = [force if e.key == force.key else e for e in main]
        if force.key not in (e.key for e in main) and force.key not in varied:
            main.append(force)
    note = (
        "Strengths at their defaults are assumptions, not data of a material. All settings stand "
        "at the end of the page."
    )
    blocks.append(Table("Main inputs", VALUE, _rows(main), (note,)))
    heated = [text for text in dict.fromkeys(described(case) for case in cases) if text]
    if heated:
        acts = (
            "Temperature acts through Young's modulus and as the growth of the vane against the "
            "casing, a load at rest; softer contacts are left out."
            if any(map(grows, cases))
            else "Temperature acts through Young's modulus alone: thermal expansion, the stresses "
            "that it causes and softer contacts are left out."
        )
        blocks.append(Text(f"{_sentence('; '.join(heated))}. {acts}"))
    return Section("Inputs", blocks)


def _varied(given: Given) -> Iterator[Table]:
    """What cases differ in."""
    kinds = (
        ("sweep", given.sweep, "Swept: each case has one of the values"),
        ("rows", given.rows, "Varied together: a case has the values of one place in all lists"),
    )
    for name, lists, caption in kinds:
        rows = [
            (key, meaning(key, type(given)), as_text(f"{name}.{key}", list(values), type(given)))
            for key, values in lists.items()
        ]
        if rows:
            yield Table(caption, heads("key", "what it is", "values"), rows)
    if given.scatter is not None:
        caption = f"Scattering: {given.scatter.samples:,} samples of a Latin hypercube"
        rows = [
            (key, meaning(key, type(given)), _distribution(key, each, type(given)))
            for key, each in given.scatter.keys.items()
        ]
        yield Table(caption, heads("key", "what it is", "distribution"), rows)


def _distribution(key: str, given: Distribution, schema: type[Given]) -> str:
    """How a key scatters, in words."""
    law, pair = given.law
    names = ("low", "high") if law == "uniform" else ("mean", "deviation")
    numbers = [*zip(names, pair, strict=True)]
    if given.within is not None:
        numbers += zip(("cut below", "cut above"), given.within, strict=True)
    words = (
        f"{name} {value if isinstance(value, str) else as_text(key, value, schema)}"
        for name, value in numbers
    )
    return ", ".join([law, *words])


def all_inputs(given: Given) -> Section:
    """Every key, defaults included."""
    found = [each for each in settings(given) if not each.key.startswith("sweep.")]
    return Section("All settings", [Table("Every key", VALUE, _rows(found), folded=True)])


def _rows(found: Sequence[Setting], with_default: bool = False) -> list[tuple[str, ...]]:
    rows = []
    for each in found:
        row: tuple[str, ...] = (each.key, each.meaning, as_text(each.key, each.value, each.schema))
        rows.append((*row, as_text(each.key, each.default, each.schema)) if with_default else row)
    return rows


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]
