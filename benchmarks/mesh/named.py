"""What the sizes with names are off by, and what curved sides and short band elements change."""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.mesh.families import COUNT, SHARP, straightened
from benchmarks.mesh.reference import extrapolated, graded
from benchmarks.segment import CASES, MATERIAL
from benchmarks.unreduced import unreduced_segment as unreduced
from vanelock import fem, mesh
from vanelock.common.errors import InputError
from vanelock.mesh import Part
from vanelock.mesh.generate import mesher
from vanelock.mesh.geometry import contact_places

Floats = NDArray[np.float64]

CORNERS = (0.004, 0.002)  # of the reference meshes, m, and four times that elsewhere
AVERAGED = ("hook_front", "hook_rear", "interlock_left", "interlock_right")
MAKE: dict[str, Callable[..., Part]] = {
    "vane": partial(mesh.vane_segment, SHARP),  # as the reference is
    "casing": mesh.casing_sector,
}


@dataclass(frozen=True)
class Named:
    """One part at one size.

    Attributes
    ----------
    size : str
    dofs, elements : int
    straightened : float
        Share of the elements with a side that is less curved than the geometry.
    frequency : dict of str to (10,) float
        Hz, with "curved" and "straight" sides, and with elements as "long" along the bands as two
        contact nodes are apart, unless that turns some inside out.
    seconds : dict of str to float
        CPU time from the mesh to the modes.
    """

    size: str
    dofs: int
    elements: int
    straightened: float
    frequency: dict[str, Floats]
    seconds: dict[str, float]


def frequencies(part: Part) -> tuple[Floats, float, int]:
    """First elastic modes of the free vane, or those of the casing at one nodal diameter.

    Returns frequencies, Hz, CPU time from the mesh on, s, and the dofs.
    """
    begin = time.process_time()
    model = fem.assemble(part, MATERIAL)
    if part.name == "vane":
        found = fem.modes(model, 6 + COUNT).frequency[6:]
    else:
        found = fem.modes(model, COUNT, nodal_diameter=1).frequency
    return found, time.process_time() - begin, model.K.shape[0]


def named(part: str, size: str | float) -> Named:
    """Curved and straight sides, short and long elements along the bands."""
    own = MAKE[part](size=size)
    parts = {"curved": own, "straight": straightened(own)}
    with patch.object(contact_places, "pieces", lambda *_: 1), suppress(InputError):
        parts["long"] = MAKE[part](size=size)  # at small sizes some are inverted
    found = {name: frequencies(p) for name, p in parts.items()}
    return Named(
        size if isinstance(size, str) else f"{1e3 * size:g} mm",
        found["curved"][2],
        len(own.cells),
        share_straightened(part, own, size),
        {name: f for name, (f, _, _) in found.items()},
        {name: spent for name, (_, spent, _) in found.items()},
    )


def share_straightened(part: str, own: Part, size: str | float) -> float:
    """Share of the elements whose sides were drawn back towards their chords."""
    module = import_module(f"vanelock.mesh.generate.{part}")
    with (
        patch.object(mesher, "LEAST_JACOBIAN", -np.inf),
        patch.object(module, "valid", lambda p: p),
    ):
        bowed = MAKE[part](size=size)
    assert np.array_equal(bowed.cells, own.cells)
    moved = np.linalg.norm(bowed.points - own.points, axis=1) > 1e-9
    return float(moved[own.cells].any(axis=1).mean())


def casing_reference() -> Floats:
    """Of the casing at nodal diameter 1, from two meshes refined towards its corners."""
    found = [frequencies(graded("casing", corner, 4 * corner))[0] for corner in CORNERS]
    print("casing", *found, sep="\n", flush=True)
    return np.asarray(extrapolated(*found))


@dataclass(frozen=True)
class Joined:
    """Second frequency at nodal diameter 1 of vane and casing together, by case, Hz."""

    size: str
    dofs: tuple[int, int]
    second: dict[str, float]


def joined(size: str) -> Joined:
    """Join the program's vane and casing of a size with a name."""
    models = [fem.assemble(make(size=size), MATERIAL) for make in MAKE.values()]
    second = {}
    for case, joints in CASES.items():
        K, M = unreduced(*models, joints, 1, AVERAGED)
        squared, _ = fem.eigenpairs(K, M, 3)
        second[case] = float(np.sqrt(squared[1]) / (2 * np.pi))
    print(size, second, flush=True)
    return Joined(size, (models[0].K.shape[0], models[1].K.shape[0]), second)
