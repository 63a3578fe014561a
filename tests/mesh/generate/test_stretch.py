"""Casings whose elements are longer around the ring than across it."""

import numpy as np
import pytest

from tests.mesh.conftest import refusal
from vanelock.fem import Material, assemble, modes
from vanelock.mesh import CasingDimensions, HookDimensions, Part, casing_sector
from vanelock.mesh.refinement import check_size

SETS = ("hook_front", "hook_rear", "key", "force", "output")


@pytest.fixture(scope="module")
def drawn() -> Part:
    return casing_sector(size=0.02, stretch=3)


def test_named_nodes_and_patches_lie_where_they_do_without(drawn, coarse) -> None:
    _, usual = coarse
    for name in SETS:
        assert np.array_equal(
            drawn.points[drawn.node_sets[name]], usual.points[usual.node_sets[name]]
        )
    for name, frames in usual.frames.items():
        assert np.array_equal(drawn.frames[name], frames)
    for name, weights in usual.patches.items():
        assert np.abs(weights @ usual.points - drawn.patches[name] @ drawn.points).max() < 1e-9


def test_fewer_unknowns_for_a_smaller_error(drawn) -> None:
    """The first frequencies fall towards the true ones as a mesh gets better."""
    steel = Material(E=170e9, nu=0.3, rho=8200.0)
    usual = casing_sector(size=0.0205, stretch=1)
    assert len(drawn.points) < 0.8 * len(usual.points)
    found, before = (modes(assemble(p, steel), 4, nodal_diameter=1) for p in (drawn, usual))
    assert np.all(found.frequency[:3] < before.frequency[:3])


def test_elements_are_so_unless_there_are_bosses() -> None:
    usual, drawn, bosses = (
        casing_sector(CasingDimensions(bosses=number), size=0.025, stretch=stretch)
        for number, stretch in ((0, None), (0, 3), (1, None))
    )
    assert np.array_equal(usual.points, drawn.points)
    assert len(bosses.points) > 1.5 * len(usual.points)


def test_what_is_refused() -> None:
    said = refusal(lambda: casing_sector(size="coarse", stretch=9))
    assert said.startswith("mesh.stretch = 9: must be a whole number from 1 to 8")
    bosses = CasingDimensions(bosses=2)
    said = refusal(lambda: check_size("coarse", None, bosses, 16, HookDimensions(), 2))
    assert said.startswith("mesh.stretch = 2: only 1 is allowed where casing.bosses")
