"""Which of the matrices in a file is meant: by its name, a customary one, or as the only one."""

from collections.abc import Sequence
from dataclasses import dataclass

from vanelock.common.errors import InputError

CUSTOMARY = {
    "stiffness": ("K", "stiffness", "stif", "Kr", "Kgg", "Kaa", "Kaax"),
    "mass": ("M", "mass", "Mr", "Mgg", "Maa", "Maax"),
    "damping": ("C", "damping", "damp", "B", "D", "Bgg", "Baa", "Baax"),
}
"""Names of the matrices, upper or lower case alike; Nastran's end in the set's letters."""


class NoMatrixError(InputError):
    """A file that was searched does not hold the matrix."""


@dataclass(frozen=True)
class WantedMatrix:
    """What is looked for in a file.

    Attributes
    ----------
    what : str
        "stiffness", "mass" or "damping".
    name : str or None
        The name that the user gives.
    alone : bool
        Whether a file's only matrix is the one, whatever its name.
    """

    what: str
    name: str | None = None
    alone: bool = True


def chosen(source: str, names: Sequence[str], wanted: WantedMatrix) -> str:
    """The name in the file of the matrix that is wanted."""
    if wanted.name is not None:
        same = [name for name in names if name == wanted.name]
        same = same or [name for name in names if name.lower() == wanted.name.lower()]
        if same:
            return same[0]
        raise NoMatrixError(f"{source}: no matrix {wanted.name!r}; it holds {_listed(names)}")
    for customary in CUSTOMARY[wanted.what]:
        found = [name for name in names if name.lower() == customary.lower()]
        if len(found) == 1:
            return found[0]
    if wanted.alone and len(names) == 1:
        return names[0]
    raise NoMatrixError(
        f"{source}: which is the {wanted.what} matrix? It holds {_listed(names)}: give the name"
    )


def refuse_unless_alone(source: str, wanted: WantedMatrix) -> None:
    """A format that holds one matrix holds no other besides."""
    if not wanted.alone:
        raise NoMatrixError(f"{source}: holds one matrix, no {wanted.what} besides")


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "no matrix"
    shown = ", ".join(ascii(name)[1:41].rstrip("'") for name in names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")
