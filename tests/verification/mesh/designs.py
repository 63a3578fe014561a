"""Designs drawn at random in the stated range, meshed and measured; one line of JSON each.

`python designs.py 0 1 2` draws designs 0, 1 and 2 and writes what became of them to the standard
output. A program, not a fixture, so that a crash or a hang inside the mesher ends this process and
not the test that reads its lines.

A design is made of steps: thicknesses, gaps and distances from one surface to the next, which vary
by 30 % about the scene's. Drawing radii by 30 % each would make few that fit into one another; the
stratum "absolute" does that, and shows the refusals.
"""

import json
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import turn
from vanelock.common.errors import InputError
from vanelock.mesh import (
    CasingDimensions,
    HookDimensions,
    Part,
    VaneDimensions,
    casing_sector,
    check_fit,
    hook_overlap,
    quality,
    vane_segment,
)
from vanelock.mesh.checks import _SIZE

Values = dict[str, Any]

STRATA = ("even", "even", "even", "extreme", "extreme", "thin", "tight", "absolute")
"""What designs 0, 1, 2, ... belong to, over and over."""
SPREAD = 0.3
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])  # of a tetrahedron

# The scene's steps, mm: outwards, and from the mid-plane forwards.
OUTWARDS = {
    "hub": 410.0,
    "inner_shroud": 22.0,
    "span": 135.0,
    "outer_shroud": 6.0,
    "neck": 5.0,  # from the outer shroud to the rail
    "lip": 6.0,
    "foot": 8.0,
    "roof": 8.0,
    "shell": 4.0,
    "flange": 21.0,
}
AXIAL = {
    "between_legs": 11.5,
    "leg": 4.5,
    "mouth": 2.0,  # from the leg to the groove's mouth
    "lip_overlap": 8.0,  # from the mouth to the bands
    "toe": 6.0,  # from the bands to the foot's front
    "bottom": 2.0,  # from there to the groove's bottom
    "wall": 8.0,
    "front": 48.0,  # from the rail to the flange
    "rear": 48.0,
    "flange_thickness": 10.0,
    "inner_half": 30.0,  # from the inner shroud's front to the mid-plane
    "overhang": 24.0,  # from the outer shroud's front to the leg
}
PROFILE = {"chord": 47.0, "thickness": 4.5, "edge_thickness": 2.2}
SPACING = 2 * np.pi * 410.0 / 64  # mm between the scene's aerofoils at the hub


@dataclass(frozen=True)
class Design:
    """A number of sectors, an element size and two sets of dimensions, possible or not."""

    number: int
    stratum: str
    sectors: int
    size: str | float
    vane: Values
    hook: Values
    casing: Values


def draw(number: int) -> Design:
    """The design of a number, always the same."""
    random = np.random.default_rng([4711, number])
    stratum = STRATA[number % len(STRATA)]
    sectors, aerofoils = int(random.integers(6, 61)), int(random.integers(1, 9))
    size: str | float = "coarse"
    if random.random() < 0.6:
        size = round(float(random.uniform(0.012, 0.025)), 4)

    def factors(names: Values) -> Values:
        if stratum == "absolute":
            return dict.fromkeys(names, 1.0)
        if stratum == "extreme":
            drawn = random.choice([1 - SPREAD, 1.0, 1 + SPREAD], len(names))
        elif stratum == "thin":
            drawn = np.full(len(names), 1 - SPREAD)
        else:
            drawn = random.uniform(1 - SPREAD, 1 + SPREAD, len(names))
        return dict(zip(names, drawn.tolist(), strict=True))

    out = {name: OUTWARDS[name] * f for name, f in factors(OUTWARDS).items()}
    along = {name: AXIAL[name] * f for name, f in factors(AXIAL).items()}
    if stratum == "tight":  # gaps as small as they may be
        out["neck"] = along["mouth"] = along["bottom"] = 0.6
    profile = {name: PROFILE[name] * f for name, f in factors(PROFILE).items()}
    spacing = 2 * np.pi * out["hub"] / sectors / aerofoils
    profile = {name: min(1.0, spacing / SPACING) * value for name, value in profile.items()}
    room = min(along["inner_half"], along["overhang"] + along["leg"] + along["between_legs"])
    profile["chord"] = min(profile["chord"], 1.75 * room)
    steepest = np.degrees(np.arcsin(min(0.65 * spacing / profile["chord"], 1.0)))
    profile["edge_thickness"] = min(profile["edge_thickness"], profile["thickness"])
    radii, positions = _stacked(out), _positions(along)
    vane = {
        "aerofoils": aerofoils,
        **{name: 1e-3 * value for name, value in profile.items()},
        "camber": float(random.uniform(0.0, 0.2)),
        "stagger": float(random.uniform(-1, 1) * min(50.0, steepest)),
        "twist": float(random.choice([0.0, random.uniform(-10, 10)])),
        "lean": float(random.choice([0.0, _lean(random, spacing, out["span"])])),
        "interlock_nodes": int(random.choice([3, 5, 7, 9])),
        "outer_shroud_extent": float(random.uniform(0.94, 0.98)),
        **{name: positions[name] for name in positions if name in VaneDimensions.model_fields},
        **{name: radii[name] for name in radii if name in VaneDimensions.model_fields},
    }
    vane["interlock_slant"] = vane["stagger"] * float(random.uniform(0.6, 1.3))
    both = {**radii, **positions}
    hook = {name: both[name] for name in both if name in HookDimensions.model_fields}
    hook["band_nodes"] = int(random.choice([9, 15, 21, 31]))
    hook["band_extent"] = float(random.uniform(0.63, 0.93))
    casing = {name: both[name] for name in both if name in CasingDimensions.model_fields}
    casing["force_nodes"] = int(random.choice([4, 16, 25]))
    vane["fillet"] = _fillet(random, along["mouth"], size)
    casing["fillet"] = _fillet(random, along["bottom"], size)
    if random.random() < 0.3:
        casing.update(_bosses(random, out, along, sectors))
    if stratum == "absolute":
        # A few at a time, or none would fit.
        for values in (vane, hook, casing):
            for name in random.choice(sorted(values), 1 + int(random.integers(0, 2))):
                if not isinstance(values[name], int):
                    values[name] *= float(random.uniform(1 - SPREAD, 1 + SPREAD))
    return Design(number, stratum, sectors, size, vane, hook, casing)


