"""A field over a part's surface from a CSV file of points, such as a flow's pressure.

    x (mm), y (mm), z (mm), pressure (kPa)

The first line that is not blank and does not begin with # names the columns, in whatever order and
with units, of which SI is meant where there is none. Between points: the mean of the nearest, the
nearer the more (D. Shepard, A two-dimensional interpolation function for irregularly-spaced data,
Proceedings of the 23rd ACM National Conference 1968, 517-524).
"""

from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from vanelock.common.arrays import Floats
from vanelock.common.errors import InputError
from vanelock.common.files.csv_table import rows_of_cells
from vanelock.common.files.files import contents
from vanelock.common.quantities import si

_NEAREST = 4  # points whose mean is taken
_FAR = 0.1  # distance of a node from the nearest point, over the nodes' extent, that is refused


def nodal_field(path: Path, name: str, unit: str, places: Floats) -> Floats:
    """Values of a field at nodes."""
    columns = {"x": "m", "y": "m", "z": "m", name: unit}
    table = _numbers(path, columns)
    points, values = table[:, :3], table[:, 3]
    distance, near = KDTree(points).query(places, min(_NEAREST, len(points)))
    distance, near = (np.reshape(each, (len(places), -1)) for each in (distance, near))
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    if (worst := int(np.argmax(distance[:, 0]))) >= 0 and distance[worst, 0] > _FAR * extent:
        where = ", ".join(f"{1e3 * each:.4g}" for each in places[worst])
        raise InputError(
            f"{path}: the node at {where} mm lies {1e3 * distance[worst, 0]:.3g} mm from the "
            "nearest point: are the units and axes those of the mesh?"
        )
    weight = 1 / np.maximum(distance, 1e-9 * (extent or 1.0)) ** 2
    return np.asarray((weight * values[near]).sum(axis=1) / weight.sum(axis=1))


def _numbers(path: Path, columns: dict[str, str]) -> Floats:
    """(p, len(columns)) numbers of the columns, in their units."""
    try:
        text = contents(path, "a CSV file").decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None
    lines = rows_of_cells(text)
    if len(lines) < 2:
        raise InputError(f"{path}: needs a line of names and one of numbers at least")
    (number, heads), *rows = lines
    where, scales = f"{path}: line {number}", []
    named = [head.replace("[", "(").partition("(") for head in heads]
    names = [each[0].strip().lower() for each in named]
    for name, unit in columns.items():
        if names.count(name) != 1:
            needed = ", ".join(f"{each} ({own})" for each, own in columns.items())
            raise InputError(f"{where}: {names.count(name)} columns {name}: needed are {needed}")
        given = named[names.index(name)][2].rstrip("]) ") or unit
        try:
            of = [n if given == unit else si(f"{n} {given}", unit) for n in (0, 1)]
        except ValueError:
            raise InputError(f"{where}: {name} ({given}): not a unit like {unit}") from None
        scales.append(np.array(of, float))
    order = [names.index(name) for name in columns]
    numbers = np.empty((len(rows), len(order)))
    for k, (i, row) in enumerate(rows):
        try:
            numbers[k] = [float(row[j]) for j in order]
        except (ValueError, IndexError):
            raise InputError(f"{path}: line {i}: needs a number in each column") from None
    if not np.isfinite(numbers).all():
        bad = rows[int(np.flatnonzero(~np.isfinite(numbers).all(axis=1))[0])][0]
        raise InputError(f"{path}: line {bad}: numbers must be finite")
    none, one = np.array(scales).T
    return np.asarray(numbers * (one - none) + none)
