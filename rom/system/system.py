"""The door to the nonlinear solver: a sector's reduced matrices and its contacts, arrays only.

In Fourier coefficients q(t) = Re Σ_h q^(h) e^{ihωt}, harmonic h of a wave of engine order EO has
the nodal diameter (h·EO) mod N, and obeys

    [K - (hω)² M + ihω C] x^(h) = f^(h) - B_hᴴ λ^(h),      B_h = own + next e^{-ihφ},  φ = 2π EO/N,

with the matrices of that diameter. B_h takes the sector's coefficients to the relative
displacement (normal, closing positive, and two tangential) of every contact.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import h5py
import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.arrays import Array, Booleans, Complex, Floats, Integers, as_whole, hold_arrays
from vanelock.common.cyclic import phase_factor
from vanelock.common.errors import InputError
from vanelock.common.product import Product, Summarised

if TYPE_CHECKING:
    from vanelock.rom.system.coordinates import Contact
    from vanelock.rom.system.element import Element, Place

Matrix: TypeAlias = Array
"""Real where the physics is, at the nodal diameters 0 and N/2, and complex elsewhere."""

MARGIN = 1.05
"""Of a band over the highest frequency of a response, whose neighbouring modes count too."""
DAMPING_JOINTS = "open", "stuck"


def common_band(bands: Iterable[float | None]) -> float | None:
    """The lowest of some frequencies, Hz, of those that are known; None where none is."""
    return min((band for band in bands if band is not None), default=None)


def conjugated(matrices: Any, names: Sequence[str]) -> dict[str, Any]:
    """Complex conjugates of the fields that are there."""
    given = {name: getattr(matrices, name) for name in names}
    return {name: None if A is None else A.conj() for name, A in given.items()}


def wider_band(highest: float) -> float:
    """A band to reduce to where a response reaches `highest`, Hz: a little more, two digits."""
    step = 10.0 ** (math.floor(math.log10(MARGIN * highest)) - 1)
    return float(f"{math.ceil(MARGIN * highest / step) * step:.6g}")


@dataclass(frozen=True)
class Contacts(Summarised):
    """Contact elements: one node pair each, one normal and two tangential springs.

    Attributes
    ----------
    kn : (c,) float
        Normal stiffness, N/m.
    kt : (c, 2) float
        Tangential stiffness in each direction, N/m.
    mu : (c,) float
        Friction coefficient.
    v0 : (c,) float
        Interference, m; negative: a gap.
    joint : tuple of str
        The joint that each contact belongs to; empty where it is not known.
    always_closed : tuple of str
        Joints that the linear limit "free" keeps closed; it opens all others.
    slider : (c, 2) float
        Where the friction slider of each contact was when it was assembled, m; zeros if not given.
        Static friction is so determined: a contact that never slips holds kt·(displacement -
        slider).
    elements : dict of int to Element
        Those of them, by number, that follow laws of their own; their stiffness is that of the
        springs they are solved around.
    """

    kn: Floats
    kt: Floats
    mu: Floats
    v0: Floats
    joint: tuple[str, ...] = ()
    always_closed: tuple[str, ...] = ()
    slider: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    elements: "Mapping[int, Element]" = field(default_factory=dict)

    def __post_init__(self) -> None:
        hold_arrays(self, {"kn": 1, "kt": 2, "mu": 1, "v0": 1, "slider": 2})
        if not self.slider.size:
            object.__setattr__(self, "slider", np.zeros((self.count, 2)))
        for name in ("kt", "slider"):  # by rows, the one order that kernels are compiled for
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name)))
        for name in ("joint", "always_closed"):
            object.__setattr__(self, name, tuple(getattr(self, name)))

    @property
    def count(self) -> int:
        """Number of contacts c."""
        return len(self.kn)

    @property
    def stiffness(self) -> Floats:
        """(c, 3) stiffness of (normal, t1, t2), N/m."""
        return np.column_stack([self.kn, self.kt])

    @property
    def offset(self) -> Floats:
        """(c, 3) displacement from the assembled sliders when the structure is at its origin, m."""
        return np.column_stack([self.v0, 0.0 - self.slider])

    @property
    def alpha(self) -> Floats:
        """(c, 2) μ kn/kt: a slider slips where its spring is stretched by that times v."""
        return np.asarray((self.mu * self.kn)[:, None] / self.kt)

    def of(self, joint: str) -> Booleans:
        """(c,) contacts of a joint, one of `joints`."""
        return np.array([each == joint for each in self.joints], bool)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joint of each contact, "contact" where that is not known."""
        return self.joint or ("contact",) * self.count

    @property
    def opens(self) -> Booleans:
        """(c,) contacts that the linear limit "free" opens, elements among them."""
        opened = [joint not in self.always_closed for joint in self.joints]
        return np.asarray(np.array(opened, bool) | ~self.springs)

    @property
    def springs(self) -> Booleans:
        """(c,) which are linear springs where they stick: all but elements."""
        springs = np.ones(self.count, bool)
        springs[list(self.elements)] = False
        return springs

    def refuse_elements(self, what: str) -> None:
        """Say that something is of contacts alone.

        Raises
        ------
        InputError
            If there are elements.
        """
        if self.elements:
            name = next(iter(self.elements.values())).name
            raise InputError(f"elements: {name!r}: {what} is of contacts alone")


