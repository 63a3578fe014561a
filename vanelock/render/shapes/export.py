"""Shapes as `.vtu` files, which ParaView opens."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus

Data = dict[str, NDArray[np.float64] | NDArray[np.int32]]


def write_vtu(
    path: style.PathLike,
    part: Part,
    shape: NDArray[np.complex128] | None = None,
    fields: Mapping[str, NDArray[np.float64]] | None = None,
    unit: str = "m",
) -> Path:
    """Write a part with its node sets and, if given, a shape or fields, and return the path.

    Parameters
    ----------
    path : path
        File to write, named `.vtu`.
    part : Part
        Becomes points (m) and elements; each node set becomes point data of its name, the place 1,
        2, ... in the set at its nodes and 0 elsewhere, from which `mesh.read_mesh` reads it back.
    shape : (n, 3) complex, optional
        Becomes the point data `displacement_real (m)`, `displacement_imag (m)` (Cartesian),
        `amplitude (m)` (largest length in a cycle) and `phase_radial (deg)`. ParaView's "Warp By
        Vector" on the first two deforms the part at the instants 0 and a quarter period before.
    fields : mapping of str to (n,) or (n, k) float, optional
        Point data by their names, which have the unit.
    unit : str
        Of the shape.

    Raises
    ------
    InputError
        If the shape or a field does not fit the part, or the file cannot be written.
    """
    data: Data = {}
    if shape is not None:
        _fits(part, shape)
        data |= _moving(part.points, shape, unit)
    for name, values in (fields or {}).items():
        if len(values) != len(part.points):
            given = f"{part.name}: {name} of {len(values)} nodes"
            raise InputError(f"{given}: the part has {len(part.points)}")
        data[name] = np.asarray(values, float)
    for name, nodes in part.node_sets.items():
        place = np.zeros(len(part.points), np.int32)
        place[nodes] = np.arange(1, len(nodes) + 1)
        data[name] = place
    return _written(path, part.points, part.cell_type, part.cells, data)


def _written(
    path: style.PathLike, points: Floats, cell_type: str, cells: NDArray[np.int64], data: Data
) -> Path:
    """The file, whole or not at all."""
    import meshio

    target = Path(path)
    mesh = meshio.Mesh(points, [(cell_type, cells)], point_data=data)
    with placed(target) as temporary:
        mesh.write(temporary, file_format="vtu")
    return target


def _fits(part: Part, shape: NDArray[np.complex128]) -> None:
    if np.shape(shape) != part.points.shape:
        wanted = part.points.shape
        raise InputError(f"{part.name}: shape of {np.shape(shape)}: {wanted} is needed")


def _moving(points: Floats, shape: NDArray[np.complex128], unit: str) -> Data:
    """Point data of a shape."""
    radial = annulus.cylindrical(points, shape)[:, 0]
    return {
        f"displacement_real ({unit})": np.real(shape).astype(float),
        f"displacement_imag ({unit})": np.imag(shape).astype(float),
        f"amplitude ({unit})": annulus.peak(shape),
        "phase_radial (deg)": np.degrees(np.angle(radial)),
    }
