"""Check a study without computing: its cases, parts, outputs, and what they will take."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vanelock.analyses import ANALYSES
from vanelock.commands.fit.parameters import varied_parameters
from vanelock.common.errors import raised
from vanelock.common.tables import counted
from vanelock.files import load_study
from vanelock.input.cases.sweep import Case, cases
from vanelock.input.measured.curve import Measured, curve_mistakes, load_measured
from vanelock.input.schema.structure.own_mesh import OwnCasing, OwnVane, refuse_without_areas
from vanelock.input.schema.study import Study
from vanelock.input.settings import unusual
from vanelock.mesh.element_size import element_size, words_of
from vanelock.stages.accuracy.budget import SOURCES, pins
from vanelock.stages.cost_estimate import estimated
from vanelock.stages.parts.load_lines import load_lines

if TYPE_CHECKING:
    from vanelock.mesh import Part
    from vanelock.pipeline.step import Step

Row = tuple[str, str]


def planned_study(path: Path, outside: bool) -> Iterator[Row]:
    """What a study would compute, by rows."""
    study = load_study(path, outside, _of_curves)
    found = cases(study)
    yield "name", study.name
    swept = ", ".join(found[0].values)
    yield "cases", f"{len(found):,} over {swept}" if swept else "1"
    if any(case.study.accuracy is not None for case in found):
        yield "accuracy", "; ".join(dict.fromkeys(_accuracy(case.study) for case in found))
    yield from (("warning", text) for text in unusual(study))
    meshes = _own_meshes([case.study for case in found])
    yield from _parts(found, meshes)
    loaded = getattr(found[0].study.casing, "force_nodes", None)
    yield from (("load", text) for text in load_lines(found[0].study, loaded))
    dofs = {name: 3 * len(part.points) for name, part in meshes.items()}
    needed = estimated(found, mesh_dofs=dofs, analyses=ANALYSES)
    if needed is not None:
        yield from ((what, f"about {value}") for what, value in needed.words().items())
        yield from [("warning", needed.warning)] if needed.warning else []
    yield from of_curves(load_measured(study))
    for table, varied in (("fit", study.fit), ("optimise", study.optimise)):
        if varied is not None:
            names = ", ".join(each.key for each in varied_parameters(study, table))
            yield table, f"{names} from {counted(varied.starts, 'start')}"
    yield "outputs", ", ".join(_outputs(study))


def of_curves(curves: Iterable[Measured]) -> Iterator[Row]:
    """Measured curves, a row each."""
    for curve in curves:
        points = counted(len(curve.frequency), "point")
        yield "measured", f"{curve.label}: {points} of {curve.quantity}"


def _of_curves(study: Study) -> list[str]:
    """What is wrong with the files of measured curves, and with the fit to them."""
    found = curve_mistakes(study)
    if study.fit is not None and not found:
        found += raised(lambda: varied_parameters(study, "fit"))
    if study.optimise is not None:
        found += raised(lambda: varied_parameters(study, "optimise"))
    return found


def _parts(cases: tuple[Case, ...], meshes: "dict[str, Part]") -> Iterator[Row]:
    """Sizes of the parts, a user's own meshes among them."""
    for name in ("vane", "casing"):
        if (part := meshes.get(name)) is not None:
            sets = ", ".join(f"{key} {len(nodes)}" for key, nodes in part.node_sets.items())
            size = f"{len(part.points):,} nodes, {len(part.cells):,} {part.cell_type}"
            yield name, f"{size}; {sets}"
        else:
            sizes = dict.fromkeys(_elements(case.study, name) for case in cases)
            yield name, f"from dimensions, elements {', '.join(sizes)}"


def _own_meshes(studies: Sequence[Study]) -> "dict[str, Part]":
    """A user's meshes in the first of some studies; the others' are read and matched, too."""
    kinds = {"vane": OwnVane, "casing": OwnCasing}
    own = [name for name, kind in kinds.items() if isinstance(getattr(studies[0], name), kind)]
    if not own:
        return {}
    from vanelock.stages.parts.components import PARTS, mesh_step

    made: dict[str, Any] = {}

    def product(step: "Step[Any]") -> Any:
        if step.key not in made:
            made[step.key] = step.compute(*map(product, step.needs))
        return made[step.key]

    first: dict[str, Part] = {}
    for study in studies:
        parts = {name: product(mesh_step(study, name)) for name in PARTS}
        first = first or parts
        if isinstance(study.vane, OwnVane):
            refuse_without_areas(study, parts["vane"])
    return {name: first[name] for name in own}


def _accuracy(study: Study) -> str:
    """The error that is asked for, and what is chosen for it."""
    if study.accuracy is None:
        return "as given"
    chosen = [source for source in SOURCES if source not in pins(study)]
    text = f"an error of {100 * study.accuracy:g} %"
    return f"{text}: the run chooses {', '.join(chosen)}" if chosen else f"{text} is estimated"


def _elements(study: Study, part: str) -> str:
    """The size of a part's elements, or what it is chosen for."""
    if study.accuracy is not None and "mesh" not in pins(study):
        return f"chosen for an error of {100 * study.accuracy:g} %"
    size = study.mesh.size
    return size if isinstance(size, str) else words_of(element_size(size, part))


def _outputs(study: Study) -> Iterator[str]:
    yield "results.h5"
    yield "figures"
    wanted = study.outputs
    chosen = {
        **{name: name in wanted.show for name in ("shapes", "loops", "animations")},
        counted(len(wanted.gauges), "gauge"): bool(wanted.gauges),
        **{each.title: each.keys_of(study) is not None for each in ANALYSES},
        "Campbell diagram": study.campbell is not None,
        "report.html": "report" in wanted.show,
    }
    yield from (name for name, there in chosen.items() if there)
