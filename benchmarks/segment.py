"""The vane segment that reductions are measured on, and its unreduced sector.

Vane and casing of examples/vane.toml, hooks as linear springs, the interlock free or stuck. The
sector's frequencies come from shift-invert Lanczos on the sparse matrices, its undamped response
from the modes and, for what they leave, K⁻¹ again and again, which converges as (ω/ω_p)² to the
power of the number of rounds, ω_p the highest mode known.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from benchmarks.unreduced import unreduced_segment
from vanelock import fem, mesh, rom
from vanelock.stages.parts.segment import Joint

Floats = NDArray[np.float64]

MATERIAL = fem.Material(E=170e9, nu=0.3, rho=8200)
HOOK = Joint("hook", kn=1.67e7, kt=1.67e7, mu=0.3, interference=20e-6)
INTERLOCK = Joint("interlock", kn=1e6, kt=1e6, mu=0.15, interference=2e-6)
JOINTS = (HOOK, INTERLOCK)
CASES = {"free": (HOOK,), "stuck": JOINTS}
SETS = ("hook_front", "hook_rear", "key")
VANE_MASTERS = (*SETS, "interlock_left", "interlock_right", "output")
CASING_MASTERS = (*SETS, "force", "output")
MODES = 24  # of the unreduced sector
COUNT = 10  # of them compared
ROUNDS = 60


def vane_model(size: str | float) -> fem.Model:
    """The vane."""
    return fem.assemble(mesh.vane_segment(size=size), MATERIAL)


def casing_model(size: str | float) -> fem.Model:
    """The casing's sector."""
    return fem.assemble(mesh.casing_sector(size=size), MATERIAL)


def closed(system: rom.System, case: str) -> NDArray[np.bool_]:
    """Contacts that act as springs."""
    return np.isin(system.contacts.joint, [joint.name for joint in CASES[case]])


class Sector(NamedTuple):
    """The unreduced sector at a nodal diameter.

    Attributes
    ----------
    K, M : (n, n) sparse
        Its matrices.
    factor : fem.Factor
        Of K.
    frequency, shapes : (p,) and (n, p)
        Its modes, Hz and mass-normalised.
    """

    K: sp.csc_array
    M: sp.csc_array
    factor: fem.Factor
    frequency: Floats
    shapes: NDArray[np.complex128]

    def doubt(self) -> float:
        """Largest relative difference of the first frequencies from those about another shift."""
        shift = -((2 * np.pi * self.frequency[0]) ** 2)
        squared, _ = fem.eigenpairs(self.K, self.M, COUNT, shift=shift)
        return float(np.max(abs(np.sqrt(squared) / (2 * np.pi) / self.frequency[:COUNT] - 1)))

    def response(
        self, frequencies: Floats, force: NDArray[np.complex128]
    ) -> NDArray[np.complex128]:
        """(n, k) undamped displacement under a load at each frequency below the modes known."""
        X, squared = self.shapes, (2 * np.pi * self.frequency) ** 2
        omega = (2 * np.pi * frequencies) ** 2
        share = X.conj().T @ force
        modal = X @ (share[:, None] / (squared[:, None] - omega))
        rest = force - self.M @ (X @ share)
        x = np.zeros_like(modal)
        for _ in range(ROUNDS):
            previous, x = x, self.factor.solve(rest[:, None] + omega * (self.M @ x))
            x -= X @ (X.conj().T @ (self.M @ x))
            if abs(x - previous).max() < 1e-14 * abs(x + modal).max():
                break
        return np.asarray(modal + x)

    def doubt_of_response(
        self, frequency: float, force: NDArray[np.complex128], x: NDArray[np.complex128]
    ) -> float:
        """Relative difference of a response from a solution with the indefinite K - ω²M."""
        D = sp.csc_array(self.K - (2 * np.pi * frequency) ** 2 * self.M)
        direct = splu(D.astype(complex)).solve(force)
        return float(abs(x - direct).max() / abs(direct).max())


def unreduced(vane: fem.Model, casing: fem.Model, case: str, diameter: int) -> Sector:
    """The sector with its modes."""
    K, M = unreduced_segment(vane, casing, CASES[case], diameter)
    factor = fem.factorise(K)
    squared, shapes = fem.eigenpairs(K, M, MODES, factor=factor)
    return Sector(K, M, factor, np.sqrt(squared) / (2 * np.pi), shapes)


class Places:
    """Where the masters that carry loads and outputs stand in the unreduced sector.

    Its coordinates are the casing's, then the vane's without the key nodes.
    """

    def __init__(self, vane: fem.Model, casing: fem.Model, diameter: int) -> None:
        T = sp.csr_array(fem.cyclic_transform(casing, diameter))
        self.size = T.shape[1] + vane.K.shape[0] - vane.rows("key").size
        self.loaded = T.indices[T.indptr[casing.rows("force")]]
        of_casing = T.indices[T.indptr[casing.rows("output")]]
        kept = np.setdiff1d(np.arange(vane.K.shape[0]), vane.rows("key"))
        of_vane = T.shape[1] + np.searchsorted(kept, vane.rows("output"))
        self.outputs = np.concatenate([of_vane, of_casing])
        nodes = [(p, p.node_sets["output"]) for p in (vane.part, casing.part)]
        points = np.concatenate([part.points[of] for part, of in nodes])
        self.angles = np.arctan2(points[:, 1], points[:, 0])

    def load(self, system: rom.System, casing: rom.Component) -> NDArray[np.complex128]:
        """(n,) the system's load."""
        force = np.zeros(self.size, complex)
        dofs = casing.dofs(casing.masters.set("force"))
        force[self.loaded] = system.force[1].vector[dofs]
        return force

    def output(self, x: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """(k, o, 3) radial, circumferential and axial displacement of the outputs."""
        u = x[self.outputs]
        c, s = np.cos(self.angles)[:, None], np.sin(self.angles)[:, None]
        radial, around = c * u[:, 0] + s * u[:, 1], c * u[:, 1] - s * u[:, 0]
        return np.stack([radial, around, u[:, 2]], axis=1).transpose(2, 0, 1)
