"""Arithmetic of the mesh study."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from vanelock.mesh import Part
from vanelock.mesh.generate import extract

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"


@pytest.fixture(scope="module", name="study")
def study_fixture():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        yield [import_module(name) for name in ("mesh_study", "mesh_families", "mesh_reference")]


def test_limit_of_a_power(study):
    _, _, reference = study
    order = reference.ORDER
    values = [3.0 + 0.7 * h**order for h in (0.4, 0.2)]
    assert reference.extrapolated(*values) == pytest.approx(3.0, abs=1e-14)
    values = [3.0 + 0.7 * h**2.0 for h in (0.4, 0.2)]
    assert reference.extrapolated(*values, 2.0) == pytest.approx(3.0, abs=1e-14)


def test_dofs_and_time_for_an_error_follow_power_laws(study):
    program, families, _ = study
    exact = np.arange(1.0, 11.0)
    rows = [
        families.Row("", "", n, 0, np.array([9.0, 0.25, 0.25, 0.5]) * n, exact * (1 + 10 / n))
        for n in (100, 400, 1600)
    ]
    dofs, spent = program.needed(rows, exact, 0.05)
    assert dofs == pytest.approx(200)
    assert spent == pytest.approx(200)  # meshing left out
    assert program.needed(rows, exact, 1e-3) is None
    assert program.needed(rows, exact, 0.2) is None


def test_straightened_sides_are_chords(study, lattice):
    _, families, _ = study

    def bent(p):
        return np.column_stack([p[:, 0], p[:, 1], p[:, 2] + 0.2 * p[:, 0] ** 2])

    curved = lattice((2, 1, 1), bent, "tetra10", True)
    part = Part("bar", curved.points, curved.cells, "tetra10", {}, {}, 1)
    straight = families.straightened(part)
    linear = families.linear(part)
    ends = part.points[part.cells[:, :4]]
    for middle, (a, b) in enumerate(extract.EDGES, start=4):
        chord = 0.5 * (ends[:, a] + ends[:, b])
        np.testing.assert_allclose(straight.points[part.cells[:, middle]], chord, atol=1e-15)
    np.testing.assert_array_equal(linear.points[linear.cells], ends)
    assert abs(straight.points - part.points).max() > 0.01  # 0.2 / 16 where x spans half
