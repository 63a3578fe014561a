"""What interference and static loads do to the contacts, before anything vibrates."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vanelock import nonlinear, render
from vanelock.input.cases.names import of_case, slug, words
from vanelock.nonlinear import Response
from vanelock.quantities.run_result import RunResult
from vanelock.quantities.selection import DETAILED, named
from vanelock.report import Picture
from vanelock.stages.parts.places import tangents
from vanelock.stages.plan import Planned


def preloads(run: RunResult) -> list[Picture]:
    """One for each distinct preload."""
    found: dict[str, Picture] = {}
    distinct = {each.preload.key for each in run.planned}
    get = run.stages.get
    every = [each for each in run.planned if get(each.system).contacts.springs.any()]
    for each in every if len(distinct) <= DETAILED else named(run):
        if each.preload.key not in found:
            found[each.preload.key] = _preload(run, each)
    return list(found.values())


def _preload(run: RunResult, each: Planned) -> Picture:
    static = run.stages.get(each.preload)
    joints = run.stages.get(each.system).contacts.joints
    name = each.preload_name
    suffix = f"_{slug(name)}" if name else ""
    shows = [each.preload.key, name]
    names = {joint: tangents(run.given, joint) for joint in joints}
    caption = (
        f"Contact forces at rest, nothing vibrating{of_case(name)}. Above: normal force "
        "of each contact of a sector. Below: friction over its bound, |t| / (μ n): 1 where the "
        "contact slid while the parts were assembled. An open contact carries nothing and cannot "
        "damp; the spread of the normal forces shows how unevenly a joint will slip."
    )
    return run.picture(
        f"figures/preload{suffix}",
        "Preload of the contacts",
        shows,
        lambda path: picture(path, static, joints, words(name)),
        lambda: columns(static, joints, names),
        (),
        caption,
    )


def picture(path: Path, static: Response, joints: tuple[str, ...], subtitle: str) -> None:
    """Draw the forces of a state at rest."""
    render.preload_picture(
        path,
        static.force[0, 0].real,
        static.mu,
        joints,
        subtitle=subtitle,
        opened=static.state[0] == nonlinear.OPEN,
        isotropic=static.friction == "isotropic",
    )


def columns(
    static: Response, joints: tuple[str, ...], names: Mapping[str, tuple[str, str]]
) -> Mapping[str, ArrayLike]:
    """Contact by contact: joint, number in its joint, state, forces in directions with names."""
    force = static.force[0, 0].real
    states = np.array(["sticks", "slid at assembly", "open"])
    opened = static.state[0] == nonlinear.OPEN
    used = render.utilisation(
        np.where(opened[:, None], 0.0, force), static.mu, static.friction == "isotropic"
    )
    slid = np.nan_to_num(used) >= 1 - 1e-6
    return {
        "joint": joints,
        "contact": numbers(joints),
        "state": states[np.where(opened, 2, np.where(slid, 1, 0))],
        "normal force n (N)": force[:, 0],
        "direction 1": [names[joint][0] for joint in joints],
        "friction force 1 (N)": force[:, 1],
        "direction 2": [names[joint][1] for joint in joints],
        "friction force 2 (N)": force[:, 2],
        "friction coefficient mu (-)": static.mu,
        "friction utilisation |t| / (mu n) (-)": used,
    }


def numbers(joints: tuple[str, ...]) -> list[int]:
    """Each contact's number in its joint, from 1, as pictures and tables count."""
    return [joints[: i + 1].count(joint) for i, joint in enumerate(joints)]
