"""Stiffness, mass and damping of a component, from the files that another program wrote.

Which reader a file is for is seen by its ending and its first bytes.

The numbers come in any units. A displacement is u = s q with s metres in its unit of length; a
rotation is in radians, s = 1.
Energy is the same in both, so K_ij becomes K_ij F L / (s_i s_j), and M_ij becomes
M_ij m L² / (s_i s_j). Time is what makes them consistent, T² = m L / F. A generalised coordinate
has the unit L √m, with s to match: one normalised to unit mass stays so.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from vanelock.common.arrays import Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.files.files import PathLike
from vanelock.common.quantities import si
from vanelock.fem.matrix_files.contents import Entries, NoMatrixError, WantedMatrix, assembled
from vanelock.fem.matrix_files.model import GENERALISED, Matrices
from vanelock.fem.matrix_files.tables import Labels, check_labels, load_pairs, named, read_labels

_Reader = Callable[[Path, WantedMatrix], Entries]

_READERS = {
    ".mtx": ("decks", "read_mtx"),
    **dict.fromkeys((".mm", ".mmf"), ("sparse_text", "read_market")),
    **dict.fromkeys((".hb", ".rb", ".rsa", ".matrix"), ("sparse_text", "read_harwell")),
    **dict.fromkeys((".pch", ".dmig", ".bdf", ".dat"), ("decks", "read_dmig")),
    **dict.fromkeys((".h5", ".hdf5"), ("array_files", "read_hdf5")),
    ".mat": ("array_files", "read_mat"),
    ".full": ("ansys_full", "read_full"),
    ".npy": ("array_files", "read_npy"),
    ".npz": ("array_files", "read_npz"),
}
"""Module and function by ending, without .gz."""
_SEVERAL = {
    ".npz", ".mat", ".h5", ".hdf5", ".full", ".pch", ".dmig", ".bdf", ".dat", ".mtx"
}  # fmt: skip
"""Endings of files that may hold several matrices."""


def _ending(path: Path) -> str:
    """A file's ending, without .gz and without a path into an HDF5 file."""
    name = re.sub(r"(\.h5|\.hdf5|\.mat):.*", r"\1", str(path).lower()).removesuffix(".gz")
    name = name.rpartition("/")[2]
    return "." + name.rpartition(".")[2] if "." in name else ""


def _read_entries(path: Path, request: WantedMatrix) -> Entries:
    """Read the matrix that is wanted from a file."""
    found = _READERS.get(_ending(path))
    if found is None:
        known = " ".join(sorted(_READERS))
        raise InputError(f"{path}: matrices are read from files that end in {known}")
    module, function = found
    reader: _Reader = getattr(import_module(f"vanelock.fem.matrix_files.{module}"), function)
    return reader(path, request)


_BALANCED = 1e-3
"""Sum of a row's entries along one direction, over that of their moduli, below which it is none."""


def _check_mass(source: str, M: sp.csc_array, node: Integers, direction: Integers) -> None:
    """Refuse a matrix that is no mass.

    A row's entries along a direction add up to the inertia that it has as all moves that way. Those
    of a stiffness add up to the force that does so: none, but where the part is held.
    """
    own = M.diagonal().real
    if own.size and own.min() < 0:
        k = int(np.argmin(own))
        raise InputError(
            f"{source}: node {node[k]}, direction {named(int(direction[k]))}: the mass on the "
            f"diagonal is {own[k]:.3g}: it must be >= 0"
        )
    rows = balanced = 0
    for axis in range(3):
        along = np.flatnonzero(direction == axis)
        block = M[:, along].tocsr()[along]
        size = abs(block).sum(axis=1)
        rows += int(np.count_nonzero(size))
        balanced += int(np.sum(abs(block.sum(axis=1))[size > 0] < _BALANCED * size[size > 0]))
    if rows and balanced > rows / 2:
        raise InputError(
            f"{source}: most of its rows add up to nothing along each direction, as those of a "
            "stiffness do: are stiffness and mass swapped?"
        )


@dataclass(frozen=True)
class _Units:
    """SI units in one of the program's."""

    length: float = 1.0  # m
    mass: float = 1.0  # kg
    force: float = 1.0  # N

    def scales(self, direction: Integers) -> Floats:
        """(n,) s of each row."""
        of_rotation = np.where(direction < 3, self.length, 1.0)
        return np.where(direction == GENERALISED, self.length * self.mass**0.5, of_rotation)

    def converted(self, matrix: sp.csc_array, what: str, direction: Integers) -> sp.csc_array:
        """The matrix "stiffness", "mass" or "damping" in SI units."""
        if self == _Units():
            return matrix
        energy = {
            "stiffness": self.force * self.length,
            "mass": self.mass * self.length**2,
            "damping": (self.force * self.mass * self.length**3) ** 0.5,
        }[what]
        scale = sp.diags_array(1 / self.scales(direction))
        return (scale @ matrix @ scale * energy).tocsc()


