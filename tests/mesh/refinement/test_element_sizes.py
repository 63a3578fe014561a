"""Sizes predicted for a wanted error; docs/benchmarks/mesh_error.md has the meshes they lead to."""

import pytest

from vanelock.common.errors import InputError
from vanelock.mesh import CasingDimensions, HookDimensions, Sizes, VaneDimensions, sizes_for
from vanelock.mesh.refinement import MOST, casing_dofs, vane_dofs

# Sharp roots: fillets have rows that each of the sizes tried would count anew.
VANE, CASING, HOOK = VaneDimensions(root_fillet=0), CasingDimensions(), HookDimensions()
NOW = Sizes(0.0115, 0.0125)
FOUND = {"vane": 0.034, "casing": 0.0125}  # second mode of the joined structure at "medium"


@pytest.mark.parametrize("wanted", [0.04, 0.02, 0.012])
def test_expected_error_is_the_wanted_one_at_the_least_cost(wanted) -> None:
    chosen = sizes_for(wanted, FOUND, NOW, VANE, CASING)
    assert 0.97 * wanted < chosen.error <= wanted
    vane, casing = chosen.sizes.vane, chosen.sizes.casing
    dofs = vane_dofs(VANE, 16, vane) + casing_dofs(CASING, HOOK, 16, casing, chosen.sizes.stretch)
    assert chosen.dofs == pytest.approx(dofs)
    assert dofs <= MOST
    cheaper = sizes_for(1.1 * wanted, FOUND, NOW, VANE, CASING)
    assert cheaper.dofs < chosen.dofs
    least = sizes_for(1e-3, FOUND, NOW, VANE, CASING)  # which no size reaches
    assert least.error > 1e-3
    assert 0.9 * MOST < least.dofs <= MOST


def test_what_is_wanted_is_there_already() -> None:
    bosses = CasingDimensions(bosses=2)
    chosen = sizes_for(0.0465, FOUND, NOW, VANE, bosses)
    assert chosen.sizes.stretch == 1
    now = vane_dofs(VANE, 16, NOW.vane) + casing_dofs(bosses, HOOK, 16, NOW.casing)
    assert chosen.dofs <= 1.01 * now


def test_a_mesh_that_is_given_keeps_its_size_and_error() -> None:
    chosen = sizes_for(0.02, FOUND, NOW, VANE, None)
    assert (chosen.sizes.casing, chosen.sizes.stretch) == (0.0125, 1)
    assert chosen.dofs == pytest.approx(vane_dofs(VANE, 16, chosen.sizes.vane))
    assert sizes_for(0.02, FOUND, NOW, None, CASING).error > FOUND["vane"]


@pytest.mark.parametrize(("wanted", "vane"), [(0.0, 0.1), (float("nan"), 0.1), (0.1, -0.1)])
def test_nonsense_is_refused(wanted, vane) -> None:
    with pytest.raises(InputError, match="must be > 0"):
        sizes_for(wanted, {"vane": vane, "casing": 0.1}, NOW, VANE, CASING)
