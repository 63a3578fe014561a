"""Whether a scene can lie at rest, found before anything is reduced.

Parts that nothing but contacts holds move as rigid bodies, x = R r, until these press. Forces p of
the contacts, n >= 0 along the normal and |t| <= μ n across it, have to balance the static load,

    (B R)ᵀ p = Rᵀ f,

whatever springs and interference are: where the linear programme has no solution, nothing is at
rest. Where no n > 0 solves it, no contact is pressed. Motions with B R r = 0 nothing holds at all:
inertia bears the load along them. Rings are not looked at.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp

from vanelock.common.arrays import Booleans, Floats, Integers
from vanelock.common.errors import InputError
from vanelock.common.product import Product
from vanelock.fem.matrix_files import Matrices
from vanelock.input.schema.scene import Scene
from vanelock.stages.matrices.gather import Gathered
from vanelock.stages.matrices.piece import among, kept_rows, on_rows, rows_of
from vanelock.stages.matrices.pieces import WORDS, clamped

SOFT = 1e-14
"""Stiffness of a rigid motion, scaled to a diagonal of ones, below which it is round-off."""
RANK = 1e-9
"""Of the largest motion of a contact, one that is round-off."""
PRESSED = 1e-6
"""Normal force, in units of the load, that presses."""
INFEASIBLE = 2


@dataclass(frozen=True)
class RigidMotions(Product):
    """Rigid motions that a component's stiffness leaves free.

    Attributes
    ----------
    node, direction : (k,) int
        Rows that are kept.
    motions : (k, r) float
        Their motions.
    forces : dict of str to (r,) float
        What forces of files, on any rows, do on each motion, by these files' digests, N.
    """

    node: Integers
    direction: Integers
    motions: Floats
    forces: dict[str, Floats] = field(default_factory=dict)

    def at(self, nodes: Integers, directions: int) -> tuple[Floats, Booleans]:
        """(len(nodes), directions, r) of nodes, and which of these rows there are."""
        rows = rows_of(self.node, self.direction, nodes, directions)
        still = np.zeros((1, self.motions.shape[1]))
        return np.append(self.motions, still, axis=0)[rows], rows >= 0


def rigid_motions(scene: Scene, name: str, gathered: Gathered, matrices: Matrices) -> RigidMotions:
    """Rigid motions of a component, turns among them where all places are known."""
    fixed, forces = clamped(scene.components[name], name), gathered.forces_on(name)
    node, direction = matrices.node, matrices.direction
    free = ~np.isin(node, fixed)
    own = kept_rows(node, direction, gathered.kept[name])
    diagonal = matrices.K.diagonal().real
    if len(alone := np.flatnonzero(free & ~own & (diagonal == 0) & (direction < 6))):
        at = int(alone[0])
        raise InputError(
            f"components.{name}: node {node[at]}, {WORDS[direction[at]]}: held by nothing: it has "
            "no stiffness, and no contact, tie, load or output; clamp it or leave its row out"
        )
    R = _body(matrices)
    if not free.all():
        R = R[free] @ sl.null_space(R[~free], rcond=RANK)
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))[free]
    U, size, _ = np.linalg.svd(scale[:, None] * R, full_matrices=False)
    U = U[:, size > RANK * size.max(initial=0.0)]
    pulled = matrices.K.real[free][:, free] @ (U / scale[:, None])
    values, turns = sl.eigh(U.T @ (pulled / scale[:, None]))
    motions = (U @ turns[:, np.abs(values) < SOFT]) / scale[:, None]
    motions /= np.abs(motions).max(axis=0)
    chosen = own[free]
    work = on_rows(forces, node[free], direction[free], fixed).T @ motions
    return RigidMotions(
        node[free][chosen],
        direction[free][chosen],
        motions[chosen],
        {each.digest: done for each, done in zip(forces, work, strict=True)},
    )


def _body(matrices: Matrices) -> Floats:
    """(n, 3 or 6) rigid motions of all rows."""
    node, direction = matrices.node, matrices.direction
    R = np.zeros((matrices.size, 6))
    for d in range(3):
        R[direction == d, d] = 1.0
    moves = direction < 6
    if matrices.position is None or not np.isin(node[moves], matrices.position_node).all():
        return R[:, :3]
    at, _ = among(matrices.position_node, node[moves])
    place = matrices.position[at] - matrices.position.mean(axis=0)
    length = np.abs(place).max(initial=0.0) or 1.0
    for axis in range(3):
        turned = np.column_stack([np.cross(np.eye(3)[axis], place / length), np.zeros_like(place)])
        turned[:, 3 + axis] = 1 / length
        R[moves, 3 + axis] = turned[np.arange(len(turned)), direction[moves]]
    return R


def refuse_unbalanced(gathered: Gathered, bodies: Mapping[str, RigidMotions]) -> list[str]:
    """One line for each part that no contact presses."""
    names = list(bodies)
    ends = np.cumsum([0, *(bodies[name].motions.shape[1] for name in names)])
    spans = {name: slice(*ends[i : i + 2]) for i, name in enumerate(names)}

    def at(name: str, nodes: Integers, directions: int = 3) -> tuple[Floats, Booleans]:
        own, there = bodies[name].at(nodes, directions)
        found = np.zeros((*there.shape, ends[-1]))
        found[:, :, spans[name]] = own
        return found, there

    apart = [np.zeros((0, ends[-1]))]
    for tie in gathered.ties:
        (own, has), (mate, mated) = (
            at(tie.own_part, tie.own_nodes, 6),
            at(tie.mate, tie.mate_nodes, 6),
        )
        apart.append((own - mate)[has & mated])
    R = sl.null_space(np.vstack(apart), rcond=RANK)
    if not R.size or not gathered.contacts or any(each.element for each in gathered.contacts):
        return []
    rows = []
    for each in gathered.contacts:
        moved = at(each.own_part, each.own_nodes)[0]
        if each.mate:
            moved = moved - at(each.mate, each.mate_nodes)[0]
        rows.append(each.frames @ moved)
    G = np.concatenate(rows).reshape(-1, ends[-1]) @ R
    load = np.zeros(ends[-1])
    for push in gathered.loads:
        if push.harmonic == 0:
            load += np.einsum("d,ndm->m", push.vector.real, at(push.part, push.nodes)[0])
    for pull in gathered.forces:
        if pull.harmonic == 0:
            own = bodies[pull.part].forces[pull.digest]
            load[spans[pull.part]] += pull.factor.real * own
    _, size, turns = np.linalg.svd(G, full_matrices=False)
    V = turns[size > RANK * size.max(initial=0.0)].T  # held by contacts alone
    if not V.shape[1]:
        return []
    mu = np.concatenate([each.mu for each in gathered.contacts])
    pressing = _pressing(G @ V, mu, V.T @ (R.T @ load))
    if pressing is None:
        whose = _named(names, spans, R @ V @ (V.T @ (R.T @ load))[:, None])
        raise InputError(
            f"{whose}: held by contacts alone, whose forces cannot balance the static load: it "
            "pushes the part away from them or along them; clamp nodes by fixed, or change loads "
            "with harmonic = 0"
        )
    closed = np.repeat(pressing, 3)
    loose = sl.null_space((G @ V)[closed], rcond=RANK)
    if not loose.shape[1]:
        return []
    whose = _named(names, spans, R @ V @ loose)
    return [f"{whose}: held by contacts alone, which nothing presses: at rest it may lie anywhere"]


def _pressing(rows: Floats, mu: Floats, load: Floats) -> Booleans | None:
    """(c,) contacts that some forces which balance the load press; None if none balance it.

    With s <= n and s <= 1 in units of the load, Σ s is largest where all that can be pressed are.
    """
    from scipy.optimize import linprog  # loaded by those alone who ask

    c, unit = len(mu), np.abs(load).max(initial=0.0) or 1.0
    one, friction = sp.eye_array(c), sp.diags_array(-mu)
    across = [(sign * one, None)[::way] for way in (1, -1) for sign in (1.0, -1.0)]
    bound = sp.block_array(
        [[-one, None, None, one], *([friction, *each, sp.csr_array((c, c))] for each in across)]
    )
    balance = np.hstack([rows[0::3].T, rows[1::3].T, rows[2::3].T, np.zeros((rows.shape[1], c))])
    limits = [(0, None)] * c + [(None, None)] * (2 * c) + [(0, 1)] * c
    cost = np.concatenate([np.zeros(3 * c), -np.ones(c)])
    found = linprog(cost, bound, np.zeros(bound.shape[0]), balance, load / unit, limits)
    if found.status == INFEASIBLE:
        return None
    if found.x is None:  # where the programme is lost, the run says so
        return np.ones(c, bool)
    pressed: Booleans = found.x[3 * c :] > PRESSED
    return pressed


def _named(names: list[str], spans: Mapping[str, slice], motions: Floats) -> str:
    """The components that take part in motions (m, k)."""
    size = {name: np.abs(motions[spans[name]]).max(initial=0.0) for name in names}
    largest = max(size.values())
    return ", ".join(f"components.{n}" for n, each in size.items() if each > RANK * largest)
