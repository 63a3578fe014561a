"""Contacts on patches converge as the mesh is refined; contacts on nodes do not.

A point of a half-space gives way without bound under a point force, and on a mesh as far as the
mesh resolves it. References are Boussinesq's half-space and the same model on finer meshes. Three
rounds of bisection halve the elements.
"""

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial import cKDTree
from skfem import MeshTet

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.conftest import FULL
from vanelock import fem, mesh
from vanelock.common.cyclic import turn
from vanelock.mesh import HookDimensions, VaneDimensions
from vanelock.mesh import contact_patches as lay
from vanelock.mesh.cells import solid
from vanelock.mesh.contact_patches import _averages, _cylinder, _Patch, _plane
from vanelock.mesh.geometry import contact_places as mesh_sets
from vanelock.rom.routes.problem import with_means
from vanelock.stages.parts.segment import Joint

E, NU, SIDE = 210e9, 0.3, 0.02
OVERLAP = (0.068, 0.082)
COARSE = 0.025 if FULL else 0.05
MODES = 6 if FULL else 3
DESIGN = VaneDimensions() if FULL else VaneDimensions(aerofoils=1, root_fillet=0.0)
HOOKS, INTERLOCK = ("hook_front", "hook_rear"), ("interlock_left", "interlock_right")
HOOK = Joint("hook", 1.67e7, 1.67e7, 0.3, 20e-6)
LOCK = Joint("interlock", 1e6, 1e6, 0.3, 2e-6)
EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])


def numbers(values, form):
    return ", ".join(format(value, form) for value in values)