@dataclass(frozen=True)
class Diameter(Summarised):
    """Matrices of one nodal diameter, in n reduced coordinates.

    Attributes
    ----------
    K, M : (n, n) complex or float
        Hermitian stiffness and mass, N/m and kg (where coordinates are displacements).
    own : (c, 3, n)
        Relative displacement of each contact from this sector's coordinates.
    next : (c, 3, n) or None
        The same from the next sector's coordinates.
    output : (o, 3, n) or None
        Cartesian displacement of the output nodes.
    C : (n, n) or None
        Damping, N s/m, beside the modal one of `System.damping_ratio`.
    parts : dict of str to (r,) int
        Where it is joined of parts: which coordinate each of a part's own is.
    """

    K: Matrix
    M: Matrix
    own: Matrix
    next: Matrix | None = None
    output: Matrix | None = None
    C: Matrix | None = None
    parts: dict[str, Integers] = field(default_factory=dict)

    def __post_init__(self) -> None:
        wanted = {"K": 2, "M": 2, "own": 3, "next": 3, "output": 3, "C": 2}
        hold_arrays(self, wanted, ("next", "output", "C"), is_complex=True)

    def conjugate(self) -> "Diameter":
        """The same structure at the nodal diameter N - k."""
        names = ("K", "M", "own", "next", "output", "C")
        return replace(self, **conjugated(self, names))

    def split(self, x: Matrix) -> dict[str, Matrix]:
        """Each part's own coordinates, (r,) or (r, m), in joined ones, (n,) or (n, m)."""
        return {name: x[places] for name, places in self.parts.items()}

    def joined(self, part: str, matrix: Matrix) -> Matrix:
        """(n, n) a part's matrix (r, r) in joined coordinates."""
        places, n = self.parts[part], len(self.K)
        found = np.zeros((n, n), matrix.dtype)
        found[np.ix_(places, places)] = matrix
        return found


@dataclass(frozen=True)
class Force(Summarised):
    """Excitation of one harmonic, f^(h)(ω) = vector · ω^omega_power.

    Attributes
    ----------
    vector : (n_k,) complex
        One-sided amplitude, N (N s² for an unbalance), in the basis of the harmonic's diameter.
    omega_power : int
        0, or 2 for a rotating unbalance.
    """

    vector: Complex
    omega_power: int = 0

    def __post_init__(self) -> None:
        hold_arrays(self, {"vector": 1}, is_complex=True)
        object.__setattr__(self, "omega_power", as_whole(self.omega_power, "Force.omega_power"))

    def at(self, omega: float) -> Complex:
        """Force vector at the excitation's circular frequency `omega`, rad/s."""
        return self.vector * omega**self.omega_power if self.omega_power else self.vector