def _units(length: str, mass: str, force: str) -> _Units:
    """Units by name, such as "mm", "t" and "N"."""
    return _Units(
        _in_si("length", length, "m"), _in_si("mass_unit", mass, "kg"), _in_si("force", force, "N")
    )


def _in_si(key: str, name: str, unit: str) -> float:
    try:
        factor = si(f"1 {name}", unit)
    except ValueError:
        factor = None
    if not isinstance(factor, float) or not 1e-12 <= factor <= 1e12:
        raise InputError(f'{key} = "{name}": expected a unit such as "{unit}"')
    return factor


def load_matrices(
    stiffness: PathLike,
    mass: PathLike | None = None,
    damping: PathLike | None = None,
    dofs: PathLike | None = None,
    nodes: PathLike | None = None,
    names: Mapping[str, str] | None = None,
    length: str = "m",
    mass_unit: str = "kg",
    force: str = "N",
) -> Matrices:
    """Read a component's matrices.

    Which row is which the file itself says (Nastran's DMIG, Abaqus's .mtx, Ansys's .full), or
    `dofs`, or else by `nodes`: x, y and z of its nodes in their order.

    Parameters
    ----------
    stiffness, mass, damping : path, optional
        Files; a mass or damping that is not given is looked for in the stiffness file where that
        can hold several matrices. "file.h5:/group/K" is a dataset of a file.
    dofs : path, optional
        Ansys's .mapping or a table (CSV): node and direction of each row.
    nodes : path, optional
        A table (CSV) with the columns node, x, y, z.
    names : mapping of str to str
        Name of the matrix "stiffness", "mass" or "damping" in its file.
    length, mass_unit, force : str
        Units of the numbers in all files, `nodes` too, such as "mm", "t" and "N"; the unit of time
        is the one that makes them consistent.

    Returns
    -------
    Matrices
        In SI units; without a mass where no file holds one.

    Raises
    ------
    InputError
        One line that names the file: it cannot be read, is malformed or not Hermitian, or does not
        agree with the others.
    """
    used = _units(length, mass_unit, force)
    names = dict(names or {})
    if unknown := sorted(set(names) - {"stiffness", "mass", "damping"}):
        raise InputError(f"names: {unknown[0]!r}: stiffness, mass or damping can be named")
    stiffness = Path(stiffness)
    position_node, position = _positions(nodes)
    first = _read_entries(stiffness, WantedMatrix("stiffness", names.get("stiffness")))
    _refuse_vast(first)
    labels = _labels(first, dofs, position_node)
    parts = {"stiffness": _Part(first, assembled(first, "stiffness"), labels)}
    for what, path in (("mass", mass), ("damping", damping)):
        entries = _other(stiffness, path, what, names.get(what))
        if entries is not None:
            parts[what] = _part(entries, what, dofs, position_node, parts["stiffness"])
    node, direction, matrices = _aligned(parts)
    node, direction = check_labels(first.source, node, direction)
    if "mass" in matrices:
        _check_mass(parts["mass"].entries.source, matrices["mass"], node, direction)
    found = {what: used.converted(m, what, direction) for what, m in matrices.items()}
    return Matrices(
        K=found["stiffness"],
        M=found.get("mass"),
        C=found.get("damping"),
        node=node,
        direction=direction,
        position=None if position is None else position * used.length,
        position_node=position_node,
    )


@dataclass(frozen=True)
class _Part:
    """A matrix and its rows' labels."""

    entries: Entries
    matrix: sp.csc_array
    labels: Labels


def _other(stiffness: Path, path: PathLike | None, what: str, name: str | None) -> Entries | None:
    """Mass or damping from its own file, or from the stiffness's where that has it."""
    if path is not None:
        return _read_entries(Path(path), WantedMatrix(what, name))
    if _ending(stiffness) not in _SEVERAL:
        if name is not None:
            raise InputError(f'names: {what} = "{name}": {stiffness} holds one matrix: give a file')
        return None
    try:
        return _read_entries(stiffness, WantedMatrix(what, name, alone=False))
    except NoMatrixError:
        if name is not None:
            raise
        return None


def _part(
    entries: Entries, what: str, dofs: PathLike | None, position_node: Integers, stiffness: _Part
) -> _Part:
    unlabelled = entries.node is None
    if unlabelled and entries.size != stiffness.entries.size:
        raise InputError(
            f"{entries.source}: {entries.size:,} rows, but {stiffness.entries.source} has "
            f"{stiffness.entries.size:,}"
        )
    if not unlabelled:
        _refuse_vast(entries)
    labels = stiffness.labels if unlabelled else _labels(entries, dofs, position_node)
    return _Part(entries, assembled(entries, what), labels)


