"""What of the joints' load at rest comes of interference, gas and heat, and what holds a segment.

Contacts open, close and slide, so causes do not add up by themselves: each acts in turn, on top of
those before it.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vanelock import nonlinear
from vanelock.common.product import Product
from vanelock.input.schema.study import Study
from vanelock.nonlinear import HarmonicModes, Response
from vanelock.pipeline.step import SHARED, Step, step
from vanelock.rom import Component, Force, System
from vanelock.rom.joining.vane_and_casing import joined_dofs
from vanelock.stages.parts.components import PARTS
from vanelock.stages.parts.loads import RestLoad, by_cause, loads_of
from vanelock.stages.plan import Planned

Array = NDArray[np.float64]

INTERFERENCE = "interference"
RIGID = 1e-8
"""Force over stiffness times displacement that moving a vane as a whole takes: round-off."""
ROUND = 1e-14
"""Reactions, over the largest, that are round-off."""


@dataclass(frozen=True)
class LoadsByCause(Product):
    """Normal loads of j joints at rest as c causes act one after the other.

    Attributes
    ----------
    joints, causes : tuple of str
        Interference acts first.
    contacts : (j,) int
        Contacts of a joint in a sector.
    normal : (c, j) float
        Sum of their normal forces, N, with the causes so far.
    opened : (c, j) int
        How many of them carry nothing.
    converged : (c,) bool
        Whether the states at rest are solved.
    reaction : (j + 1, 2) float
        Axial force, N, and torque about the engine axis, N m, on a segment, of each joint and of
        the nodes that key it; empty where it is clamped besides.
    resultant : (2,) float
        Those of the loads, which the reactions balance.
    """

    joints: tuple[str, ...]
    causes: tuple[str, ...]
    contacts: NDArray[np.int64]
    normal: NDArray[np.float64] = field(metadata={"unit": "N"})
    opened: NDArray[np.int64]
    converged: NDArray[np.bool_]
    reaction: NDArray[np.float64]
    resultant: NDArray[np.float64]


def by_cause_step(planned: Planned) -> Step[LoadsByCause] | None:
    """Loads at rest of a case by cause; None where nothing acts but interference."""
    study = planned.case.given
    if not isinstance(study, Study) or not (loads := loads_of(study)):
        return None
    parts = tuple(planned.part(part, 0) for part in PARTS)
    friction = study.response.friction
    return _by_cause(friction, loads, planned.preload, planned.system, parts, planned.at_rest)


@lru_cache(maxsize=SHARED)
def _by_cause(
    friction: str,
    given: tuple[RestLoad, ...],
    preload: Step[Response],
    system: Step[System],
    parts: tuple[Step[Component], ...],
    modes: Step[HarmonicModes],
) -> Step[LoadsByCause]:
    def compute(
        preload: Response, system: System, vane: Component, casing: Component, stuck: HarmonicModes
    ) -> LoadsByCause:
        loads = by_cause(vane, casing, given)
        options, states = nonlinear.Options(friction=friction), []
        vectors = np.array(list(loads.values()))
        for acting in np.cumsum([0 * vectors[0], *vectors[:-1]], axis=0):
            so_far = replace(system, force={**system.force, 0: Force(acting)})
            states.append(nonlinear.static_response(so_far, options, stuck.diameters))
        states.append(preload)
        names = tuple(dict.fromkeys(system.contacts.joints))
        masks = np.array([system.contacts.of(name) for name in names])
        opened = np.array([state.state[0] == nonlinear.OPEN for state in states])
        normal = np.array([state.force[0, 0, :, 0].real for state in states])
        return LoadsByCause(
            joints=names,
            causes=(INTERFERENCE, *loads),
            contacts=masks.sum(axis=1),
            normal=np.where(opened, 0.0, normal) @ masks.T,
            opened=opened @ masks.T.astype(np.int64),
            converged=np.array([bool(state.converged.all()) for state in states]),
            **_reactions(vane, casing, system, preload, masks),
        )

    needs = (preload, system, *parts, modes)
    inputs = {"friction": friction, "loads": [(each.name, each.size) for each in given]}
    return step("preload by cause", "nonlinear", inputs, LoadsByCause, needs, compute)


def _reactions(
    vane: Component, casing: Component, system: System, rest: Response, joints: NDArray[np.bool_]
) -> dict[str, Array]:
    """By the principle of virtual work, for a shift and a turn of the vane as a whole."""
    at = vane.dofs(vane.masters.nodes)
    x, y, _ = vane.masters.points.T
    own = np.zeros((2, vane.size))
    own[0, at[:, 2]] = 1.0
    own[1, at[:, 0]], own[1, at[:, 1]] = -y, x
    K = vane.at(0).K.real
    if np.linalg.norm(own @ K) > RIGID * np.linalg.norm(own) * np.linalg.norm(K):
        return {"reaction": np.empty((0, 2)), "resultant": np.empty(2)}
    moved = np.zeros((2, len(rest.x[0][0])))
    moved[:, joined_dofs(vane, casing)] = own
    of_contacts = np.einsum(
        "cdn,rn,cd->rc", system.contact_rows(0).real, moved, rest.force[0, 0].real
    )
    of_key = moved @ (system.at(0).K.real @ rest.x[0][0].real)
    held = np.column_stack([of_contacts @ joints.T, of_key])
    held[np.abs(held) < ROUND * np.abs(held).max()] = 0.0  # neighbours cannot hold each other
    return {"reaction": 0.0 - held.T, "resultant": moved @ system.force[0].vector.real}
