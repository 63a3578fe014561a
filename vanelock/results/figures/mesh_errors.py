"""Where a user's own meshes have their error: a picture and a table."""

from pathlib import Path

from vanelock import render
from vanelock.quantities.run_result import RunResult
from vanelock.report import Picture
from vanelock.stages.accuracy.error_places import of_own_meshes
from vanelock.stages.plan import Planned


def mesh_errors(run: RunResult, each: Planned) -> list[Picture]:
    """The picture of a case, where a part of it is an own mesh."""
    step = of_own_meshes(each)
    if step is None:
        return []
    study = each.case.study
    limits = run.stages.get(each.linear.limits)
    title = f"Where the meshes err in the mode of interest, {limits.stuck_frequency:.2f} Hz"
    subtitle = f"{study.name}. What elements add to its stiffness, by their own estimate."
    shows = [step.key, title, study.name]

    def picture(path: Path) -> None:
        found = run.stages.get(step)
        densities = found.vane, found.casing
        render.mesh_error_picture(path, run.parts(each), densities, title, subtitle)

    table = run.stages.get(step).table
    caption = (
        "What each element adds to the stiffness of the mode of interest, by its own estimate: "
        "elements are best made smaller where colours are dark. The table lists the worst places."
    )
    own = shows, picture, table.by_head, table.lines
    return [run.picture("figures/mesh_error", title, *own, caption)]