def _refuse_vast(entries: Entries) -> None:
    """A row without entries costs memory, not bytes of the file."""
    if entries.size > 1000 + 10 * len(entries.values):
        raise InputError(
            f"{entries.source}: {entries.size:,} rows, but only {len(entries.values):,} entries"
        )


def _labels(entries: Entries, dofs: PathLike | None, position_node: Integers) -> Labels:
    """Of each row, from the file itself, the table `dofs`, or the order of the nodes."""
    if entries.node is not None and entries.direction is not None:
        return entries.node, entries.direction
    if dofs is not None:
        return read_labels(Path(dofs), entries.size)
    if len(position_node) and entries.size == 3 * len(position_node):
        return np.repeat(position_node, 3), np.tile(np.arange(3), len(position_node))
    raise InputError(
        f"{entries.source}: does not say which node and direction its {entries.size:,} rows are: "
        "give dofs (Ansys's .mapping or a table of node and direction)"
    )


def _aligned(parts: Mapping[str, _Part]) -> tuple[Integers, Integers, dict[str, sp.csc_array]]:
    """Matrices in the order of one list of labels, the longest.

    A format that lists entries by label leaves out rows of zeros: the mass of massless freedoms,
    the stiffness of a statically determinate interface. Other labels must be the same.
    """
    fixed = frozenset().union(*(part.entries.fixed for part in parts.values()))
    parts = {what: _without(part, fixed) for what, part in parts.items()}
    longest = max(parts.values(), key=lambda part: len(part.labels[0]))
    place = {key: k for k, key in enumerate(_keys(longest.labels))}
    if len(place) < len(longest.labels[0]):
        check_labels(longest.entries.source, *longest.labels)
        raise InputError(f"{longest.entries.source}: two rows have the same label")
    n = len(place)
    aligned = {}
    for what, part in parts.items():
        if part.labels is longest.labels:
            aligned[what] = part.matrix
            continue
        keys = _keys(part.labels)
        source, other = part.entries.source, longest.entries.source
        if lacking := next((key for key in keys if key not in place), None):
            raise InputError(f"{source}: {_named(lacking)} is not in {other}")
        places = np.array([place[key] for key in keys], np.int64)
        if len(places) < n and not part.entries.leaves_out:
            absent = sorted(set(place) - set(keys))[0]
            raise InputError(f"{source}: {_named(absent)} of {other} is missing")
        coo = part.matrix.tocoo()
        aligned[what] = sp.coo_array(
            (coo.data, (places[coo.row], places[coo.col])), shape=(n, n)
        ).tocsc()
    return *longest.labels, aligned


def _without(part: _Part, fixed: frozenset[tuple[int, int]]) -> _Part:
    """A matrix without the rows of freedoms that any of the files holds fixed."""
    if not fixed:
        return part
    free = np.array([key not in fixed for key in _keys(part.labels)], bool)
    if free.all():
        return part
    kept = np.flatnonzero(free)
    matrix = part.matrix[:, kept].tocsr()[kept].tocsc()
    return _Part(part.entries, matrix, (part.labels[0][kept], part.labels[1][kept]))


def _keys(labels: Labels) -> list[tuple[int, int]]:
    """Labels that are unique: generalised coordinates without a number count 0, -1, -2, ..."""
    node, direction = labels
    unnumbered = (direction == GENERALISED) & (node == 0)
    numbers = np.where(unnumbered, 1 - np.cumsum(unnumbered), node)
    return list(zip(numbers.tolist(), direction.tolist(), strict=True))


def _named(key: tuple[int, int]) -> str:
    node, direction = key
    if direction == GENERALISED:
        return f"generalised coordinate {node}"
    return f"node {node}, direction {named(direction)}"


def _positions(nodes: PathLike | None) -> tuple[Integers, Floats | None]:
    """Numbers and coordinates of the nodes, in the file's unit."""
    if nodes is None:
        return np.empty(0, np.int64), None
    nodes = Path(nodes)
    columns = {name.lower(): values for name, values in load_pairs(nodes).items()}
    for name in ("node", "x", "y", "z"):
        if name not in columns:
            raise InputError(f"{nodes}: no column {name!r}: needed are node, x, y, z")
        if columns[name].dtype.kind not in ("i" if name == "node" else "if"):
            raise InputError(f"{nodes}: column {name!r}: numbers are needed")
    node = columns["node"].astype(np.int64)
    if (node < 1).any():
        raise InputError(f"{nodes}: node {int(node.min())}: nodes are numbered from 1")
    distinct, count = np.unique(node, return_counts=True)
    if (count > 1).any():
        raise InputError(f"{nodes}: node {int(distinct[count > 1][0])} is listed twice")
    return node, np.column_stack([columns[name] for name in "xyz"]).astype(float)
