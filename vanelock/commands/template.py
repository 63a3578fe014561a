"""The commented files that `vanelock init` writes: a study, or a scene of matrices."""

import os
import re
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

from vanelock.analyses import ANALYSES
from vanelock.common.checked import field_at, subject_and_unit
from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.input.schema.scene import Scene
from vanelock.input.schema.study import Study

FIRST = {
    "study": """name ring.sectors material.vane.E material.vane.rho mesh.size joints.hook.mu
        joints.hook.interference joints.interlock.kn joints.interlock.kt joints.interlock.mu
        joints.interlock.interference excitation.engine_order excitation.force damping.ratio
        response.mode response.harmonics response.range "joints.interlock.mu" """,
    "scene": """name components.lower.stiffness components.lower.mass components.lower.dofs
        components.lower.fixed components.upper.stiffness components.upper.mass
        components.upper.dofs contacts.lap.between contacts.lap.pairs contacts.lap.normal
        contacts.lap.tangent contacts.lap.kn contacts.lap.kt contacts.lap.mu
        contacts.lap.interference loads.component loads.nodes loads.direction loads.amplitude
        response.harmonics response.range""",
}
"""Keys that people set first; a swept one stands in quotes."""
HEAD = """\
# A vanelock {kind}: the keys to set first; `vanelock init {option}--all` writes every key. Numbers
# are in SI units, text may carry another: "0.05 mm". Run it with: vanelock run <this file>
"""
_TABLE = re.compile(r"(?:# )?\[\[?([\w.]+)\]\]?")
_KEY = re.compile(r'(?:# )?("[\w.]+"|\w+) = ')


def template_text(kind: str = "study", all_keys: bool = False) -> str:
    """The text of a commented file, "study" or "scene": the first keys to set, or every key."""
    text = files("vanelock.input.templates").joinpath(f"{kind}.toml").read_text("utf-8")
    if not all_keys:
        return _first_keys(text, kind)
    joint = "contacts.lap" if kind == "scene" else "joints.interlock"
    tables = [a.template for a in ANALYSES if kind == "study" or a.scene_keys is not None]
    return "\n".join([text, *(each.replace("JOINT", joint) for each in tables if each)])


def _first_keys(text: str, kind: str) -> str:
    """Tables and values of the first keys to set, with what they are and the unit."""
    keys, schema = FIRST[kind].split(), Scene if kind == "scene" else Study
    option = "--scene " if kind == "scene" else ""
    lines, table, above = [HEAD.format(kind=kind, option=option)], "", ""
    for line, following in pairwise(text.splitlines()):
        if found := _TABLE.match(line):
            table, above = found[1], f"\n{found[0]}"
        elif found := _KEY.match(line):
            key = found[1] if found[1][0] == '"' else f"{table}.{found[1]}".lstrip(".")
            if key not in keys:
                continue
            keys.remove(key)
            if above:
                lines.append(above)
                above = ""
            subject, unit = subject_and_unit(field_at(tuple(key.split(".")), schema), ("",))
            value, _, comment = line[found.end() :].partition(" # ")
            setting, comment = found[0] + value.rstrip(), comment or subject
            if following.startswith(" "):  # it goes on
                comment = comment[:-1] if comment.endswith(";") else subject
            if unit and '"' not in setting and unit not in comment:
                comment += f" [{unit}]"
            says_more = comment not in ("", found[1])
            lines.append(f"{setting:<31} # {comment}" if says_more else setting)
    return "\n".join(lines) + "\n"


def write_template(
    path: str | os.PathLike[str], kind: str = "study", all_keys: bool = False
) -> None:
    """Write it to a file that is not there yet.

    Raises
    ------
    InputError
        If the file exists or cannot be written.
    """
    if os.path.lexists(path):
        raise InputError(f"{path}: exists already; name another file")
    if not (folder := Path(path).parent).is_dir():
        raise InputError(f"{path}: cannot be written: {folder} is not a folder")
    with placed(path) as temporary:
        temporary.write_text(template_text(kind, all_keys), "utf-8")
