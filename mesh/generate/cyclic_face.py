"""Divide the edges of a plane face so that it gets an exact number of quadratic nodes.

A face without holes, with V corner nodes of which B lie on its boundary, has 3V - 3 - B edges of
triangles and so F = 4V - 3 - B quadratic nodes: B = 1 - F modulo 4. One more interval on an edge
adds a boundary node, mostly with no other one, and so 3 nodes. The counts of intervals of the
face's edges are searched, meshing the face alone, from those of evenly coarser and finer meshes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.errors import InputError
from vanelock.mesh.geometry.element_size import LARGEST, SMALLEST

RATIO = 1.25
"""Elements of the face's edges may be so much longer or shorter than the element size."""

_STEPS = 8  # even meshes on either side of the element size
_BASES = 6  # of them perturbed
_TRIALS = 40  # of each
_ENOUGH = 3  # of them that lead to the number

Integers = NDArray[np.int64]


def divide_face(gmsh: Any, face: int, size: float, wanted: int) -> None:
    """Prescribe counts of intervals on a face's edges that give it a number of nodes.

    The same search finds the same counts; of those found the ones closest to an even mesh of the
    element size are taken. No mesh is left behind.
    """
    alone = _Alone.of(gmsh, face)
    try:
        bases = [alone.even(size * RATIO ** (k / _STEPS), size) for k in _outwards(_STEPS)]
        reached = [count for count, _ in bases]
        if not min(reached) <= wanted <= max(reached):
            raise InputError(_out_of_reach(alone, reached, wanted, size))
        natural = bases[0][1]
        bases.sort(key=lambda base: abs(base[0] - wanted))
        found: list[tuple[float, Integers]] = []
        for count, intervals in bases[:_BASES]:
            for trial in _near(intervals, alone.straight, count, wanted):
                got = alone.nodes(trial, size)
                reached.append(got)
                if got == wanted:
                    found.append((alone.unevenness(trial, natural), trial))
                    break
            if len(found) == _ENOUGH:
                break
        if not found:
            near = sorted(set(reached), key=lambda count: abs(count - wanted))[:2]
            raise InputError(
                f"mesh.face_nodes = {wanted}: not found with elements of {size * 1e3:g} mm: "
                f"allowed are {' and '.join(map(str, sorted(near)))}, or another mesh.size"
            )
    finally:
        alone.leave()
    alone.prescribe(min(found, key=lambda pair: pair[0])[1])


def _outwards(steps: int) -> list[int]:
    """0, 1, -1, 2, -2, ..."""
    return sorted(range(-steps, steps + 1), key=lambda k: (abs(k), -k))


def _near(
    intervals: Integers, straight: NDArray[np.bool_], count: int, wanted: int
) -> Iterator[Integers]:
    """Counts of intervals near those given whose total allows the wanted number of nodes.

    Changes go to straight edges, more often to those with many intervals, which they disturb less.
    """
    random = np.random.default_rng(wanted)
    total = int(intervals.sum())
    need = round((wanted - count) / 3.3)
    # The nearest change of the total with B = 1 - F modulo 4.
    off = (1 - wanted - total - need + 2) % 4 - 2
    if need + off == 0:
        yield intervals
    for trial in range(_TRIALS):
        change = need + off + 4 * (0, 0, 0, -np.sign(off) or 1, np.sign(off) or -1)[trial % 5]
        swaps = trial // 5
        steps = np.concatenate(
            [np.full(abs(change), np.sign(change)), np.tile([1, -1], swaps)]
        ).astype(np.int64)
        changed = intervals.copy()
        for step in steps:
            free = straight & (changed + step >= 1)
            if not free.any():
                break
            weight = np.where(free, changed, 0) / changed[free].sum()
            changed[random.choice(len(changed), p=weight)] += step
        else:
            yield changed


def _out_of_reach(alone: "_Alone", reached: list[int], wanted: int, size: float) -> str:
    low, high = SMALLEST, LARGEST
    most, fewest = (alone.even(limit, limit)[0] for limit in (low, high))
    text = (
        f"mesh.face_nodes = {wanted}: with elements of {size * 1e3:g} mm a cyclic face of the "
        f"casing has about {reached[0]} nodes: allowed are {min(reached)} to {max(reached)}"
    )
    if not fewest <= wanted <= most:
        return f"{text}; with other mesh.size {fewest} to about {most}"
    while high / low > 1.01:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if alone.even(middle, middle)[0] > wanted else (low, middle)
    return f"{text}; {wanted} suits mesh.size = {1e3 * np.sqrt(low * high):.2g} mm"


@dataclass(frozen=True)
class _Alone:
    """One face of a model, meshed without the rest."""

    gmsh: Any
    face: int
    edges: list[int]
    length: NDArray[np.float64]
    straight: NDArray[np.bool_]

    @classmethod
    def of(cls, gmsh: Any, face: int) -> "_Alone":
        model = gmsh.model
        edges = [tag for _, tag in model.getBoundary([(2, face)], oriented=False)]
        gmsh.option.setNumber("Mesh.MeshOnlyVisible", 1)
        model.setVisibility(model.getEntities(), 0)
        model.setVisibility([(2, face)], 1, recursive=True)
        length = np.array([model.occ.getMass(1, tag) for tag in edges])
        straight = np.array([model.getType(1, tag) == "Line" for tag in edges])
        return cls(gmsh, face, edges, length, straight)

    def leave(self) -> None:
        """Drop the face's mesh and show the rest of the model again."""
        model = self.gmsh.model
        model.mesh.clear()
        self.gmsh.option.setNumber("Mesh.MeshOnlyVisible", 0)
        model.setVisibility(model.getEntities(), 1)

    def even(self, edge: float, size: float) -> tuple[int, Integers]:
        """Nodes of the face with elements of `size` and with edges meshed evenly, and counts."""
        model = self.gmsh.model
        model.mesh.clear()
        model.mesh.removeConstraints([(1, tag) for tag in self.edges])
        self.gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        model.mesh.generate(1)
        intervals = [len(model.mesh.getElements(1, tag)[1][0]) for tag in self.edges]
        found = np.array(intervals, dtype=np.int64)
        return self.nodes(found, size), found

    def nodes(self, intervals: Integers, size: float) -> int:
        """Quadratic nodes of the face with its edges divided as given."""
        mesh = self.gmsh.model.mesh
        mesh.clear()
        self.prescribe(intervals)
        self.gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        mesh.generate(2)
        corners, _, _ = mesh.getNodes(2, self.face, includeBoundary=True)
        return 4 * len(corners) - 3 - int(intervals.sum())

    def prescribe(self, intervals: Integers) -> None:
        """Set the counts of intervals of the face's edges."""
        for tag, count in zip(self.edges, intervals.tolist(), strict=True):
            self.gmsh.model.mesh.setTransfiniteCurve(tag, count + 1)

    def unevenness(self, intervals: Integers, natural: Integers) -> float:
        """Mean square of the logarithm of the edges' elements against the natural ones."""
        ratio = np.log(intervals / natural)
        return float(ratio**2 @ self.length / self.length.sum())
