"""Where a user's own meshes have their error: a picture and a table."""

from pathlib import Path

from vanelock import render
from vanelock.quantities.curves_and_fields import RunData
from vanelock.report import Picture
from vanelock.stages.accuracy.error_places import of_own_meshes
from vanelock.stages.plan import Planned


def mesh_errors(run_data: RunData, each: Planned) -> list[Picture]:
    """The picture of a case, where a part of it is an own mesh."""
    step = of_own_meshes(each)
    if step is None:
        return []
    study = each.case.study
    limits = run_data.stages.get(each.linear.limits)
    title = f"Where the meshes err in the mode of interest, {limits.stuck_frequency:.2f} Hz"
    subtitle = f"{study.name}. What elements add to its stiffness, by their own estimate."
    shows = [step.key, title, study.name]

    def picture(path: Path) -> None:
        found = run_data.stages.get(step)
        densities = found.vane, found.casing
        render.mesh_error_picture(path, run_data.parts(each), densities, title, subtitle)

    path = run_data.output_files.draw("figures/mesh_error.png", shows, picture)
    table = run_data.stages.get(step).table
    data = run_data.table("figures/mesh_error.csv", shows, table.by_head, table.lines)
    caption = (
        "What each element adds to the stiffness of the mode of interest, by its own estimate: "
        "elements are best made smaller where colours are dark. The table lists the worst places."
    )
    return [Picture(path, title, caption, (data,))]
