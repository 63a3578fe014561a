"""Figures of a mesh that show whether it can be trusted: size, volume, shape of its elements."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from vanelock import mesh
from vanelock.common.arrays import Floats
from vanelock.fem.elements import reference_element, shape_functions
from vanelock.mesh import Part

# Edges of a perfect element over those of the reference one, as columns.
_REGULAR: Final = np.array(
    [[1, 0.5, 0.5], [0, np.sqrt(3) / 2, np.sqrt(3) / 6], [0, 0, np.sqrt(2 / 3)]]
)
_PAIRS: Final = {  # corners at the ends of each edge
    "tetra": [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(i, (i + 1) % 4) for i in range(4)]
    + [(4 + i, 4 + (i + 1) % 4) for i in range(4)]
    + [(i, i + 4) for i in range(4)],
}


@dataclass(frozen=True)
class Figures:
    """Figures of a mesh.

    Attributes
    ----------
    nodes, elements : int
        Counts.
    cell_type : str
        meshio's name of the element type.
    volume : float
        Sum over the elements, m³.
    smallest_jacobian : float
        Smallest determinant of the map from the reference element, over that of a straight-sided
        tetrahedron (`mesh.quality`'s bound), or at a hexahedron's nodes over its mean. Positive in
        a valid mesh.
    sicn : (3,) float
        Signed inverse condition number of the element that the corners span, at the worst corner:
        the smallest of all elements, the one that 1 % of them stay below, and their median. 1 is
        perfect.
    largest_edge : float
        Longest distance between the ends of an element's edge, m.
    """

    nodes: int
    elements: int
    cell_type: str
    volume: float
    smallest_jacobian: float
    sicn: tuple[float, float, float]
    largest_edge: float

    @property
    def dofs(self) -> int:
        """Degrees of freedom."""
        return 3 * self.nodes


def figures(part: Part) -> Figures:
    """Figures of a part of tetrahedra or hexahedra, linear or quadratic."""
    kind = "tetra" if part.cell_type.startswith("tetra") else "hexahedron"
    reference, straight = reference_element(part.cell_type), reference_element(kind)
    weighed = np.linalg.det(_jacobians(part, reference.gradients)) * reference.weights
    corners = shape_functions(kind, straight.nodes)[1]
    condition = _inverse_condition(
        _jacobians(part, corners), _REGULAR if kind == "tetra" else np.eye(3)
    )
    if kind == "tetra":
        smallest = mesh.quality(part).smallest_jacobian
    else:
        at_nodes = _jacobians(part, shape_functions(part.cell_type, reference.nodes)[1])
        mean = weighed.sum(axis=1) / reference.weights.sum()
        smallest = float((np.linalg.det(at_nodes) / mean[:, None]).min())
    worst = condition.min(axis=1)
    first, second = part.cells[:, np.array(_PAIRS[kind])].transpose(2, 0, 1)
    edges = np.linalg.norm(part.points[first] - part.points[second], axis=-1)
    return Figures(
        nodes=len(part.points),
        elements=len(part.cells),
        cell_type=part.cell_type,
        volume=float(weighed.sum()),
        smallest_jacobian=smallest,
        sicn=(float(worst.min()), float(np.quantile(worst, 0.01)), float(np.median(worst))),
        largest_edge=float(edges.max()),
    )


def _jacobians(part: Part, gradients: Floats) -> Floats:
    """Derivative of place by reference coordinates, (e, q, 3, 3) m, from gradients (q, k, 3).

    Of the elements, or with the gradients of fewer nodes of those that the first k nodes span.
    """
    points = part.points[part.cells[:, : gradients.shape[1]]]
    return np.asarray(np.einsum("eia,qib->eqab", points, gradients, optimize=True))


def _inverse_condition(jacobians: Floats, perfect: Floats) -> Floats:
    """3 det A / (|A| |adj A|), Frobenius norms, A from the perfect element; 0 if it is flat."""
    A = jacobians @ np.linalg.inv(perfect)
    adjugate = np.stack([np.cross(A[..., (k + 1) % 3], A[..., (k + 2) % 3]) for k in range(3)])
    norms = np.linalg.norm(A, axis=(-2, -1)) * np.sqrt((adjugate**2).sum(axis=(0, -1)))
    flat = np.zeros_like(norms)
    return np.asarray(np.divide(3 * np.linalg.det(A), norms, out=flat, where=norms > 0))