@dataclass(frozen=True)
class System(Product):
    """Everything that the harmonic balance of one sector needs.

    Attributes
    ----------
    sectors : int
        N; 1 where there is no symmetry.
    engine_order : int
        EO; negative: a backward wave.
    diameters : dict of int to Diameter
        Matrices by nodal diameter k = (h·EO) mod N; where k is absent and N-k present, its
        conjugate serves.
    contacts : Contacts
        The friction contacts.
    force : dict of int to Force
        Excitation by harmonic; 0 is the static load; a missing harmonic is not loaded.
    output_names : tuple of str
        Names of the output nodes.
    damping_ratio : float or None
        ζ of every mode of the structure whose contacts are as `damping_joints` says.
    damping_joints : {"open", "stuck"}
        Of the contacts that the linear limit "free" opens, in the modes that ζ is of: open, so
        that nothing viscous acts across them, or stuck like all others.
    band : float or None
        Frequency up to which its reduced parts answer, Hz: responses beyond it are refused; None
        where that is not known or nothing was reduced.
    """

    sectors: int
    engine_order: int
    diameters: dict[int, Diameter]
    contacts: Contacts
    force: dict[int, Force] = field(default_factory=dict)
    output_names: tuple[str, ...] = ()
    damping_ratio: float | None = None
    damping_joints: str = "stuck"
    band: float | None = None

    def __post_init__(self) -> None:
        for name in ("sectors", "engine_order"):
            whole = as_whole(getattr(self, name), f"System.{name}")
            object.__setattr__(self, name, whole)
        object.__setattr__(self, "diameters", _by_number(self, "diameters", Diameter))
        object.__setattr__(self, "force", _by_number(self, "force", Force))
        _check_type("System.contacts", self.contacts, Contacts)
        if not isinstance(self.output_names, tuple | list):
            raise InputError(f"System.output_names: given {self.output_names!r}: needs a list")
        object.__setattr__(self, "output_names", tuple(self.output_names))
        numbers = ("damping_ratio", "band")
        hold_arrays(self, dict.fromkeys(numbers, 0), numbers)
        for name in numbers:
            if getattr(self, name) is not None:
                object.__setattr__(self, name, float(getattr(self, name)))

    @classmethod
    def from_matrices(
        cls,
        M: ArrayLike,
        K: ArrayLike,
        contacts: "Sequence[Contact]" = (),
        *,
        elements: "Sequence[Element]" = (),
        C: ArrayLike | None = None,
        damping_ratio: float | None = None,
        force: Mapping[int, complex] | ArrayLike | None = None,
        static_force: Mapping[int, float] | ArrayLike | None = None,
        outputs: "Mapping[str, Place] | None" = None,
    ) -> "System":
        """A structure without symmetry by its matrices, with contacts between its coordinates.

        Parameters
        ----------
        M, K : (n, n) array_like or sparse
            Symmetric mass and stiffness without the contacts, kg and N/m. Every coordinate needs a
            mass; coordinates are counted from 0.
        contacts : sequence of Contact
            What slips, sticks or opens.
        elements : sequence of Element
            What follows a law of its own: springs that are not linear, dampers, stops, sliders.
        C : (n, n) array_like or sparse, optional
            Symmetric viscous damping, N s/m.
        damping_ratio : float, optional
            ζ of every mode of M and K, contacts aside; beside C where both are given.
        force : dict of int to complex, or (n,) array_like, optional
            Amplitudes by coordinate, N: the real part of force e^{iωt} acts.
        static_force : dict of int to float, or (n,) array_like, optional
            Constant forces by coordinate, N.
        outputs : dict of str to place, optional
            Displacements that are answers, places as in `Contact`; by default every coordinate, as
            "x0", "x1", ... Each is the first of an output's three directions:
            `response.amplitude[:, 0, 0]` is that of the first output.

        Raises
        ------
        InputError
            One line: a shape, an unsymmetric matrix, a mass that is not positive, a coordinate that
            does not exist, or a contact that lacks what it needs.
        """
        from vanelock.rom.system.coordinates import assembled

        return assembled(M, K, contacts, elements, C, damping_ratio, force, static_force, outputs)

    @property
    def opens_in_damping(self) -> Booleans:
        """(c,) contacts that are open in the modes that the damping ratio is of."""
        opens = self.contacts.opens if self.damping_joints == "open" else ~self.contacts.springs
        return opens & bool(self.damping_ratio)

    def nodal_diameter(self, harmonic: int) -> int:
        """ND of a harmonic, (h·EO) mod N."""
        return (harmonic * self.engine_order) % self.sectors

    def at(self, nodal_diameter: int) -> Diameter:
        """Matrices of a nodal diameter, conjugated from N - k where only that is stored.

        Raises
        ------
        InputError
            If neither is there.
        """
        if nodal_diameter in self.diameters:
            return self.diameters[nodal_diameter]
        mirrored = (self.sectors - nodal_diameter) % self.sectors
        if mirrored in self.diameters:
            return self.diameters[mirrored].conjugate()
        have = ", ".join(str(k) for k in sorted(self.diameters))
        raise InputError(
            f"system: no matrices for nodal diameter {nodal_diameter} (it holds {have}); "
            "reduce at the diameter of every harmonic used"
        )

    def contact_rows(self, nodal_diameter: int) -> Matrix:
        """B of a diameter, (c, 3, n): own rows plus the next sector's at its phase."""
        matrices = self.at(nodal_diameter)
        if matrices.next is None:
            return matrices.own
        rows: Matrix = matrices.own + matrices.next * phase_factor(nodal_diameter, self.sectors)
        return rows

    def _write(self, group: h5py.Group) -> None:
        from vanelock.rom.system.file import write_system

        write_system(self, group)

    @classmethod
    def _read(cls, group: h5py.Group) -> Self:
        from vanelock.rom.system.file import read_system

        return read_system(cls, group)


def _by_number(system: System, name: str, kind: type) -> dict[int, Any]:
    """A field of the system that holds something for each of some whole numbers."""
    given = getattr(system, name)
    _check_type(f"System.{name}", given, Mapping)
    for key, item in given.items():
        _check_type(f"System.{name}[{key}]", item, kind)
    return {as_whole(key, f"System.{name}"): item for key, item in given.items()}


def _check_type(name: str, value: Any, kind: type) -> None:
    if not isinstance(value, kind):
        raise InputError(f"{name}: given a {type(value).__name__}: needs a {kind.__name__}")
