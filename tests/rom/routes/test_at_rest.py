"""Loads at rest on reduced parts against the full model's static answer."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from vanelock import fem, rom
from vanelock.common.errors import InputError

OPTIONS = ({"accuracy": 1e-4, "band": 3e3}, {"modes": 0}, {"modes": 7})


def three(model):
    """Pressure, heat that varies, rotation."""
    part = model.part
    side = "z1" if "z1" in part.node_sets else "top"
    heat = 1e-3 * (1 + 5 * part.points[:, 2] + part.points[:, 0] ** 2)
    return {
        "gas": fem.pressure(model, side, 2e5),
        "heat": fem.thermal(model, heat),
        "rotation": fem.centrifugal(model, 300.0),
    }


def on_springs(model, masters, seed=3):
    """(n, n) stiffness that holds and couples the masters, and its rows."""
    rows = model.dofs[model.part.node_sets[masters]].ravel()
    G = np.random.default_rng(seed).standard_normal((len(rows), len(rows)))
    A = 1e6 * (G @ G.T + np.eye(len(rows)))
    n = model.K.shape[0]
    S = sp.csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(n, len(rows)))
    return sp.csc_array(S @ sp.csr_array(A) @ S.T), A


@pytest.mark.parametrize("options", OPTIONS, ids=["accuracy", "statics", "modes"])
@pytest.mark.parametrize("fixed", [None, "x0"], ids=["free", "clamped"])
def test_a_part_in_one_piece_answers_loads_at_rest_exactly(bar, options, fixed):
    model = bar(fixed=fixed)
    loads, (springs, A) = three(model), on_springs(model, "held")
    component = rom.reduce(model, ("held",), loads=loads, **options)
    recovery = rom.recovery(component, model)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set("held")).ravel()
    K[np.ix_(rows, rows)] += A
    factor = fem.factorise((model.K + springs).tocsc())
    assert list(component.loads) == ["gas", "heat", "rotation"]
    for name, load in loads.items():
        full = model.field(factor.solve(load))
        found = recovery.displacement(np.linalg.solve(K, component.loads[name]), 0)
        assert np.abs(found - full).max() < 1e-10 * np.abs(full).max(), name


@pytest.mark.parametrize("options", OPTIONS, ids=["accuracy", "statics", "modes"])
def test_a_ring_answers_loads_at_rest_exactly(ring_sector, options):
    model = ring_sector()
    part = model.part
    sets = {**part.node_sets, "top": np.flatnonzero(part.points[:, 2] > 0.2 - 1e-9)}
    model = replace(model, part=replace(part, node_sets=sets))
    loads, (springs, A) = three(model), on_springs(model, "force")
    component = rom.reduce(model, ("force",), nodal_diameters=[0, 1, 3], loads=loads, **options)
    recovery = rom.recovery(component, model)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set("force")).ravel()
    K[np.ix_(rows, rows)] += A
    T = fem.cyclic_transform(model, 0)
    factor = fem.factorise((T.conj().T @ (model.K + springs) @ T).tocsc())
    for name, load in loads.items():
        full = model.field(T @ factor.solve(np.asarray(T.conj().T @ load)))
        found = recovery.displacement(np.linalg.solve(K, component.loads[name]), 0)
        assert np.abs(found - full).max() < 1e-10 * np.abs(full).max(), name
    bare = rom.reduce(model, ("force",), nodal_diameters=[0, 1, 3], **options)
    assert component.size <= bare.size + 3
    assert bare.loads is None


@pytest.mark.parametrize("cyclic", [False, True], ids=["bar", "ring"])
def test_stress_of_heat_is_that_of_the_full_model(bar, ring_sector, cyclic):
    model, name = (ring_sector(), "force") if cyclic else (bar(fixed="x0"), "held")
    growth = 1e-3 * (1 + 5 * model.part.points[:, 2])
    load, (springs, A) = fem.thermal(model, growth), on_springs(model, name)
    kept = {"nodal_diameters": [0]} if cyclic else {}
    component = rom.reduce(model, (name,), modes=4, loads={"heat": load}, **kept)
    K = component.at(0).K.copy()
    rows = component.dofs(component.masters.set(name)).ravel()
    K[np.ix_(rows, rows)] += A
    x = np.linalg.solve(K, component.loads["heat"])
    found = rom.recovery(component, model).stress(x, 0, growth=growth)
    T = sp.csc_array(fem.cyclic_transform(model, 0)) if cyclic else sp.eye_array(len(load))
    factor = fem.factorise(sp.csc_array(T.conj().T @ (model.K + springs) @ T))
    u = np.real(T @ factor.solve(np.asarray(T.conj().T @ load)))
    expected = fem.stress(model, model.field(u), growth)
    inside = np.ones(len(found), bool)
    if cyclic:  # where sectors meet, the mean is over elements of both
        inside[model.part.node_sets["left"]] = inside[model.part.node_sets["right"]] = False
    assert np.abs(found - expected)[inside].max() < 1e-9 * np.abs(expected).max()


def test_masters_answer_exactly_without_further_vectors(bar):
    # K has no term between masters and vectors: what a load hands on to the masters is all.
    model = bar(fixed="x0")
    loads = three(model)
    component = rom.reduce(model, ("held",), modes=0, loads=loads)
    m = 3 * len(component.masters.nodes)
    full = fem.factorise(model.K).solve(loads["heat"])[model.dofs[component.masters.nodes].ravel()]
    found = np.linalg.solve(component.at(0).K[:m, :m], component.loads["heat"][:m])
    np.testing.assert_allclose(found, full, atol=1e-10 * np.abs(full).max())


def test_loads_that_are_combinations_of_others_take_no_vector(bar):
    model = bar(fixed="x0")
    gas, heat, _ = three(model).values()
    both = rom.reduce(model, ("held",), modes=4, loads={"gas": gas, "heat": heat})
    more = {"gas": gas, "heat": heat, "sum": gas + heat, "none": 0 * gas}
    component = rom.reduce(model, ("held",), modes=4, loads=more)
    assert component.size == both.size
    given = component.loads
    scale = np.abs(given["sum"]).max()
    np.testing.assert_allclose(given["sum"], given["gas"] + given["heat"], atol=1e-11 * scale)


def test_heat_grows_with_the_modulus_and_displacements_stay(bar):
    model = bar(fixed="x0")
    loads = three(model)
    component = rom.reduce(model, ("held",), modes=4, loads=loads)
    softer = rom.stiffened(component, 0.7, strained=("heat",))
    metal = replace(model.material, E=0.7 * model.material.E)
    other = fem.assemble(model.part, metal, fixed="x0")
    expected = rom.reduce(other, ("held",), modes=4, loads=three(other))
    for name in expected.loads:
        x = [
            rom.recovery(each, other).displacement(
                np.linalg.solve(each.at(0).K, each.loads[name]), 0
            )
            for each in (softer, expected)
        ]
        assert np.abs(x[0] - x[1]).max() < 1e-9 * np.abs(x[1]).max()


def test_what_cannot_be_answered_is_refused(bar, ring_sector):
    model = bar(fixed="x0")
    good = three(model)["gas"]
    for load, words in (
        (good[:-1], r"loads\['gas'\]: shape .*: needed is .*, the free dofs"),
        (good * np.nan, r"loads\['gas'\]: must be finite"),
    ):
        with pytest.raises(InputError, match=words):
            rom.reduce(model, ("held",), loads={"gas": load})
    ring = ring_sector()
    loads = {"rotation": fem.centrifugal(ring, 10.0)}
    with pytest.raises(InputError, match="act at nodal diameter 0, not at 1, 2"):
        rom.reduce(ring, ("force",), nodal_diameters=[1, 2], loads=loads)
    with pytest.raises(InputError, match='the route "paper" keeps no static answers'):
        rom.reduce(ring, ("force",), nodal_diameters=[0], route="paper", loads=loads)


def test_loads_are_saved_with_the_part(bar, tmp_path):
    model = bar(fixed="x0")
    component = rom.reduce(model, ("held",), modes=4, loads=three(model))
    component.save(tmp_path / "part.h5")
    found = rom.Component.load(tmp_path / "part.h5")
    assert all(np.array_equal(found.loads[k], load) for k, load in component.loads.items())