def _lean(random: np.random.Generator, spacing: float, span: float) -> float:
    """An angle, deg, that carries the tip by up to 0.3 of the aerofoils' spacing."""
    shift = random.uniform(-0.3, 0.3) * min(spacing, SPACING)
    return float(np.degrees(np.arctan(shift / span)))


def _fillet(random: np.random.Generator, gap: float, size: str | float) -> float:
    """None, or a radius, m, that leaves 0.5 mm of a gap, mm, free and suits the elements' size."""
    least = (0.025 if isinstance(size, str) else size) / _SIZE
    most = 1e-3 * (gap - 0.5)
    wanted = random.random() < 0.5
    return float(random.uniform(least, most)) if wanted and least < most else 0.0


def _bosses(random: np.random.Generator, out: Values, along: Values, sectors: int) -> Values:
    """One to three bosses that have room between flange, force nodes and cyclic faces."""
    count = int(random.integers(1, 4))
    radius = sum(out.values()) - out["flange"] - out["shell"]
    diameter = min(25.0, 0.5 * along["front"], 1.2 * radius * np.pi / sectors / count)
    height = min(10.0, 0.4 * out["flange"])
    position = along["flange_thickness"] + 0.5 * along["front"]
    spread = random.uniform(1 - SPREAD, 1 + SPREAD, 2)
    return {
        "bosses": count,
        "boss_diameter": 1e-3 * diameter * float(spread[0]),
        "boss_height": 1e-3 * height * float(spread[1]),
        "boss_position": 1e-3 * position,
    }


def _stacked(steps: Values) -> Values:
    """Radii, m, by the names of the dimensions."""
    ends = 1e-3 * np.cumsum(list(steps.values()))
    names = [f"{s}_shroud_{w}_radius" for s in ("inner", "outer") for w in ("inner", "outer")]
    names += ["rail_inner_radius", "lip_radius", "roof_radius"]
    names += ["inner_radius", "outer_radius", "flange_radius"]
    return dict(zip(names, ends.tolist(), strict=True))


def _positions(steps: Values) -> Values:
    """Axial positions, m, by the names of the dimensions, the casing's front at zero."""
    names = ["leg_rear", "leg_front", "groove_mouth", "band_position", "foot_front"]
    names += ["groove_bottom", "rail_front", "flange_thickness"]
    order = ("between_legs", "leg", "mouth", "lip_overlap", "toe", "bottom", "wall", "front")
    before = 1e-3 * np.cumsum([steps[name] for name in order])
    middle = before[-1] + 1e-3 * steps["flange_thickness"]
    found = dict(zip(names, (middle - before).tolist(), strict=True))
    found["mid_plane"] = float(middle)
    found["length"] = float(middle + before[-2] + 1e-3 * steps["rear"]) + found["flange_thickness"]
    found["inner_shroud_front"] = float(middle - 1e-3 * steps["inner_half"])
    found["outer_shroud_front"] = found["leg_front"] - 1e-3 * steps["overhang"]
    return found


