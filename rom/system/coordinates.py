"""A `System` of matrices with contacts between their coordinates, and whether one fits together."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arguments import OfKind, of_kind
from vanelock.common.arrays import Complex, Floats, as_array, as_whole
from vanelock.common.cyclic import folded
from vanelock.common.errors import InputError
from vanelock.rom.system.element import Element, Place, spring_along
from vanelock.rom.system.system import DAMPING_JOINTS, Contacts, Diameter, Force, Matrix, System

ROUND_OFF = 1e-9
"""Largest deviation of a matrix from symmetry, and of M from being positive, relative to it."""


def check(
    system: System,
    where: str = "system",
    diameters: Collection[int] = (),
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
        if k not in diameters and folded(k, N) in used:
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
        _check_array(value, shape, f"{where}: contact/{name}")
        if name in ("kn", "kt") and np.any(value <= 0):
            raise InputError(f"{where}: contact/{name}: stiffness must be > 0")
        if name == "mu" and np.any(value < 0):
            raise InputError(f"{where}: contact/mu: friction coefficient must be >= 0")
    if contacts.joint and len(contacts.joint) != c:
        raise InputError(f"{where}: contact/joint has {len(contacts.joint)} names, not {c}")


def _check_array(value: Matrix, shape: tuple[int, ...], name: str) -> None:
    """Refuse another shape than this, and values that are not finite."""
    if value.shape != shape:
        raise InputError(f"{name} has shape {value.shape}, not {shape}")
    if not np.all(np.isfinite(value)):
        raise InputError(f"{name} holds values that are not finite")


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
        _check_array(value, shape, f"{where}/{name}")
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
        _check_array(force.vector, (n,), f"{where}: force/{h}")
        if h == 0 and np.any(np.imag(force.vector)):
            raise InputError(f"{where}: force/0 is complex: a static load is real")


@dataclass(frozen=True, kw_only=True)
class Contact(OfKind):
    """A contact between coordinates of given matrices, for `System.from_matrices`.

    A place is the number of a coordinate, whose displacement counts; a pair of numbers, the first
    coordinate less the second, either of them `None` for the ground; or (n,) factors of all
    coordinates, whose sum counts.

    Attributes
    ----------
    tangential : place, optional
        The displacement that friction acts on. Without it the contact is a stop.
    second : place, optional
        That of the second tangential direction, where there are two.
    normal : place, optional
        The displacement that closes the contact, positive towards each other: (None, 3) where
        coordinate 3 opens it. Without it the normal force is `preload` for good.
    mu : float, optional
        Friction coefficient; goes with `tangential`.
    kt : float or (float, float), optional
        Tangential stiffness in each direction, N/m; goes with `tangential`.
    kn : float, optional
        Normal stiffness, N/m; goes with `normal`.
    preload : float, optional
        Normal force where nothing is displaced, N.
    gap : float, optional
        What has to close before there is a normal force, m, in place of a preload.
    name : str
        Its joint: contacts of one name belong together in tables and parameter studies.

    Raises
    ------
    InputError
        If it lacks what it needs, or a number is impossible.
    """

    tangential: Place | None = None
    second: Place | None = None
    normal: Place | None = None
    mu: float | None = None
    kt: float | tuple[float, float] | None = None
    kn: float | None = None
    preload: float | None = None
    gap: float | None = None
    name: str = "contact"

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        super().__post_init__()
        slides, opens = self.tangential is not None, self.normal is not None
        if not slides and not opens:
            self._refuse("needs tangential or normal, the coordinates that it acts on")
        if self.second is not None and not slides:
            self._refuse("has a second tangential direction without the first, tangential")
        pairs = ("tangential", slides, "mu"), ("tangential", slides, "kt"), ("normal", opens, "kn")
        for place, there, number in pairs:
            if there != (getattr(self, number) is not None):
                self._refuse(f"{place} needs {number}" if there else f"{number} needs {place}")
        if self.preload is not None and self.gap is not None:
            self._refuse(f"preload = {self.preload} and gap = {self.gap}: needs one of them")
        for number, least in (("mu", ">= 0"), ("kt", "> 0"), ("kn", "> 0")):
            self._check(number, least)
        self._check("preload", ">= 0" if opens else "> 0")
        self._check("gap", ">= 0")
        if not opens and self.preload is None:
            self._refuse("needs normal, or a preload that stays as it is")

    def _check(self, name: str, allowed: str) -> None:
        """Refuse a number that is none, or too small."""
        if (given := getattr(self, name)) is None:
            return
        found = np.asarray(given, float)
        if not np.isfinite(found).all() or (found < 0).any() or (allowed == "> 0" and 0 in found):
            self._refuse(f"{name} = {given}: must be {allowed}")

    def _refuse(self, why: str) -> None:
        raise InputError(f"Contact {self.name!r}: {why}")

    @property
    def stiffness(self) -> tuple[float, float, float]:
        """kn, kt1, kt2, N/m; those along which nothing moves are as good as any other."""
        tangential = self.kn if self.kt is None else self.kt
        first, second = np.broadcast_to(np.asarray(tangential, float), 2).tolist()
        return first if self.kn is None else self.kn, first, second

    @property
    def interference(self) -> float:
        """Interference, m; negative: a gap."""
        return -self.gap if self.gap is not None else (self.preload or 0.0) / self.stiffness[0]


@of_kind
def assembled(
    M: ArrayLike,
    K: ArrayLike,
    contacts: Sequence[Contact],
    elements: Sequence[Element],
    C: ArrayLike | None,
    damping_ratio: float | None,
    force: Mapping[int, complex] | ArrayLike | None,
    static_force: Mapping[int, float] | ArrayLike | None,
    outputs: Mapping[str, Place] | None,
) -> System:
    """A system of these, see `System.from_matrices`."""
    stiffness = _matrix("K", K)
    n = len(stiffness)
    mass = _matrix("M", M, n)
    if np.linalg.eigvalsh(mass)[0] <= 0:
        exchanged = "; K is: are they exchanged?" if np.linalg.eigvalsh(stiffness)[0] > 0 else ""
        needs = "every coordinate needs a mass, and every motion"
        raise InputError(f"M: not positive: {needs}{exchanged}")
    count = len(contacts)
    own = np.zeros((count + len(elements), 3, n))
    for i, each in enumerate(contacts):
        for row, name in zip(own[i], ("normal", "tangential", "second"), strict=True):
            if (place := getattr(each, name)) is not None:
                row[:] = _row(place, n, f"contacts[{i}].{name}")
    around = np.zeros((len(elements), 3))
    for i, element in enumerate(elements):
        for j, place in enumerate(element.places):
            own[count + i, j] = row = _row(place, n, f"elements[{i}].places[{j}]")
            around[i, j] = element.stiffness or spring_along(row, stiffness, mass)
        around[i, len(element.places) :] = around[i, 0]  # along which nothing moves
    springs = np.array([each.stiffness for each in contacts], float).reshape(-1, 3)
    springs = np.concatenate([springs, around])
    still = np.zeros(len(elements))
    given = {f"x{i}": i for i in range(n)} if outputs is None else outputs
    output = np.zeros((len(given), 3, n))
    for row, (name, place) in zip(output[:, 0], given.items(), strict=True):
        row[:] = _row(place, n, f"outputs[{name!r}]")
    forces = {0: (static_force, "static_force"), 1: (force, "force")}
    return System(
        sectors=1,
        engine_order=1,
        diameters={
            0: Diameter(
                K=stiffness,
                M=mass,
                own=own,
                output=output,
                C=None if C is None else _matrix("C", C, n),
            )
        },
        contacts=Contacts(
            kn=springs[:, 0],
            kt=springs[:, 1:],
            mu=np.append([each.mu or 0.0 for each in contacts], still),
            v0=np.append([each.interference for each in contacts], still),
            joint=(*(each.name for each in contacts), *(each.name for each in elements)),
            elements={count + i: each for i, each in enumerate(elements)},
        ),
        force={h: Force(_vector(f, n, name)) for h, (f, name) in forces.items() if f is not None},
        output_names=tuple(given),
        damping_ratio=damping_ratio,
        damping_joints="open",
    )


def _matrix(name: str, matrix: Any, size: int | None = None) -> Floats:
    """A symmetric matrix of real numbers."""
    array = as_array(matrix, name)
    if array.ndim != 2 or array.shape[0] != array.shape[1] or not array.size:
        raise InputError(f"{name}: given shape {array.shape}: needs a square matrix")
    if size is not None and len(array) != size:
        raise InputError(f"{name}: given shape {array.shape}: needs that of K, {(size, size)}")
    if not np.isfinite(array).all():
        raise InputError(f"{name}: holds values that are not finite")
    apart = np.abs(array - array.T)
    i, j = np.unravel_index(apart.argmax(), apart.shape)
    if apart[i, j] > ROUND_OFF * np.abs(array).max():
        both = f"{name}[{i}, {j}] = {array[i, j]:g}, {name}[{j}, {i}] = {array[j, i]:g}"
        raise InputError(f"{name}: not symmetric: {both}")
    return np.asarray(array, float)


def _row(displacement: Place, size: int, where: str) -> Floats:
    """(n,) factors of the coordinates that make a displacement."""
    if isinstance(displacement, np.ndarray) and displacement.ndim:
        row = as_array(displacement, where)
        if row.shape != (size,):
            raise InputError(f"{where}: given shape {row.shape}: needs a factor for each of {size}")
        return np.asarray(row, float)
    pair = displacement if isinstance(displacement, tuple) else (displacement, None)
    if len(pair) != 2:
        raise InputError(f"{where}: given {displacement!r}: needs a coordinate, or two of them")
    row = np.zeros(size)
    for number, sign in zip(pair, (1.0, -1.0), strict=True):
        if number is not None:
            row[_coordinate(number, size, where)] += sign
    return row


def _coordinate(number: Any, size: int, where: str) -> int:
    """The number of a coordinate."""
    found = as_whole(number, where)
    if not 0 <= found < size:
        raise InputError(f"{where}: coordinate {found}: there are 0 to {size - 1}")
    return found


def _vector(force: Any, size: int, where: str) -> Complex:
    """(n,) forces by coordinate."""
    if isinstance(force, Mapping):
        found = np.zeros(size, complex)
        for number, value in force.items():
            found[_coordinate(number, size, where)] = as_array(value, where, is_complex=True)
    else:
        found = np.asarray(as_array(force, where, is_complex=True), complex)
    if found.shape != (size,):
        raise InputError(f"{where}: given shape {found.shape}: needs a force for each of {size}")
    return found
