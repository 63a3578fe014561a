"""Shapes as `.vtu` files, which ParaView opens."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.mesh import Part
from vanelock.render import style
from vanelock.render.scenes import annulus


def write_vtu(
    path: style.PathLike,
    part: Part,
    shape: NDArray[np.complex128] | None = None,
    fields: Mapping[str, NDArray[np.float64]] | None = None,
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
        Becomes the point data `displacement_real`, `displacement_imag` (Cartesian, in the shape's
        unit), `amplitude` (largest length in a cycle) and `phase_radial` (degrees). ParaView's
        "Warp By Vector" on the first two deforms the part at the instants 0 and a quarter period
        before.
    fields : mapping of str to (n,) or (n, k) float, optional
        Point data by their names.

    Raises
    ------
    InputError
        If the shape or a field does not fit the part, or the file cannot be written.
    """
    import meshio

    target = Path(path)
    data: dict[str, NDArray[np.float64] | NDArray[np.int32]] = {}
    if shape is not None:
        if np.shape(shape) != part.points.shape:
            wanted = part.points.shape
            raise InputError(f"{part.name}: shape of {np.shape(shape)}: {wanted} is needed")
        radial = annulus.cylindrical(part.points, shape)[:, 0]
        data["displacement_real"] = np.real(shape).astype(float)
        data["displacement_imag"] = np.imag(shape).astype(float)
        data["amplitude"] = annulus.peak(shape)
        data["phase_radial"] = np.degrees(np.angle(radial))
    for name, values in (fields or {}).items():
        if len(values) != len(part.points):
            given = f"{part.name}: {name} of {len(values)} nodes"
            raise InputError(f"{given}: the part has {len(part.points)}")
        data[name] = np.asarray(values, float)
    for name, nodes in part.node_sets.items():
        place = np.zeros(len(part.points), np.int32)
        place[nodes] = np.arange(1, len(nodes) + 1)
        data[name] = place
    mesh = meshio.Mesh(part.points, [(part.cell_type, part.cells)], point_data=data)
    with placed(target) as temporary:
        mesh.write(temporary, file_format="vtu")
    return target