def outcome(design: Design) -> Values:
    """What became of a design: refused and why, or meshed and how well."""
    start, busy = time.perf_counter(), time.process_time()
    found: Values = {"number": design.number, "stratum": design.stratum}
    try:
        hook = HookDimensions(**design.hook)
        vane = VaneDimensions(**design.vane, hook=hook)
        casing = CasingDimensions(**design.casing)
        check_fit(vane, casing, design.sectors)
        found["refused"] = None
        overlap = hook_overlap(vane, casing)
        parts = (
            vane_segment(vane, design.sectors, design.size, overlap),
            casing_sector(casing, hook, design.sectors, design.size, overlap),
        )
        found.update(_figures(*parts, vane, casing.force_nodes))
    except InputError as error:
        found["refused" if "refused" not in found else "failed"] = str(error)
    found["seconds"] = round(time.perf_counter() - start, 2)
    found["busy"] = round(time.process_time() - busy, 2)
    return found


def _figures(vane: Part, casing: Part, dimensions: VaneDimensions, force_nodes: int) -> Values:
    radius = np.linalg.norm(casing.points[:, :2], axis=1).max()

    def apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        return float(np.abs(a - b).max() / radius)

    def at(part: Part, name: str) -> NDArray[np.float64]:
        return np.asarray(part.points[part.node_sets[name]])

    R = turn(vane.sectors).T
    hooks = ("hook_front", "hook_rear", "key")
    quality_of = [quality(part) for part in (vane, casing)]
    return {
        "counts": _miscounted(vane, casing, dimensions, force_nodes),
        "overlapping": [_overlapping(part) for part in (vane, casing)],
        "mates": max(apart(at(vane, name), at(casing, name)) for name in hooks),
        "interlock": apart(at(vane, "interlock_left") @ R, at(vane, "interlock_right")),
        "faces": apart(at(casing, "left") @ R, at(casing, "right")),
        "patches": max(
            apart(vane.patches[name] @ vane.points, casing.patches[name] @ casing.points)
            for name in hooks[:2]
        ),
        "interlock patches": apart(
            vane.patches["interlock_left"] @ vane.points @ R,
            vane.patches["interlock_right"] @ vane.points,
        ),
        "weights": max(
            float(np.abs(weights.sum(axis=1) - 1).max())
            for part in (vane, casing)
            for weights in part.patches.values()
        ),
        "jacobian": [q.smallest_jacobian for q in quality_of],
        "sicn": [q.smallest_sicn for q in quality_of],
        "volume": [
            q.volume / (part.cad_volume or np.nan) - 1
            for q, part in zip(quality_of, (vane, casing), strict=True)
        ],
        "dofs": [3 * q.nodes for q in quality_of],
        "handles": [handles(vane) - dimensions.aerofoils + 1, handles(casing)],
    }


def _miscounted(
    vane: Part, casing: Part, dimensions: VaneDimensions, force_nodes: int
) -> list[str]:
    """Sets that are missing, or have another number of different nodes than asked for."""
    hooks = dict.fromkeys(("hook_front", "hook_rear"), 2 * dimensions.hook.band_nodes)
    locks = ("interlock_left", "interlock_right")
    expected = (
        {**hooks, "key": 4, **dict.fromkeys(locks, 2 * dimensions.interlock_nodes), "output": 3},
        {**hooks, "key": 4, "force": force_nodes, "output": 3},
    )
    faces = {"left", "right", "fixed"} - set(casing.node_sets)
    return sorted(faces) + [
        f"{part.name} {name}"
        for part, counts in zip((vane, casing), expected, strict=True)
        for name, count in counts.items()
        if {len(part.node_sets[name]), len(np.unique(part.node_sets[name]))} != {count}
    ]


def _overlapping(part: Part) -> int:
    """Nodes that two sets share and should not."""
    alone = [n for n in part.node_sets if n not in ("key", "left", "right", "fixed")]
    nodes = np.concatenate([part.node_sets[name] for name in alone])
    return len(nodes) - len(np.unique(nodes))


def handles(part: Part) -> int:
    """Genus of the surface, from its Euler characteristic; -1 if it is not closed."""
    triangles = np.sort(part.cells[:, FACES].reshape(-1, 3), axis=1)
    found, count = np.unique(triangles, axis=0, return_counts=True)
    surface = found[count == 1]
    sides = surface[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2)
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    if count.max() > 2 or np.any(uses != 2):
        return -1
    return 1 - (len(np.unique(surface)) - len(edges) + len(surface)) // 2


if __name__ == "__main__":
    for number in sys.argv[1:]:
        print(json.dumps(outcome(draw(int(number)))), flush=True)
