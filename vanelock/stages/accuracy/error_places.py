"""Where meshes have their error: what each element adds to the stiffness of the mode of interest.

The places listed are the elements that add most, each with what lies around it.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock import fem, rom
from vanelock.common.arrays import Floats
from vanelock.common.product import Product
from vanelock.common.tables import Cell, Column, Table, heads
from vanelock.input.cases.values import diameter_of
from vanelock.input.schema.structure.own_mesh import OwnCasing, OwnVane
from vanelock.mesh import Part
from vanelock.pipeline.step import Step, step
from vanelock.rom import System
from vanelock.stages.parts.components import PARTS, recovery_step
from vanelock.stages.plan import Planned
from vanelock.stages.response.limits import Limits

COUNT = 6
"""Places listed."""
AROUND = 3.0
"""What belongs to a place, in lengths of its element's edges."""


@dataclass(frozen=True)
class ErrorPlaces(Product):
    """What the meshes add to the stiffness of the mode of interest with the interlock stuck.

    Attributes
    ----------
    vane, casing : (n,) float
        At each node, energy per volume over the mean of both parts.
    part : (p,) int
        Of each place, 0 the vane, 1 the casing.
    share : (p,) float
        Of all that the meshes add, what lies around the place.
    position : (p, 3) float
        Middle of its element, m.
    edge : (p,) float
        Mean length of its element's edges, m.
    """

    vane: Floats
    casing: Floats
    part: NDArray[np.int64]
    share: Floats
    position: Floats = field(metadata={"unit": "m"})
    edge: Floats = field(metadata={"unit": "m"})

    @property
    def table(self) -> Table:
        """A line for each place, the worst first."""
        columns = (
            *heads("part"),
            Column("share of the mesh's error", "%", ".3g", "share_percent"),
            Column("radius", "mm", ".1f", "radius_mm"),
            Column("angle", "°", ".2f", "angle_degrees"),
            Column("z", "mm", ".1f", "z_mm"),
            Column("element edges", "mm", ".3g", "edge_mm"),
        )
        x, y, z = self.position.T
        cells = zip(
            (PARTS[part] for part in self.part), self.share, np.hypot(x, y),
            np.degrees(np.arctan2(y, x)), z, self.edge, strict=True,
        )  # fmt: skip
        rows: list[tuple[Cell, ...]] = [tuple(each) for each in cells]
        note = (
            "Smaller elements there lower the error most: half the edges, about half of its share"
        )
        return Table("Where the meshes err", columns, rows, (note,), "mesh_error")


def of_own_meshes(planned: Planned) -> Step[ErrorPlaces] | None:
    """The step of a case of which a part is a user's own mesh."""
    study = planned.case.given
    parts = [getattr(study, name, None) for name in PARTS]
    own = any(isinstance(part, OwnVane | OwnCasing) for part in parts)
    return _error_places_step(planned) if own else None


def _error_places_step(planned: Planned) -> Step[ErrorPlaces]:
    """The places of a study's case."""
    study = planned.case.study
    k = diameter_of(study, 1)
    recovered = [recovery_step(study, part, k) for part in PARTS]

    def compute(system: System, limits: Limits, *whole: rom.Recovery) -> ErrorPlaces:
        k = limits.nodal_diameter
        shape = rom.linear_modes(system, k, limits.stuck_mode + 1)[1][:, -1]
        own = system.at(k).split(np.asarray(shape, complex))
        energies = [
            fem.excess_by_element(each.model, each.displacement(own[part], k))
            for part, each in zip(PARTS, whole, strict=True)
        ]
        return error_places([each.model.part for each in whole], energies)

    needs = (planned.linear.system, planned.linear.limits, *recovered)
    inputs: dict[str, Any] = {"count": COUNT, "around": AROUND}
    return step("mesh error by place", "fem", inputs, ErrorPlaces, needs, compute)


def error_places(parts: list[Part], energies: list[Floats]) -> ErrorPlaces:
    """The worst places of both parts, from what each of their elements adds, J."""
    boxes = [_volumes(part) for part in parts]
    mean = sum(e.sum() for e in energies) / sum(volume.sum() for volume, *_ in boxes)
    densities = [
        _at_nodes(part, e, volume) / mean
        for part, e, (volume, *_) in zip(parts, energies, boxes, strict=True)
    ]
    of = np.repeat(np.arange(len(parts)), [len(e) for e in energies])
    energy, middle, edge = (
        np.concatenate(each) for each in (energies, [b[1] for b in boxes], [b[2] for b in boxes])
    )
    left, chosen, share = energy.copy(), [], []
    for _ in range(min(COUNT, len(energy))):
        worst = int(left.argmax())
        near = np.linalg.norm(middle - middle[worst], axis=1) < AROUND * edge[worst]
        near &= of == of[worst]
        chosen.append(worst)
        share.append(float(left[near].sum() / energy.sum()))
        left[near] = 0
    order = np.argsort(share)[::-1]
    places = np.array(chosen)[order]
    return ErrorPlaces(
        densities[0], densities[1], of[places], np.array(share)[order], middle[places], edge[places]
    )


def _volumes(part: Part) -> tuple[Floats, Floats, Floats]:
    """Volumes of the elements' corners' boxes or tetrahedra, middles, and mean edges."""
    corners = part.points[part.cells[:, : 8 if part.cell_type.startswith("hexa") else 4]]
    middle = corners.mean(axis=1)
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
    if corners.shape[1] == 8:
        return edge**3, middle, edge
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    return volume, middle, edge


def _at_nodes(part: Part, energy: Floats, volume: Floats) -> Floats:
    """Energy per volume at nodes: that of their elements together."""
    count = part.cells.shape[1]
    found, around = (
        np.bincount(part.cells.ravel(), np.repeat(each, count), len(part.points))
        for each in (energy, volume)
    )
    return np.divide(found, around, out=np.zeros_like(found), where=around > 0)
