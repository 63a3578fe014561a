"""A mesh of solid elements as it was read from a file, checked, with its sets."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vanelock.common.product import Product
from vanelock.mesh.part import Part


@dataclass(frozen=True)
class FileMesh(Product):
    """A part's mesh from a file, not yet matched to its mates.

    Attributes
    ----------
    source : str
        What errors call the file.
    points : (n, 3) float
        Nodes, m; each belongs to an element.
    numbers : (n,) int
        The file's numbers of the nodes.
    cells : (e, k) int
        Nodes of each element, in meshio's order for `cell_type`.
    elements : (e,) int
        The file's numbers of the elements.
    cell_type : str
        meshio's name: tetra, tetra10, hexahedron, hexahedron20 or hexahedron27.
    node_sets : dict of str to (k,) int
        Nodes of every set of the file, of element and of face sets too, in the file's order.
    face_sets : dict of str to (f, c) int
        Corner nodes of the faces of those sets that consist of faces of the solid elements.
    absent : dict of str to (k,) int
        The file's numbers of those nodes of a set that belong to no solid element.
    """

    source: str
    points: NDArray[np.float64] = field(metadata={"unit": "m"})
    numbers: NDArray[np.int64]
    cells: NDArray[np.int64]
    elements: NDArray[np.int64]
    cell_type: str
    node_sets: dict[str, NDArray[np.int64]]
    face_sets: dict[str, NDArray[np.int64]]
    absent: dict[str, NDArray[np.int64]]

    def part(self) -> Part:
        """The same as a whole part, with the file's node sets and no contact frames."""
        return Part(self.source, self.points, self.cells, self.cell_type, self.node_sets, {}, 1)
