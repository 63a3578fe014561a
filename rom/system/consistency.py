"""Whether the parts of a `System` fit together, so that no wrong file gives a converged answer."""

from collections.abc import Collection

import numpy as np

from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.rom.system.system import DAMPING_JOINTS, Contacts, Diameter, Matrix, System

ROUND_OFF = 1e-9
"""Largest deviation of a matrix from symmetry, and of M from being positive, relative to it."""


def check(
    system: System,
    where: str = "system",
    known: Collection[int] = (),
    harmonics: int | None = None,
) -> None:
    """Refuse matrices, contacts and forces that do not fit together."""
    if system.sectors < 1:
        raise InputError(f"{where}: sectors = {system.sectors}: must be at least 1")
    if not system.diameters:
        raise InputError(f"{where}: nd: no matrices of any nodal diameter")
    ratio = system.damping_ratio
    if ratio is not None and not 0 <= ratio < 1:
        raise InputError(f"{where}: damping/ratio = {ratio}: allowed are 0 to 1")
    if system.damping_joints not in DAMPING_JOINTS:
        given, allowed = system.damping_joints, " and ".join(map(repr, DAMPING_JOINTS))
        raise InputError(f"{where}: damping/joints = {given!r}: allowed are {allowed}")
    if system.band is not None and not system.band > 0:
        raise InputError(f"{where}: band = {system.band} Hz: must be > 0")
    _check_contacts(system.contacts, where)
    _check_presence(system, where)
    N, used = system.sectors, set(system.diameters)
    if harmonics is not None:
        used = {system.nodal_diameter(h) for h in range(harmonics + 1)}
    used = {folded(k, N) for k in used}
    for k, matrices in system.diameters.items():
        if k not in known and folded(k, N) in used:
            _check_matrices(
                matrices, system.contacts.count, len(system.output_names), f"{where}: nd/{k}"
            )
    _check_forces(system, where)


def check_ring(system: System, highest: int, whose: str) -> None:
    """Refuse a system that lacks any of the nodal diameters 0 to `highest`, which `whose` needs."""
    have = {folded(k, system.sectors) for k in system.diameters}
    if missing := [k for k in range(highest + 1) if k not in have]:
        named = ", ".join(map(str, missing))
        raise InputError(
            f"system: nd: no matrices for nodal diameters {named}: {whose} needs 0 to {highest}"
        )


def _check_contacts(contacts: Contacts, where: str) -> None:
    c = contacts.count
    shapes: dict[str, tuple[int, ...]] = {"kn": (c,), "kt": (c, 2), "mu": (c,), "v0": (c,)}
    for name, shape in {**shapes, "slider": (c, 2)}.items():
        value = getattr(contacts, name)
        if value.shape != shape:
            raise InputError(f"{where}: contact/{name} has shape {value.shape}, not {shape}")
        if not np.all(np.isfinite(value)):
            raise InputError(f"{where}: contact/{name} holds values that are not finite")
        if name in ("kn", "kt") and np.any(value <= 0):
            raise InputError(f"{where}: contact/{name}: stiffness must be > 0")
        if name == "mu" and np.any(value < 0):
            raise InputError(f"{where}: contact/mu: friction coefficient must be >= 0")
    if contacts.joint and len(contacts.joint) != c:
        raise InputError(f"{where}: contact/joint has {len(contacts.joint)} names, not {c}")


def _check_presence(system: System, where: str) -> None:
    """What one nodal diameter has, every one must have: a missing group is no zero."""
    for name in ("next", "output", "C"):
        have = {k: getattr(found, name) is not None for k, found in system.diameters.items()}
        wanted = any(have.values()) or (name == "output" and bool(system.output_names))
        if wanted and not all(have.values()):
            lacking = min(k for k, present in have.items() if not present)
            raise InputError(f"{where}: nd/{lacking}/{name} is missing, which others have or need")


def _check_matrices(matrices: Diameter, c: int, outputs: int, where: str) -> None:
    n = len(matrices.K)
    shapes = {"K": (n, n), "M": (n, n), "C": (n, n), "own": (c, 3, n), "next": (c, 3, n)}
    shapes["output"] = (outputs, 3, n)
    for name, shape in shapes.items():
        value = getattr(matrices, name)
        if value is None:
            continue
        if value.shape != shape:
            raise InputError(f"{where}/{name} has shape {value.shape}, not {shape}")
        if not np.all(np.isfinite(value)):
            raise InputError(f"{where}/{name} holds values that are not finite")
        if name in ("K", "M", "C"):
            if _largest(value - value.conj().T) > ROUND_OFF * _largest(value):
                raise InputError(f"{where}/{name} is not Hermitian")
    try:
        shift = ROUND_OFF * _largest(matrices.M)
        np.linalg.cholesky(matrices.M + shift * np.eye(n))
    except np.linalg.LinAlgError:
        raise InputError(f"{where}/M is not positive: a mass must be") from None


def _largest(A: Matrix) -> float:
    """Largest real or imaginary part, cheaper than moduli."""
    return float(max(np.abs(A.real).max(initial=0.0), np.abs(A.imag).max(initial=0.0)))


def _check_forces(system: System, where: str) -> None:
    for h, force in system.force.items():
        if h < 0:
            raise InputError(f"{where}: force/{h}: harmonics are 0, 1, 2, ...")
        n = len(system.at(system.nodal_diameter(h)).K)
        if force.vector.shape != (n,):
            raise InputError(f"{where}: force/{h} has shape {force.vector.shape}, not {(n,)}")
        if not np.all(np.isfinite(force.vector)):
            raise InputError(f"{where}: force/{h} holds values that are not finite")
        if h == 0 and np.any(np.imag(force.vector)):
            raise InputError(f"{where}: force/0 is complex: a static load is real")