def block(lattice, count, grade):
    """80 x 80 x 40 mm with a contact node on its top, whose patch is a square of 20 mm.

    `count` boxes a side, the smaller towards the node the larger the grade.
    """

    def place(p):
        t = 2 * p[:, :2] - 1
        return 0.04 * np.column_stack([np.sign(t) * np.abs(t) ** grade, p[:, 2] ** grade])

    part = lattice((count, count, count // 2), place)
    contact = np.flatnonzero(np.linalg.norm(part.points, axis=1) < 1e-12)
    axes = np.vstack([np.eye(3)[:2], -np.eye(3)[:2]])
    square = _Patch(np.column_stack([axes, np.full(4, SIDE / 2)]), SIDE**2, np.zeros(3))
    top = _plane(part.points, part.cells, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    weights = _averages("block", part.points, part.cells, top, [square])
    sets = {"contact": contact}
    part = replace(part, node_sets=sets, patches={"contact": sp.csc_array(weights)})
    return fem.assemble(part, fem.Material(E=E, nu=NU, rho=7850.0)), contact


def half_space(x):
    """Displacement (n, 3) under a unit force spread over the square, by Boussinesq's solution.

    K. L. Johnson, Contact Mechanics, 3.2, summed over Gauss points of the square.
    """
    points, weights = np.polynomial.legendre.leggauss(12)
    total = np.zeros(x.shape)
    for a, w_a in zip(points * SIDE / 2, weights / 2, strict=True):
        for b, w_b in zip(points * SIDE / 2, weights / 2, strict=True):
            d = x - [a, b, 0.0]
            R, z = np.linalg.norm(d, axis=1)[:, None], d[:, 2:]
            flat = z * d[:, :2] / R**3 - (1 - 2 * NU) * d[:, :2] / (R * (R + z))
            total += w_a * w_b * np.hstack([flat, z**2 / R**3 + 2 * (1 - NU) / R])
    return (1 + NU) / (2 * np.pi * E) * total


def test_mean_settlement_of_a_loaded_square(lattice, record):
    """A unit force on a half-space: its own displacement, by patch and by node.

    A uniformly loaded square of side a settles by 0.9464 (1 - ν²)/(E a) on average (Timoshenko and
    Goodier, Theory of Elasticity, 139; in closed form below). The other sides of the block move as
    the half-space does there.
    """
    factor = (2 * np.log(1 + np.sqrt(2)) - 2 / 3 * (np.sqrt(2) - 1)) * 2 / np.pi
    assert factor == pytest.approx(0.9464, abs=1e-4)
    exact = factor * (1 - NU**2) / (E * SIDE)
    counts = (4, 8, 16) if FULL else (4, 8)
    found: dict[str, list[float]] = {"area": [], "node": []}
    for count in counts:
        model, contact = block(lattice, count, 1.0)
        x = model.part.points
        outer = np.any(np.abs(np.abs(x[:, :2]) - 0.04) < 1e-9, axis=1) | (x[:, 2] > 0.04 - 1e-9)
        rows = model.dofs[outer].ravel()
        free = np.setdiff1d(np.arange(model.K.shape[0]), rows)
        for which, nodes in (("area", contact), ("node", contact[:0])):
            _, K, _ = with_means(model, nodes)
            z = np.zeros(K.shape[0])
            z[rows] = half_space(x[outer]).ravel()
            force = np.zeros(K.shape[0])
            force[model.dofs[contact, 2]] = 1.0
            z[free] = fem.factorise(K[free][:, free]).solve((force - K @ z)[free])
            found[which].append(float(z[model.dofs[contact[0], 2]]) / exact)
    record("elements, mm", numbers(80 / np.array(counts), "g"))
    record("settlement of the patch / exact", numbers(found["area"], ".4f"))
    record("of the node / exact", numbers(found["node"], ".3f"))
    error = 1 - np.array(found["area"])
    record("the patch's error falls by", numbers(error[:-1] / error[1:], ".2f"))
    assert np.all(error[:-1] / error[1:] > 3.3)  # second order, up to where the mesh cuts the patch
    assert 0 < error[1] < 0.05
    # The node's settlement is inverse to the element size: there is nothing to converge to.
    assert np.diff(np.log2(found["node"])) == pytest.approx(np.ones(len(counts) - 1), abs=0.01)


def test_block_on_a_spring(lattice, record):
    """Its bounce, with 2e9 N/m in every direction under the patch or under the node."""
    counts = (2, 4, 8, 16) if FULL else (2, 4, 8)
    found: dict[str, list[float]] = {"area": [], "node": []}
    for count in counts:
        model, contact = block(lattice, count, 1.5)
        for which, nodes in (("area", contact), ("node", contact[:0])):
            _, K, M = with_means(model, nodes)
            spring = np.zeros(K.shape[0])
            spring[model.dofs[contact]] = 2e9
            # Below the bounce the block turns about the spring without any force.
            squared, _ = fem.eigenpairs(K + sp.diags_array(spring), M, 6, shift=-1e6)
            found[which].append(float(np.sqrt(squared[3]) / (2 * np.pi)))
            assert np.abs(squared[:3]).max() < 1e-6 * squared[3]
    size = 40 * (2 / np.array(counts)) ** 1.5
    record("elements at the spring, mm", numbers(size, ".1f"))
    drifts = {}
    for which, values in found.items():
        drift = 100 * np.diff(values) / values[1:]
        record(f"{which}, Hz", numbers(values, ".1f"))
        record(f"{which}: drift, %", numbers(drift, ".2f"))
        drifts[which] = np.abs(drift)
    assert np.all(drifts["area"][1:] < 0.5 * drifts["area"][:-1])
    assert np.all(drifts["node"][1:] > drifts["node"][:-1])


def wave(x):
    """A field (...,) of wavelength 0.12 m at places (..., 3)."""
    return np.sin(x @ [20.0, 40.0, 30.0])


def over_bands():
    """Means (30,) of the wave over the front hook's patches, by Gauss points on the cylinders."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    hook = HookDimensions()
    means = []
    for radius, band in zip(
        (hook.roof_radius, hook.lip_radius), mesh_sets.hook_bands(hook, 16)[:2], strict=True
    ):
        angle = np.arctan2(band[:, 1], band[:, 0])
        for start, end in pairwise(nearest(angle)):
            at = (start + end) / 2 + (end - start) / 2 * nodes
            z = np.mean(OVERLAP) + np.ptp(OVERLAP) / 2 * nodes
            at, z = np.meshgrid(at, z)
            means.append(weights @ wave(mesh_sets._cylindrical(radius, at, z)) @ weights / 4)
    return np.array(means)


def over_face():
    """Means (10,) over the left interlock face's patches, by Gauss points between arcs."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    vane, origin = VaneDimensions(), np.array([0.0, 0.0, HookDimensions().mid_plane])
    frame = mesh_sets.interlock_frame(vane, 16)
    slope = np.sin(np.radians(vane.interlock_slant))
    limits = nearest((mesh_sets.interlock_rows(vane, 16)[0] - origin) @ frame[2])

    def arcs(x):
        radii = vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius
        return np.array([np.sqrt(r**2 - (slope * x) ** 2) for r in radii])

    means = []
    for side in (0, 1):
        for ends in pairwise(limits):
            x = np.mean(ends) + np.ptp(ends) / 2 * nodes
            half, edge = np.interp(x, ends, arcs(np.array(ends)).mean(axis=0)), arcs(x)[side]
            y = (half + edge) / 2 + (edge - half) / 2 * nodes[:, None]
            at = origin + x[..., None] * frame[2] + y[..., None] * frame[1]
            share = weights * np.abs(edge - half)
            means.append(weights @ wave(at) @ share / (2 * share.sum()))
    return np.array(means)


def nearest(positions):
    middles = (positions[1:] + positions[:-1]) / 2
    return np.concatenate([positions[:1], middles, positions[-1:]])


def test_means_of_a_wave_over_the_vane_s_patches(record):
    """Nodal values of a wave, averaged by the mesh's weights, against its means on the geometry."""
    sizes = (0.025, 0.0125, 0.00625) if FULL else (0.025, 0.0125)
    errors = []
    for size in sizes:
        part = mesh.vane_segment(DESIGN, size=size)
        field = wave(part.points)
        errors.append(
            [
                np.abs(part.patches[name] @ field - exact).max()
                for name, exact in (("hook_front", over_bands()), ("interlock_left", over_face()))
            ]
        )
    record("element size, mm", numbers(1e3 * np.array(sizes), "g"))
    found = np.array(errors)
    for name, error in zip(("hooks", "interlock"), found.T, strict=True):
        record(f"{name}: largest error / amplitude", numbers(error, ".1e"))
    order = np.log2(found[0] / found[-1]) / (len(sizes) - 1)
    record("order, hooks and interlock", numbers(order, ".1f"))
    assert found[-1].max() < 1e-3
    assert np.all(order > 2)


def bisected(part, sets):
    """A part with the elements bisected that touch a node of some sets; its shape stays the same.

    Bisection spreads to neighbours. Where it cuts the two cyclic faces differently it is repeated.
    """
    near = np.concatenate([part.node_sets[name] for name in sets])
    marked = np.flatnonzero(np.isin(part.cells, near).any(axis=1))
    corners, cells = np.unique(part.cells[:, :4], return_inverse=True)
    cells = cells.reshape(-1, 4)
    coarse = MeshTet(np.array(part.points[corners].T, order="C"), np.array(cells.T, order="C"))
    finer = coarse.refined(marked)
    points, cells = finer.p.T, finer.t.T.astype(np.int64)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    flipped = np.linalg.det(edges) < 0
    cells[flipped] = cells[flipped][:, [0, 2, 1, 3]]
    sides, middle = np.unique(
        np.sort(cells[:, EDGES], 2).reshape(-1, 2), axis=0, return_inverse=True
    )
    cells = np.hstack([cells, len(points) + middle.reshape(-1, 6)])
    straight = np.vstack([points, points[sides].mean(axis=1)])
    points = bent(part, coarse, straight, cells)
    tree = cKDTree(points)
    kept = {n: tree.query(part.points[k]) for n, k in part.node_sets.items() if n in part.frames}
    kept["key"] = tree.query(part.points[part.node_sets["key"]])
    assert max(distance.max() for distance, _ in kept.values()) < 1e-12
    kept = {name: nodes for name, (_, nodes) in kept.items()}
    if part.name == "casing":
        angle, z = np.arctan2(points[:, 1], points[:, 0]), points[:, 2]
        kept["fixed"] = np.flatnonzero(np.minimum(z, 0.2 - z) < 1e-9)
        left, right = (np.flatnonzero(abs(angle - s * np.pi / 16) < 1e-9) for s in (-1, 1))
        gap, mate = cKDTree(points[right]).query(points[left] @ turn(16).T)
        kept |= {"left": left, "right": right[mate]}
    found = replace(part, points=points, cells=cells, node_sets=kept, patches={})
    if part.name == "casing" and (len(left) != len(right) or gap.max() > 1e-9):
        return bisected(found, sets)
    return replace(found, patches=patches(found))


def bent(part, coarse, straight, cells):
    """Places of a finer mesh's nodes in the curved elements of a part, from those in straight ones.

    A piece of a quadratic element is one itself, so that nothing is lost.
    """
    parent = coarse.element_finder()(*straight[cells[:, :4]].mean(axis=1).T)
    nodes = part.cells[parent]
    vertices = np.concatenate([part.points[nodes[:, :4]], np.ones((len(cells), 4, 1))], axis=2)
    places = np.concatenate([straight[cells], np.ones((*cells.shape, 1))], axis=2)
    position = places @ np.linalg.inv(vertices)
    shapes, _ = solid("tetra10").functions(position[..., 1:].reshape(-1, 3))
    shapes = shapes.reshape(*cells.shape, 10)
    points = np.empty_like(straight)
    points[cells] = shapes @ part.points[nodes]
    return points


def patches(part):
    """Weights of a part's contact patches."""
    bands = lay.hook_patches(HookDimensions(), OVERLAP, 16)
    rows = []
    for radius, band in zip((0.592, 0.584, 0.592, 0.584), bands, strict=True):
        facets = _cylinder(part.points, part.cells, radius)
        rows.append(_averages(part.name, part.points, part.cells, facets, band))
    found = {"hook_front": sp.vstack(rows[:2]), "hook_rear": sp.vstack(rows[2:])}
    if part.name == "vane":
        for name, side in zip(INTERLOCK, lay.interlock_patches(VaneDimensions(), 16), strict=True):
            first, normal = part.points[part.node_sets[name][0]], part.frames[name][0, 0]
            facets = _plane(part.points, part.cells, first, normal)
            found[name] = _averages(part.name, part.points, part.cells, facets, side)
    return {name: sp.csc_array(weights) for name, weights in found.items()}


@lru_cache
def sized(size):
    """Both parts with elements of a size, m."""
    return mesh.vane_segment(DESIGN, size=size), mesh.casing_sector(size=size)


@lru_cache
def of_coarse(joints, averaged):
    return frequencies(list(sized(COARSE)), joints, averaged)


def frequencies(parts, joints, averaged):
    """Of the unreduced sector, Hz; those of the coarse parts are kept for the next test."""
    if parts is sized(COARSE):
        return of_coarse(tuple(joints), averaged)
    steel = fem.Material(E=170e9, nu=0.3, rho=8200.0)
    models = [fem.assemble(part, steel) for part in parts]
    squared, _ = fem.eigenpairs(*unreduced(*models, joints, 1, averaged), MODES)
    return np.sqrt(squared) / (2 * np.pi)


@pytest.mark.parametrize("interlock", ["free", "stuck"] if FULL else ["free"])
def test_vane_as_the_elements_at_its_contacts_are_bisected(interlock, record):
    """ND 1 frequencies of the unreduced sector; the rest of the mesh stays coarse.

    Finer elements make the hooks themselves softer too. What nodes add to that is the difference.
    """
    joints, sets = ([HOOK], HOOKS) if interlock == "free" else ([HOOK, LOCK], HOOKS + INTERLOCK)
    parts = sized(COARSE)
    meshes = [parts]
    for _ in range((3 if interlock == "free" else 2) if FULL else 1):
        parts = [  # the vane's front hook alone in a quick run
            bisected(p, [name for name in sets[: None if FULL else 1] if name in p.frames])
            if FULL or p.name == "vane"
            else p
            for p in parts
        ]
        meshes.append(parts)
    area, node = recorded(meshes, joints, sets, record)
    # What nodes lose to patches grows at every level, and ever faster in the mode of interest.
    loss = 1 - node[:, :3] / area[:, :3]
    assert np.all(np.diff(loss, axis=0) > 0)
    if FULL:
        rounds = np.ones(len(area) - 1)
        rounds[0] = 2  # bisected() repeats the first one
        assert np.all(np.diff(np.diff(loss[:, 1]) / rounds) > 0)


def recorded(meshes, joints, sets, record):
    """Frequencies (levels, MODES) with contacts on patches and on nodes, of some meshes."""
    area = np.array([frequencies(parts, joints, sets) for parts in meshes])
    node = np.array([frequencies(parts, joints, ()) for parts in meshes])
    dofs = [3 * sum(len(part.points) for part in parts) for parts in meshes]
    record("dofs", numbers(dofs, "d"))
    for which, values in (("area", area), ("node", node)):
        for mode in range(MODES):
            record(f"{which} f{mode + 1}, Hz", numbers(values[:, mode], ".2f"))
    drift = 100 * np.diff(area[:, 1]) / area[1:, 1]
    record("area f2: drift, %", numbers(drift, ".2f"))
    record("node below area, f2, %", numbers(100 * (1 - node / area)[:, 1], ".3f"))
    return area, node


def test_vane_as_its_whole_mesh_is_refined(record):
    """The same with the interlock free, where all elements shrink, by the square root of 2 a level.

    Unstructured meshes do not halve anything alike, so the steps shrink, but not by one ratio.
    Half a level in a quick run.
    """
    sizes = COARSE / np.sqrt(2) ** (np.arange(4) if FULL else np.array([0, 0.5]))
    meshes = [sized(size) for size in sizes]
    record("element size, mm", numbers(1e3 * sizes, ".1f"))
    area, node = recorded(meshes, [HOOK], HOOKS, record)
    assert np.all(node[:, 1] < area[:, 1])
    drift = np.abs(np.diff(area[:, 1]) / area[1:, 1])
    assert np.all(np.diff(drift) < 0)
    assert drift.max() < 0.03


def test_nominal_vane(record):
    """What patches change at the study's own size, and the stiffness a square metre they mean.

    Nodes are softer than patches, by as much as the elements at the contacts resolve it.
    """
    parts = sized("medium" if FULL else COARSE)
    bands = lay.hook_patches(HookDimensions(), OVERLAP, 16)
    left, _ = lay.interlock_patches(VaneDimensions(), 16)
    for name, patch, stiffness in (("hook", bands[0][3], 1.67e7), ("interlock", left[1], 1e6)):
        record(f"{name}: a patch, mm²", f"{1e6 * patch.area:.1f}")
        record(f"{name}: stiffness per area, N/m³", f"{stiffness / patch.area:.3g}")
    for interlock, joints, sets in (
        ("free", [HOOK], HOOKS),
        ("stuck", [HOOK, LOCK], HOOKS + INTERLOCK),
    ):
        node, area = (frequencies(parts, joints, averaged) for averaged in ((), sets))
        record(f"f2 {interlock}, node and area, Hz", numbers((node[1], area[1]), ".2f"))
        change = np.abs(area / node - 1)
        record(f"largest change of f1 to f{MODES}, {interlock}, %", f"{100 * change.max():.2f}")
        assert change.max() < 0.02
        assert change[1] < 0.01
