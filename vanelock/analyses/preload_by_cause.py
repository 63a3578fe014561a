"""What of the joints' load at rest comes of interference, gas and heat, and what holds a segment.

Contacts open, close and slide, so causes do not add up by themselves: each acts in turn, on top of
those before it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from vanelock import nonlinear
from vanelock.analyses.analysis import Analysis
from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.product import Product
from vanelock.common.tables import Column, Table
from vanelock.input.cases.names import words

if TYPE_CHECKING:
    from vanelock.analyses.analysis import CaseResult, Planned, Step
    from vanelock.rom import Component, System
    from vanelock.stages.parts.segment import Segment


INTERFERENCE = "interference"
RIGID = 1e-8
"""Force over stiffness times displacement that moving a vane as a whole takes: round-off."""
ROUND = 1e-14
"""Reactions, over the largest, that are round-off."""
MOST = 8
"""States at rest that have tables."""
TEXT = (
    "What presses the joints before anything vibrates, cause by cause, and what holds a segment "
    "against its loads."
)


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
    contacts: Integers
    normal: Floats = field(metadata={"unit": "N"})
    opened: Integers
    converged: Booleans
    reaction: Floats
    resultant: Floats


def _by_cause_step(planned: "Planned") -> "Step[LoadsByCause] | None":
    """Loads at rest of a case by cause; None where nothing acts but interference."""
    from vanelock.stages.parts.segment import StudyStructure

    structure = planned.structure
    if not isinstance(structure, StudyStructure) or not structure.segment.at_rest:
        return None
    parts = tuple(planned.part(part, 0) for part in structure.names)
    friction, rest = planned.case.problem.response.friction, planned.preload
    return _by_cause(friction, structure.segment, rest, parts)


@lru_cache(maxsize=4096)
def _by_cause(
    friction: str,
    segment: "Segment",
    preload: "Step[nonlinear.Response]",
    parts: "tuple[Step[Component], ...]",
) -> "Step[LoadsByCause]":
    """The step, which cases share whose states at rest are the same."""
    from vanelock.pipeline.step import step
    from vanelock.rom import Force

    def compute(
        preload: "nonlinear.Response",
        system: "System",
        stuck: "nonlinear.HarmonicModes",
        vane: "Component",
        casing: "Component",
    ) -> LoadsByCause:
        loads = segment.assembly(segment.loaded(vane), casing).rest_loads()
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
            **_reactions(vane, system, preload, masks),
        )

    needs = (preload, *preload.needs, *parts)
    inputs = {"friction": friction, "loads": segment.at_rest}
    return step("preload by cause", "nonlinear", inputs, LoadsByCause, needs, compute)


def _reactions(
    vane: "Component", system: "System", rest: "nonlinear.Response", joints: Booleans
) -> dict[str, Floats]:
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
    moved[:, system.at(0).parts["vane"]] = own
    of_contacts = np.einsum(
        "cdn,rn,cd->rc", system.contact_rows(0).real, moved, rest.force[0, 0].real
    )
    of_key = moved @ (system.at(0).K.real @ rest.x[0][0].real)
    held = np.column_stack([of_contacts @ joints.T, of_key])
    held[np.abs(held) < ROUND * np.abs(held).max()] = 0.0  # neighbours cannot hold each other
    return {"reaction": 0.0 - held.T, "resultant": moved @ system.force[0].vector.real}


def _tables(cases: "Mapping[str, CaseResult]") -> Iterator[Table]:
    """What presses the joints at rest, and what holds a segment, of each state at rest."""
    distinct = {key: case for case in cases.values() for key in case.key_of("preload_by_cause")}
    for case in islice(distinct.values(), MOST):
        (found,), name = case.found("preload_by_cause"), words(case.preload_name)
        yield _causes(name, found)
        if len(found.reaction):
            yield _reactions_table(name, found)


def _causes(name: str, loads: LoadsByCause) -> Table:
    """Normal loads at rest of the joints by cause, each on top of those before it."""
    changes = np.diff(loads.normal, axis=0, prepend=0.0)
    lifted = np.diff(loads.opened, axis=0, prepend=0)
    rows = [
        (joint, *changes[:, j], loads.normal[-1, j], loads.opened[-1, j])
        for j, joint in enumerate(loads.joints)
    ]
    columns = (
        Column("joint"),
        *(Column(cause, "N", "+.4g", cause) for cause in loads.causes),
        Column("all", "N", ".4g", "all", note="normal load of a joint in a sector"),
        Column("open"),
    )
    notes = ["each cause acts on top of those to its left"]
    notes += [
        f"{cause} opens {lifted[c, j]} of {joint}'s {loads.contacts[j]} contacts"
        for c, cause in enumerate(loads.causes)
        for j, joint in enumerate(loads.joints)
        if c and lifted[c, j] > 0
    ]
    if not loads.converged.all():
        notes.append("NOT CONVERGED: do not use these loads")
    title = f"Preload by cause{name and f', {name}'}"
    return Table(title, columns, rows, notes, "preload_by_cause")


def _reactions_table(name: str, loads: LoadsByCause) -> Table:
    """What holds a segment at rest against its loads."""
    names = *loads.joints, "key", "loads", "sum"
    values = *loads.reaction, loads.resultant, loads.reaction.sum(axis=0) + loads.resultant
    rows = [(name, *each) for name, each in zip(names, values, strict=True)]
    columns = Column("from"), Column("axial", "N", "+.4g"), Column("torque", "N m", "+.4g")
    notes = ["torque: about the engine axis; sum: what is not in balance"]
    return Table(f"Reactions at rest{name and f', {name}'}", columns, rows, notes, "reactions")


PRELOAD_BY_CAUSE: Analysis[Any, LoadsByCause] = Analysis(
    key="preload_by_cause",
    title="preload by cause",
    product=lambda: LoadsByCause,
    step=_by_cause_step,
    tables=_tables,
    text=TEXT,
)
