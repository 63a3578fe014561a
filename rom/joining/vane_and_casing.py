"""Join the reduced vane and casing to the `System` that the harmonic balance solves.

The joined coordinates are the casing's, then the vane's without the key nodes, whose displacements
are the casing's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.rom.component import Component
from vanelock.rom.joining.pairs import Joint, contact_pairs, key_pairs, merged_dofs, relative_rows
from vanelock.rom.system import Diameter, Force, Matrix, System, common_band


@dataclass(frozen=True)
class Excitation:
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
    own, mate = key_pairs(vane.masters, casing.masters)
    return merged_dofs(vane.size, casing.size, vane.dofs(own).ravel(), casing.dofs(mate).ravel())


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


def join(
    vane: Component,
    casing: Component,
    joints: Sequence[Joint],
    excitation: Excitation,
    damping_ratio: float | None = None,
    diameters: Literal["given", "all"] = "given",
) -> System:
    """Join vane and casing by key ties and contact elements.

    Parameters
    ----------
    vane, casing : Component
        Reduced parts; the system gets the casing's nodal diameters.
    joints : sequence of Joint
        Joints with contact elements; others stay open.
    excitation : Excitation
        The travelling load.
    damping_ratio : float, optional
        Modal damping ratio ζ with all contacts stuck.
    diameters : {"given", "all"}
        "all" insists on every nodal diameter 0 ... ⌊N/2⌋, which time integration of the whole ring
        needs.

    Returns
    -------
    System
        Contacts ordered by joint; the outputs are the accessory nodes, their displacement in
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
    of_vane = joined_dofs(vane, casing)
    n = int(of_vane.max(initial=casing.size - 1)) + 1

    pairs = contact_pairs(vane.masters, casing.masters, joints)
    own, following = relative_rows(
        pairs, lambda nodes: of_vane[vane.dofs(nodes)], casing.dofs, n, N
    )
    output, names = _outputs(vane, casing, of_vane, n)

    c = len(pairs.vane)
    matrices = {}
    for k in sorted(casing.diameters):
        shell, blade = casing.at(k), vane.at(k)
        matrices[k] = Diameter(
            K=_superpose(shell.K, blade.K, of_vane, n),
            M=_superpose(shell.M, blade.M, of_vane, n),
            own=own.toarray().reshape(c, 3, n),
            next=following.toarray().reshape(c, 3, n) if np.any(pairs.next) else None,
            output=output,
        )
    return System(
        sectors=N,
        engine_order=excitation.engine_order,
        diameters=matrices,
        contacts=pairs.contacts,
        force={1: travelling_force(casing, excitation, n)},
        output_names=names,
        damping_ratio=damping_ratio,
        band=common_band((vane.reach, casing.reach)),
    )


def _check_all(casing: Component) -> None:
    """Refuse a casing that lacks a nodal diameter of the ring."""
    N = casing.masters.sectors
    have = {folded(k, N) for k in casing.diameters}
    if missing := [k for k in range(N // 2 + 1) if k not in have]:
        raise InputError(
            f'{casing.masters.part}: diameters = "all" needs nodal diameters 0 to {N // 2}: '
            f"not reduced at {', '.join(map(str, missing))}"
        )


def travelling_force(casing: Component, excitation: Excitation, size: int) -> Force:
    """First harmonic of the excitation, amplitude · e_r(θ) · e^{-i·EO·θ} at each force node."""
    nodes = casing.masters.set("force")
    amplitude, power = excitation.force, 0
    if excitation.unbalance:
        if excitation.force:
            raise InputError("excitation: give force or unbalance, not both")
        if abs(excitation.engine_order) != 1:
            raise InputError(
                f"excitation.unbalance: excites engine order 1 or -1, not {excitation.engine_order}"
            )
        # Σ over the ring of a cos²θ = U ω², θ the angle from the load's direction.
        amplitude, power = 2 * excitation.unbalance / (casing.masters.sectors * len(nodes)), 2
    points = casing.masters.position(nodes)
    theta = np.arctan2(points[:, 1], points[:, 0])
    radial = np.column_stack([np.cos(theta), np.sin(theta), np.zeros(len(nodes))])
    vector = np.zeros(size, complex)
    vector[casing.dofs(nodes)] = (
        amplitude * radial * np.exp(-1j * excitation.engine_order * theta)[:, None]
    )
    return Force(vector, power)


def _superpose(shell: Matrix, blade: Matrix, of_vane: NDArray[np.int64], n: int) -> Matrix:
    joined = np.zeros((n, n), np.result_type(shell, blade))
    joined[: len(shell), : len(shell)] = shell
    joined[np.ix_(of_vane, of_vane)] += blade
    return joined


def _outputs(
    vane: Component, casing: Component, of_vane: NDArray[np.int64], n: int
) -> tuple[NDArray[np.float64] | None, tuple[str, ...]]:
    """Rows of the retained accessory nodes, and their names."""
    rows: list[NDArray[np.float64]] = []
    names: list[str] = []
    for piece in (vane, casing):
        nodes = piece.masters.node_sets.get("accessory")
        if nodes is None:
            continue
        dofs = piece.dofs(nodes) if piece is casing else of_vane[piece.dofs(nodes)]
        points = piece.masters.position(nodes)
        theta = np.arctan2(points[:, 1], points[:, 0])
        for i, angle in enumerate(theta):
            row = np.zeros((3, n))
            c, s = np.cos(angle), np.sin(angle)
            row[:, dofs[i]] = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
            rows.append(row)
            names.append(f"{piece.masters.part} accessory {i + 1}")
    return (np.array(rows) if rows else None), tuple(names)
