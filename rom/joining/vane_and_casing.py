"""Join the reduced vane and casing to the `System` that the harmonic balance solves.

The joined coordinates are the casing's, then the vane's without the key nodes, whose displacements
are the casing's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vanelock.common.arguments import OfKind
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.rom.component import Component
from vanelock.rom.joining.elements import Load, Output
from vanelock.rom.joining.joined import Joined, merged
from vanelock.rom.joining.pairs import Joint, contact_pairs, key_tie
from vanelock.rom.masters import Masters
from vanelock.rom.system.system import Force, System


@dataclass(frozen=True)
class Excitation(OfKind):
    """A radial load on the casing's force nodes, travelling around the ring.

    Attributes
    ----------
    engine_order : int
        EO; negative: a backward wave.
    force : float
        Radial amplitude per node, N.
    unbalance : float
        Or a rotating unbalance of the shaft, kg m, whose force U ω² every force node of the ring
        shares as a pressure that varies with the cosine of the angle; excites EO ±1.
    """

    engine_order: int
    force: float = 0.0
    unbalance: float = 0.0


def joined_dofs(vane: Component, casing: Component) -> NDArray[np.int64]:
    """(vane.size,) joined coordinate of each of the vane's; key nodes share the casing's."""
    tie = key_tie(vane.masters, casing.masters)
    own, mate = vane.dofs(tie.own_nodes).ravel(), casing.dofs(tie.mate_nodes).ravel()
    pairs = np.column_stack([mate, casing.size + own])
    return merged((casing.size, vane.size), [pairs]).places[1]


def split(
    vane: Component, casing: Component, x: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """The vane's and the casing's reduced coordinates in joined ones.

    Parameters
    ----------
    vane, casing : Component
        The parts that were joined.
    x : (n,) or (n, k)
        Joined coordinates.
    """
    return x[joined_dofs(vane, casing)], x[: casing.size]


def joined_stiffness(
    vane: Component, casing: Component, nodal_diameter: int
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """(n, n) stiffness of the vane and of the casing at a nodal diameter, in joined coordinates."""
    dofs, own = joined_dofs(vane, casing), casing.size
    n = max(own, int(dofs.max()) + 1)
    blade, shell = np.zeros((2, n, n), complex)
    blade[np.ix_(dofs, dofs)] = vane.at(nodal_diameter).K
    shell[:own, :own] = casing.at(nodal_diameter).K
    return blade, shell


def join(
    vane: Component,
    casing: Component,
    joints: Sequence[Joint],
    excitation: Excitation,
    damping_ratio: float | None = None,
    diameters: Literal["given", "all"] = "given",
    damping_joints: str = "stuck",
) -> System:
    """Join vane and casing by key ties and contact elements.

    Parameters
    ----------
    vane, casing : Component
        Reduced parts; the system gets the casing's nodal diameters, and their loads at rest where 0
        is among these.
    joints : sequence of Joint
        Joints with contact elements; others stay open.
    excitation : Excitation
        The travelling load.
    damping_ratio : float, optional
        Modal damping ratio ζ.
    diameters : {"given", "all"}
        "all" insists on every nodal diameter 0 ... ⌊N/2⌋, which time integration of the whole ring
        needs.
    damping_joints : {"stuck", "open"}
        As of `System`: the hook is stuck in any case.

    Returns
    -------
    System
        Contacts ordered by joint; the outputs are the output nodes, their displacement in
        (radial, circumferential, axial) components.

    Raises
    ------
    InputError
        If the parts differ in sectors, the casing was reduced in one piece although there are
        several, or a nodal diameter that is insisted on is missing.
    """
    N = vane.masters.sectors
    if N != casing.masters.sectors:
        raise InputError(f"vane and casing differ in sectors: {N}, {casing.masters.sectors}")
    if not casing.cyclic and N > 1:
        raise InputError(
            f"{casing.masters.part}: reduced in one piece, its sides free, while the ring has {N} "
            "sectors: give nodal_diameters to reduce"
        )
    if diameters not in ("given", "all"):
        raise InputError(f"diameters: given {diameters!r}: allowed are 'given' and 'all'")
    if diameters == "all":
        _check_all(casing)
    outputs = [
        Output(
            "outputs",
            name,
            nodes,
            [f"{part.masters.part} output {i + 1}" for i in range(len(nodes))],
            turned=True,
        )
        for name, part in (("vane", vane), ("casing", casing))
        if (nodes := part.masters.node_sets.get("output")) is not None
    ]
    joined = Joined(
        sectors=N,
        engine_order=excitation.engine_order,
        parts={"casing": casing, "vane": vane},
        contacts=contact_pairs(vane.masters, casing.masters, joints),
        ties=(key_tie(vane.masters, casing.masters),),
        loads=(travelling_load(casing.masters, excitation),),
        outputs=outputs,
        always_closed=("hook",),
        damping_ratio=damping_ratio,
        damping_joints=damping_joints,
    )
    system = joined.system(sorted(casing.diameters))
    if 0 not in system.diameters or not (at_rest := rest_loads(vane, casing)):
        return system
    return replace(system, force={0: Force(np.sum(list(at_rest.values()), axis=0)), **system.force})


def rest_loads(vane: Component, casing: Component) -> dict[str, NDArray[np.complex128]]:
    """(n,) of each load at rest that the parts hold, in joined coordinates of nodal diameter 0, N.

    Loads of one name on both parts are one.
    """
    dofs = joined_dofs(vane, casing)
    found: dict[str, NDArray[np.complex128]] = {}
    for part, places in ((casing, np.arange(casing.size)), (vane, dofs)):
        for name, load in (part.loads or {}).items():
            none = np.zeros(max(casing.size, int(dofs.max()) + 1), complex)
            np.add.at(found.setdefault(name, none), places, load)
    return found


def _check_all(casing: Component) -> None:
    """Refuse a casing that lacks a nodal diameter of the ring."""
    N = casing.masters.sectors
    have = {folded(k, N) for k in casing.diameters}
    if missing := [k for k in range(N // 2 + 1) if k not in have]:
        raise InputError(
            f'{casing.masters.part}: diameters = "all" needs nodal diameters 0 to {N // 2}: '
            f"not reduced at {', '.join(map(str, missing))}"
        )


def travelling_load(casing: Masters, excitation: Excitation) -> Load:
    """First harmonic of the excitation, amplitude · e_r(θ) · e^{-i·EO·θ} at each force node."""
    nodes = casing.set("force")
    amplitude, power = excitation.force, 0
    if excitation.unbalance:
        if excitation.force:
            raise InputError("excitation: give force or unbalance, not both")
        if abs(excitation.engine_order) != 1:
            raise InputError(
                f"excitation.unbalance: excites engine order 1 or -1, not {excitation.engine_order}"
            )
        # Σ over the ring of a cos²θ = U ω², θ the angle from the load's direction.
        amplitude, power = 2 * excitation.unbalance / (casing.sectors * len(nodes)), 2
    points = casing.position(nodes)
    theta = np.arctan2(points[:, 1], points[:, 0])
    radial = np.column_stack([np.cos(theta), np.sin(theta), np.zeros(len(nodes))])
    wave = np.exp(-1j * excitation.engine_order * theta)[:, None]
    vector = np.asarray(amplitude * radial * wave, complex)
    return Load("excitation", "casing", nodes, vector, omega_power=power)
