"""A vane and its casing of a few hundred dofs: a block that hangs in a clamped rim."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from tests.conftest import scene_of
from vanelock import fem, rom
from vanelock.common.cyclic import turn
from vanelock.mesh.contact_patches import _averages, _Patch, _plane
from vanelock.stages.parts.segment import Joint

N = 8
STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)
HOOK = Joint("hook", kn=2e8, kt=1e8, mu=0.3, interference=1e-6)
LOCK = Joint("interlock", kn=1e7, kt=1e7, mu=0.3, interference=1e-6)
BLOCK = ("key", "hook_front", "hook_rear", "interlock_left", "interlock_right", "output")
RIM = ("key", "hook_front", "hook_rear", "force", "output")


def mates(block, rim, node):
    return np.flatnonzero(np.linalg.norm(rim.points - block.points[node], axis=1) < 1e-12)


def models(lattice, counts):
    """Both models, with all node sets of the scene; contacts join nodes of one place."""

    def wedge(radii, turned=0.1):
        def place(p):
            r = radii[0] + (radii[1] - radii[0]) * p[:, 0]
            angle = 2 * np.pi / N * (p[:, 1] - 0.5) + turned * np.sin(3 * p[:, 2])
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

        return lattice(counts, place, "tetra10", curved=True, sectors=N)

    block, rim = wedge((0.42, 0.5)), wedge((0.5, 0.56))
    inner = np.setdiff1d(
        block.node_sets["x1"], np.concatenate([block.node_sets[name] for name in ("y0", "y1")])
    )
    pairs = [(a, b) for a in inner for b in mates(block, rim, a)]
    own, mate = np.array(pairs).T
    clamped = np.concatenate([rim.node_sets["z0"], rim.node_sets["z1"]])
    inside = ~np.isin(mate, clamped)
    own, mate = own[inside], mate[inside]
    key, front, rear = slice(0, 3), slice(3, 6), slice(6, None)
    lock = [
        np.setdiff1d(block.node_sets[name], block.node_sets["x1"])[::3] for name in ("y0", "y1")
    ]
    frames = {
        "hook_front": np.tile(np.eye(3), (len(own[front]), 1, 1)),
        "hook_rear": np.tile(np.eye(3), (len(own[rear]), 1, 1)),
        "interlock_right": np.tile(np.eye(3)[[1, 0, 2]], (len(lock[1]), 1, 1)),
    }
    sets = {"key": own[key], "hook_front": own[front], "hook_rear": own[rear]}
    vane = replace(
        block,
        name="block",
        frames=frames,
        node_sets=sets
        | {"interlock_left": lock[0], "interlock_right": lock[1], "output": lock[0][:1]},
    )
    sets = {"key": mate[key], "hook_front": mate[front], "hook_rear": mate[rear]}
    outside = np.setdiff1d(
        rim.node_sets["x1"], np.concatenate([clamped, rim.node_sets["y0"], rim.node_sets["y1"]])
    )
    casing = replace(
        rim,
        name="rim",
        node_sets=sets
        | {
            "left": rim.node_sets["y0"],
            "right": rim.node_sets["y1"],
            "z": clamped,
            "force": outside[:2],
            "output": outside[-1:],
        },
    )
    return fem.assemble(vane, STEEL, fixed=None), fem.assemble(casing, STEEL, fixed="z")


def ring_scene(both):
    """What the fixture `scene` has, of the small parts."""
    vane = rom.reduce(both[0], BLOCK)
    casing = rom.reduce(both[1], RIM, nodal_diameters=[0, 1, 2, 4], band=vane.band)
    return scene_of(both, vane, casing, (HOOK, LOCK))


WIDTH, ENDS = np.tan(np.pi / N), (0.02, 0.18)
"""Half of a sector's width, of its distance from the axis; the contacts' ends along the axis, m."""


def _strip(across, ends, axial, x):
    """A rectangle in a plane that holds the axis' direction: at x, or through the axis (x = 0)."""
    planes = [[*-across, -ends[0]], [*across, ends[1]]]
    planes += [[0, 0, -1, -axial[0]], [0, 0, 1, axial[1]]]
    centroid = across * np.mean(ends) + [x, 0, np.mean(axial)]
    area = (ends[1] - ends[0]) * (axial[1] - axial[0])
    return _Patch(np.array(planes, float), area, centroid)


def patched(lattice):
    """Parts of a polygonal ring whose contacts are means over patches, meshed unlike each other."""
    a = np.pi / N
    right = np.array([np.cos(a), np.sin(a), 0.0])
    height = (ENDS[0], sum(ENDS) / 2, ENDS[1])
    y = 0.5 * WIDTH * np.array([-0.6, -0.2, 0.2, 0.6])
    hooks = {
        name: [_strip(np.array([0.0, 1, 0]), ends, axial, 0.5) for ends in pairwise(y)]
        for name, axial in zip(("hook_front", "hook_rear"), pairwise(height), strict=True)
    }
    locks = [_strip(right, (r, r + 0.035), ENDS, 0.0) for r in (0.46, 0.495)]

    def meshed(name, counts, radii, surfaces):
        def place(p):
            x = radii[0] + (radii[1] - radii[0]) * p[:, 0]
            return np.column_stack([x, x * WIDTH * (2 * p[:, 1] - 1), 0.2 * p[:, 2]])

        part = lattice(counts, place, sectors=N)
        sets, weights = {}, {}
        for each, (origin, normal, patches) in surfaces.items():
            face = _plane(part.points, part.cells, origin, normal)
            weights[each] = sp.csc_array(_averages(name, part.points, part.cells, face, patches))
            on = np.flatnonzero(np.abs((part.points - origin) @ normal) < 1e-9)
            apart = part.points[on][:, None] - [patch.centroid for patch in patches]
            sets[each] = on[np.linalg.norm(apart, axis=2).argmin(axis=0)]
        sets["key"] = np.array([sets["hook_front"][1], sets["hook_rear"][1]])
        return replace(part, name=name, node_sets={**part.node_sets, **sets}, patches=weights)

    up, out = np.array([1.0, 0, 0]), np.array([-np.sin(a), np.cos(a), 0.0])
    roof = {name: (0.5 * up, up, patches) for name, patches in hooks.items()}
    back = turn(N).T
    sides = {
        "interlock_right": (np.zeros(3), out, locks),
        "interlock_left": (np.zeros(3), back @ out, [patch.turned(back) for patch in locks]),
    }
    vane = meshed("vane", (2, 4, 3), (0.42, 0.5), {**roof, **sides})
    frames = {name: np.tile(np.eye(3), (3, 1, 1)) for name in hooks}
    frames["interlock_right"] = np.tile(np.array([out, right, [0, 0, 1]]), (2, 1, 1))
    casing = meshed("casing", (1, 5, 4), (0.5, 0.56), roof)
    sets = casing.node_sets
    clamped = np.union1d(sets["z0"], sets["z1"])
    outer = np.setdiff1d(sets["x1"], np.concatenate([clamped, sets["y0"], sets["y1"]]))
    sets = {**sets, "fixed": clamped, "left": sets["y0"], "right": sets["y1"], "force": outer[:2]}
    return replace(vane, frames=frames), replace(casing, node_sets=sets)
