"""One period of a vibration as files of instants, which ParaView plays.

The `.pvd` file lists the `.vtu` files with their times; both are XML formats of VTK's.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.mesh import Part
from vanelock.render import style

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def at_instant(harmonics: Mapping[int, Complex], angle: float) -> Real:
    """Re Σ_h q_h e^{ihα} of some harmonics, (nodes, k), at the phase angle α in rad."""
    terms = [np.real(q * np.exp(1j * h * angle)) for h, q in harmonics.items()]
    total: Real = np.sum(terms, axis=0)
    return total


def write_step(path: style.PathLike, part: Part, fields: Mapping[str, Real]) -> Path:
    """Write a part at an instant as `.vtu`, in single precision, and return the path.

    Parameters
    ----------
    path : path
        File to write.
    part : Part
        Becomes points (m) and elements.
    fields : mapping of str to (n,) or (n, 3) float
        Point data by name.

    Raises
    ------
    InputError
        If a field does not fit the part, or the file cannot be written.
    """
    import meshio

    for name, values in fields.items():
        if len(values) != len(part.points):
            given = f"{part.name}: {name} of {len(values)} nodes"
            raise InputError(f"{given}: the part has {len(part.points)}")
    data = {name: np.asarray(values, np.float32) for name, values in fields.items()}
    cells = [(part.cell_type, part.cells.astype(np.int32))]
    mesh = meshio.Mesh(part.points.astype(np.float32), cells, point_data=data)
    target = Path(path)
    with placed(target) as temporary:
        mesh.write(temporary, file_format="vtu")
    return target


def write_pvd(
    path: style.PathLike, times: Sequence[float], files: Sequence[Sequence[style.PathLike]]
) -> Path:
    """Write the list of the instants' files, and return the path.

    Parameters
    ----------
    path : path
        File to write, named `.pvd`.
    times : sequence of float
        Of the instants, s.
    files : sequence of sequence of path
        One for each part at each instant; given relative to the list, so that the folder can move.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    target = Path(path)
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for time, parts in zip(times, files, strict=True):
        for i, file in enumerate(parts):
            place = Path(os.path.relpath(file, target.parent)).as_posix()
            ElementTree.SubElement(
                collection, "DataSet", timestep=repr(float(time)), part=str(i), file=place
            )
    ElementTree.indent(root)
    with placed(target) as temporary:
        ElementTree.ElementTree(root).write(temporary, "utf-8", xml_declaration=True)
    return target
