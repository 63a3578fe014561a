"""Small parts with masters, and dense solutions of what they are joined to."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sl

from tests.conftest import CASING_MASTERS, JOINTS, VANE_MASTERS
from tests.rom import block_in_rim
from vanelock import fem, rom
from vanelock.fem import cyclic_transform
from vanelock.stages.parts.segment import Segment

STEEL = fem.Material(E=200e9, nu=0.3, rho=7800.0)


@pytest.fixture(scope="session")
def bar(lattice):
    """Function that builds a free or clamped bar with the masters "held", some of its nodes."""

    def build(masters=6, seed=0, fixed=None, counts=(5, 2, 1)):
        part = lattice(counts, lambda p: p * [0.5, 0.1, 0.02])
        free = np.arange(len(part.points))
        if fixed:
            free = np.setdiff1d(free, part.node_sets[fixed])
        nodes = np.sort(np.random.default_rng(seed).choice(free, masters, replace=False))
        part = replace(part, name="bar", node_sets={**part.node_sets, "held": nodes})
        return fem.assemble(part, STEEL, fixed=fixed)

    return build


@pytest.fixture(scope="session")
def ring_sector(lattice):
    """Function that builds a sector of a twisted ring with the masters "force"."""

    def build(sectors=8, clamped=True, masters=4, counts=(1, 3, 2)):
        def place(p):
            r, angle = 0.5 + 0.1 * p[:, 0], 2 * np.pi / sectors * (p[:, 1] - 0.5)
            angle = angle + 0.1 * np.sin(3 * p[:, 2])
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0.2 * p[:, 2]])

        part = lattice(counts, place, "tetra10", curved=True, sectors=sectors)
        edge = np.concatenate([part.node_sets[name] for name in ("y0", "y1", "z0")])
        inner = np.setdiff1d(np.arange(len(part.points)), edge)
        sets = {
            "left": part.node_sets["y0"],
            "right": part.node_sets["y1"],
            "z0": part.node_sets["z0"],
            "force": inner[:: max(1, len(inner) // max(masters, 1))][:masters],
            "inner": inner,
        }
        part = replace(part, name="ring", node_sets=sets)
        return fem.assemble(part, STEEL, fixed="z0" if clamped else None)

    return build


def dense(model, masters, nodal_diameter=None):
    """Dense K and M, and the rows of the masters, of a part or of its sector at a diameter."""
    rows = model.dofs[model.part.node_sets[masters]].ravel()
    if nodal_diameter is None:
        return model.K.toarray(), model.M.toarray(), rows
    T = cyclic_transform(model, nodal_diameter).tocsr()
    columns = T.indices[T.indptr[rows]]  # a node off the faces has a coordinate of its own
    K, M = ((T.conj().T @ A @ T).toarray() for A in (model.K, model.M))
    return K, M, columns


def joined(K, M, masters, tie, stiffness, mass):
    """A part whose masters move as `tie` z, with a structure in (z, further coordinates)."""
    r, others = tie.shape[1], np.setdiff1d(np.arange(len(K)), masters)
    further = len(stiffness) - r
    W = np.zeros((len(K), r + len(others)), np.result_type(K, tie))
    W[masters, :r] = tie
    W[others, r + np.arange(len(others))] = 1
    total = []
    for part, structure in ((K, stiffness), (M, mass)):
        A = sl.block_diag(W.conj().T @ part @ W, np.zeros((further, further)))
        place = np.r_[np.arange(r), len(A) - further + np.arange(further)]
        A[np.ix_(place, place)] += structure
        total.append(A)
    return total


def frequencies(K, M, count, shift=50.0):
    """Lowest frequencies, Hz; shifted and inverted, accurate far below the highest one."""
    sigma, n = (2 * np.pi * shift) ** 2, len(K)
    inverse = sl.eigh(
        M, K + sigma * M, eigvals_only=True, subset_by_index=[max(0, n - count), n - 1]
    )[::-1]
    return np.sqrt((1 / inverse - sigma).clip(0)) / (2 * np.pi)


@pytest.fixture(scope="session")
def exact():
    """Dense matrices of parts, of what they are joined to, and their frequencies."""
    return SimpleNamespace(
        dense=dense, joined=joined, frequencies=frequencies, transform=cyclic_transform
    )


@pytest.fixture(scope="session")
def small_ring(lattice):
    """Models of a small ring: a block that hangs in a clamped rim."""
    return block_in_rim.models(lattice, (1, 3, 2))


@pytest.fixture(scope="session")
def ring_scene(small_ring):
    """The small ring reduced and joined, with what the fixture `scene` has."""
    return block_in_rim.ring_scene(small_ring)


@pytest.fixture(scope="session")
def masters_alone(coarse):
    """The coarse vane and casing, joined without a mode: for what masters and contacts say."""
    vane_model, casing_model = (fem.assemble(part, STEEL) for part in coarse)
    vane = rom.reduce(vane_model, VANE_MASTERS, 0)
    casing = rom.reduce(casing_model, CASING_MASTERS, 0, nodal_diameters=[0, 1])
    system = Segment(JOINTS, 1, force=30.0).join(vane, casing)
    return SimpleNamespace(
        vane=vane,
        casing=casing,
        joints=JOINTS,
        system=system,
        joined_dofs=system.at(1).parts["vane"],
    )
