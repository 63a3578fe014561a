"""Read a part's mesh from a file, by the reader of its format."""

import os
from pathlib import Path

from vanelock.common.errors import InputError
from vanelock.common.files.files import regular
from vanelock.common.quantities import si
from vanelock.mesh.files.ansys_archive import ARCHIVE, read_archive
from vanelock.mesh.files.decks.abaqus import read_abaqus
from vanelock.mesh.files.decks.nastran import read_nastran
from vanelock.mesh.files.meshio_files import FORMATS, read_exchange
from vanelock.mesh.files.raw import FileMesh
from vanelock.mesh.files.solids import solid_mesh

DECKS = {
    ".inp": read_abaqus,
    ".bdf": read_nastran,
    ".nas": read_nastran,
    ".dat": read_nastran,
    ".fem": read_nastran,
}
LARGEST = 1 << 30
"""Bytes of the largest file that is read: a mesh at the limit of its nodes has a tenth of that."""


def read_mesh(path: str | os.PathLike[str], unit: str = "m") -> FileMesh:
    """Read a mesh of solid elements with its sets.

    Parameters
    ----------
    path : path
        Abaqus or CalculiX deck (.inp), Nastran bulk data (.bdf, .nas, .dat, .fem), Ansys archive
        (.cdb), Gmsh (.msh) or VTK (.vtu, .vtk).
    unit : str
        Of its coordinates, such as "mm".

    Returns
    -------
    FileMesh
        Tetrahedra or hexahedra, with the file's numbers of nodes and elements.

    Raises
    ------
    InputError
        One line with the file's name: it cannot be read, is malformed, or its elements cannot be
        used.
    """
    path, source = Path(path), str(path)
    factor = metres(unit)
    try:
        if (size := regular(path, "a mesh file")) > LARGEST:
            raise InputError(f"{source}: {size:,} bytes: at most {LARGEST:,} are read")
        ending = path.suffix.lower()
        deck = DECKS.get(ending)
        if deck is None:
            if ending == ARCHIVE:
                return solid_mesh(read_archive(source, path), factor)
            if ending not in FORMATS:
                allowed = ", ".join((*DECKS, ARCHIVE, *FORMATS))
                raise InputError(f"{source}: no mesh format that is read; allowed are {allowed}")
            return solid_mesh(read_exchange(source, path), factor)
        text = path.read_bytes().decode("utf-8-sig", "replace")
    except OSError as error:
        raise InputError(f"{source}: cannot be read: {error.strerror or error}") from None
    if "\0" in text:
        raise InputError(f"{source}: not a text file")
    return solid_mesh(deck(source, text), factor)


def metres(unit: str) -> float:
    """Metres in one unit of length."""
    try:
        factor = si(f"1 {unit}", "m")
    except ValueError:
        factor = None
    if not isinstance(factor, float) or not 1e-9 <= factor <= 1e6:
        raise InputError(f'unit = "{unit}": expected a unit of length, such as "mm"')
    return factor
