"""One part, a user's or the program's own, while it is matched to the other."""

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh.cells import solid
from vanelock.mesh.contact import frames as contact
from vanelock.mesh.contact.areas import nodal_areas
from vanelock.mesh.exterior import exterior
from vanelock.mesh.matching.own_part import OwnPart
from vanelock.mesh.part import Part

Array = NDArray[np.float64]


class Side:
    """One part while it is matched.

    Attributes
    ----------
    own : bool
        Whether it is a user's; the program's own part stays as it is.
    source : str
        What errors call it.
    points : (n, 3) float
        Its nodes, m, to be moved to their mates.
    sets : dict of str to (k,) int
        Its sets, to be put in the order of their mates.
    frames : dict of str to (k, 3, 3) float
        Its contact frames as far as they are known.
    """

    def __init__(self, given: Part | OwnPart, sectors: int) -> None:
        self.given, self.sectors = given, sectors
        self.own = isinstance(given, OwnPart)
        mesh = given.mesh if isinstance(given, OwnPart) else given
        self.name = given.name
        self.source = (
            f"{given.name} ({given.mesh.source})" if isinstance(given, OwnPart) else given.name
        )
        self.points = mesh.points.copy()
        self.cells, self.cell_type = mesh.cells, mesh.cell_type
        self.sets = dict(given.node_sets)
        self.frames = {} if isinstance(given, OwnPart) else dict(given.frames)

    def describe(self, node: int) -> str:
        """What errors call a node."""
        if isinstance(self.given, OwnPart):
            return self.given.describe(node)
        return f"node {node}"

    def of(self, name: str) -> Array:
        """Places of a set's nodes."""
        return self.points[self.sets[name]]

    def directions(self, name: str) -> list[Array]:
        """Directions in which the faces around a set's nodes look; of given faces alone."""
        return contact.candidates(self.points, self._faces(name), self.sets[name])

    def _faces(self, name: str) -> NDArray[np.int64]:
        """Faces on the outside, of a set that was given as faces only its own."""
        faces = exterior(self.cells, solid(self.cell_type))
        if isinstance(self.given, OwnPart) and name in self.given.face_sets:
            corners = self.given.face_sets[name]
            wanted = {tuple(row) for row in np.sort(corners, axis=1).tolist()}
            rows = np.sort(faces[:, : corners.shape[1]], axis=1).tolist()
            faces = faces[[tuple(row) in wanted for row in rows]]
        return faces

    def _areas(self) -> dict[str, Array]:
        """Areas of the nodes of the contact sets that consist of whole faces."""
        found = {}
        for name, frames in self.frames.items():
            area = nodal_areas(self.points, self._faces(name), self.sets[name], frames[:, 0])
            if area is not None:
                found[name] = area
        return found

    def part(self) -> Part:
        """The part as the later stages need it."""
        if isinstance(self.given, Part):
            return self.given
        return Part(
            self.name,
            self.points,
            self.cells,
            self.cell_type,
            self.sets,
            self.frames,
            self.sectors,
            areas=self._areas(),
        )
