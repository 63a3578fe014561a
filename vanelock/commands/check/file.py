"""Check a file without computing: what a study or a scene would compute, what results hold."""

import os
from pathlib import Path

from vanelock.common.tables import Table, heads
from vanelock.common.toml import toml_tables
from vanelock.files import is_scene, read_text

_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def check_file(path: str | os.PathLike[str], outside: bool = False) -> Table:
    """Check a scene or study file, a results file or a run's folder, or a joined system.

    Parameters
    ----------
    path : path
        The file; a folder stands for the results in it.
    outside : bool
        Whether the files that it names may lie outside its folder.

    Returns
    -------
    Table
        What would be computed, or what is there.

    Raises
    ------
    InputError
        As running it, or comparing the results, would.
    """
    place = Path(path)
    if os.path.isdir(place) or _is_hdf5(place):
        from vanelock.commands.check.stored import stored

        rows, title = stored(place)
    elif is_scene(toml_tables(read_text(place), str(path))):
        from vanelock.commands.check.study import planned_scene
        from vanelock.files import load_scene

        rows = list(planned_scene(load_scene(place, outside)))
        title = f"{place}: a scene that can be run"
    else:
        from vanelock.commands.check.study import planned_study

        rows, title = list(planned_study(place, outside)), f"{place}: a study that can be run"
    return Table(title, heads("what", "found"), rows, key="check")


def _is_hdf5(path: Path) -> bool:
    """Whether a file is, by its first bytes or its ending, one of HDF5."""
    if path.suffix.lower() in (".h5", ".hdf5"):
        return True
    try:
        with path.open("rb") as file:
            return path.is_file() and file.read(8) == _SIGNATURE
    except (OSError, ValueError):
        return False
