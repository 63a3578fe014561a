"""Free vane segments of several element families: what their frequencies cost."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.mesh.blocks import Sizes
from benchmarks.mesh.vane_blocks import vane_hexahedra
from benchmarks.segment import MATERIAL
from vanelock import fem, mesh
from vanelock.mesh import Part, VaneDimensions
from vanelock.mesh.generate.mesher import EDGES

Floats = NDArray[np.float64]

COUNT = 10  # elastic modes compared
RIGID = 6
CURVED, STRAIGHT, LINEAR = "tetra10", "tetra10, straight", "tetra"
SHARP = VaneDimensions(root_fillet=0.0)  # as blocks of hexahedra are
TETRAHEDRA = (0.025, 0.016, 0.0115, 0.008, 0.006)
HEXAHEDRA = (0.024, 0.016, 0.012, 0.008, 0.006)


@dataclass(frozen=True)
class Row:
    """One mesh.

    Attributes
    ----------
    family, name : str
        Of the elements, and of the mesh.
    dofs, nonzeros : int
        Of K: rows and entries.
    seconds : (4,) float
        CPU time of meshing, assembly, factorisation, and of the modes with the factor at hand.
    frequency : (10,) float
        The first elastic modes', Hz.
    """

    family: str
    name: str
    dofs: int
    nonzeros: int
    seconds: Floats
    frequency: Floats

    @property
    def size(self) -> float:
        """Of the elements, mm, without regard to smaller ones at corners."""
        return float(self.name.split()[0])

    @property
    def solving(self) -> float:
        """CPU time from the mesh to the modes, s."""
        return float(self.seconds[1:].sum())


def rows() -> Iterator[Row]:
    """All families at all their sizes, each family from coarse to fine."""
    for family in (CURVED, STRAIGHT, LINEAR):
        for size in TETRAHEDRA if family != LINEAR else TETRAHEDRA[2:]:
            yield measured(family, f"{1e3 * size:g} mm", tetrahedral(family, size))
    for family in ("hexahedron20", "hexahedron27", "hexahedron"):
        chosen = HEXAHEDRA[1:] if family == "hexahedron" else HEXAHEDRA
        for size in chosen[:-1] if family == "hexahedron27" else chosen:
            yield measured(family, f"{1e3 * size:g} mm", hexahedral(family, Sizes(size)))


def hexahedral(family: str, sizes: Sizes) -> Callable[[], Part]:
    """How to make a mesh of hexahedra."""
    return lambda: vane_hexahedra(sizes, cell_type=family)


def tetrahedral(family: str, size: float | str) -> Callable[[], Part]:
    """How to make a mesh of tetrahedra: the product's, or what becomes of it."""

    def make() -> Part:
        part = mesh.vane_segment(SHARP, size=size)
        if family == CURVED:
            return part
        return straightened(part) if family == STRAIGHT else linear(part)

    return make


def straightened(part: Part) -> Part:
    """The same quadratic elements with mid-side nodes on their chords."""
    points = part.points.copy()
    for middle, (start, end) in enumerate(EDGES, start=4):
        ends = part.points[part.cells[:, start]], part.points[part.cells[:, end]]
        points[part.cells[:, middle]] = 0.5 * (ends[0] + ends[1])
    return replace(part, points=points)


def linear(part: Part) -> Part:
    """The tetrahedra between the corner nodes alone."""
    kept, cells = np.unique(part.cells[:, :4], return_inverse=True)
    cells = cells.reshape(-1, 4)
    return Part(part.name, part.points[kept], cells, "tetra", {}, {}, part.sectors)


def measured(family: str, name: str, make: Callable[[], Part]) -> Row:
    """Mesh a free vane and find its first elastic modes, with the CPU time of each step."""
    marks = [time.process_time()]
    part = make()
    marks.append(time.process_time())
    model = fem.assemble(part, MATERIAL)
    marks.append(time.process_time())
    shift = -((2 * np.pi * 5.0) ** 2)  # well below the elastic modes
    factor = fem.factorise(model.K - shift * model.M)
    marks.append(time.process_time())
    squared, _ = fem.eigenpairs(model.K, model.M, RIGID + COUNT, shift, factor)
    marks.append(time.process_time())
    assert squared[RIGID - 1] < 1e-6 * squared[RIGID]
    found = np.sqrt(squared[RIGID:]) / (2 * np.pi)
    print(f"{family}, {name}: {model.K.shape[0]} dofs, {found.round(1)}", flush=True)
    return Row(
        family,
        name,
        model.K.shape[0],
        model.K.nnz,
        np.diff(marks),
        found,
    )
