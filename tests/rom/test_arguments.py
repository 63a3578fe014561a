"""Arguments that `rom.reduce` cannot use: one line that says which, and nothing else."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from vanelock import rom
from vanelock.common.errors import InputError

CYCLIC = {"nodal_diameters": [0, 1]}
PAPER = {**CYCLIC, "route": "paper"}


def refusal(model, *arguments, **options):
    with pytest.raises(InputError) as caught:
        rom.reduce(model, *arguments, **options)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 250
    return text


@pytest.mark.parametrize(
    ("masters", "options", "message"),
    [
        (("forces",), CYCLIC, "ring: no node set 'forces'; it has force, inner"),
        (("left",), CYCLIC, "is a master and on a cyclic face"),
        (("z0",), CYCLIC, "is clamped"),
        (("inner",), CYCLIC, "ring: no node is left beside masters and cyclic faces"),
        (("force",), {**CYCLIC, "averaged": ("force",)}, "no contact patches of 'force'"),
        (("force",), {"nodal_diameters": []}, "nodal_diameters: given none: needs one"),
        (("force",), {**CYCLIC, "modes": -1}, "modes = -1: allowed are 0 and more"),
        (("force",), {**CYCLIC, "modes": 205}, "205 fixed-interface modes of 204 slave dofs"),
        (("force",), {"modes": 10**6}, "1000000 fixed-interface modes of 240 slave dofs"),
        (("force",), {**PAPER, "modes": 169}, "169 fixed-interface modes of 168 slave dofs"),
        (("force",), {"cutoff": 0}, "cutoff = 0 Hz: must be > 0"),
        (("force",), {"cutoff": float("inf")}, "cutoff = inf Hz: must be > 0 and finite"),
        (("force",), {"accuracy": 0.0}, "accuracy = 0: allowed are 1e-9 to 1"),
        (("force",), {"accuracy": 1e-12}, "accuracy = 1e-12: allowed are 1e-9 to 1"),
        (("force",), {"accuracy": 1.0}, "accuracy = 1: allowed are 1e-9 to 1"),
        (("force",), {"band": 0.0}, "band = 0 Hz: must be > 0"),
        (("force",), {"band": -5.0}, "band = -5 Hz: must be > 0"),
        (("force",), {"route": "paper"}, 'route = "paper": a part in one piece has none'),
        (("force",), {"modes": 3, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
        (("force",), {"cutoff": 9.0, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
        (("force",), {**PAPER, "band": 5.0}, "band = 5 Hz: goes with accuracy only"),
        (
            ("force",),
            {"modes": 3, "cutoff": 5.0, "accuracy": 0.1},
            "modes = 3 and cutoff = 5 and accuracy = 0.1: give one of modes, cutoff and accuracy",
        ),
        (("force",), {**PAPER, "accuracy": 0.1}, 'accuracy needs route = "cyclic"'),
        (("force",), {**CYCLIC, "route": "quick"}, "route: given 'quick': needs 'cyclic' or"),
        (("force",), {**PAPER, "interface_modes": 0}, "interface_modes = 0: allowed are 1"),
        (("force",), {**PAPER, "interface_modes": 37}, "allowed are 1 to 36, the dofs of a face"),
        (("force",), {**CYCLIC, "interface_modes": 5}, 'the route "cyclic" has no interface'),
        (("force",), {"interface_modes": 5}, "a part in one piece has no interface"),
    ],
)
def test_message_names_argument_value_and_what_is_allowed(ring_sector, masters, options, message):
    with pytest.raises(InputError, match=message):
        rom.reduce(ring_sector(), masters, **options)
    refusal(ring_sector(), masters, **options)


def test_arguments_at_random_give_a_component_or_one_clear_line(ring_sector):
    """Products of good and bad values: what is not refused is a positive definite model."""
    model, rng = ring_sector(), np.random.default_rng(7)
    good: dict[str, list[Any]] = {
        "masters": [("force",), (), ("force", "force")],
        "modes": [None, None, None, 0, 3, 168],
        "nodal_diameters": [None, [0], [-1, 9], range(3), np.array([4])],
        "route": ["cyclic", "cyclic", "paper"],
        "interface_modes": [None, None, None, None, 1, 8, 36],
        "cutoff": [None, None, None, None, None, 1.0, 3e4, 1e12],
        "accuracy": [None, None, None, None, None, 1e-9, 1e-2, 0.99],
        "band": [None, None, None, None, None, 1e-6, 3e3, 1e9],
    }
    bad: dict[str, list[Any]] = {
        "masters": ["force", ("none",), ("left",), 3],
        "modes": [-2, 1.5, "3"],
        "nodal_diameters": [3, [0.5], "1"],
        "route": ["both", 0],
        "interface_modes": [0, 99, 1e300],
        "cutoff": [-1.0, "x"],
        "accuracy": [2, "x"],
        "band": [0, float("nan")],
    }
    kept, refusals = 0, []
    for _ in range(130):
        chosen = {}
        for name in good:
            pool = bad[name] if rng.random() < 0.03 else good[name]
            chosen[name] = pool[int(rng.integers(len(pool)))]
        masters = chosen.pop("masters")
        try:
            component = rom.reduce(model, masters, **chosen)
        except InputError as error:
            refusals.append(str(error))
            continue
        kept += 1
        for reduced in component.diameters.values():
            assert reduced.K.shape == (component.size, component.size)
            if component.size == 0:
                continue
            scale = 1 / np.sqrt(np.diagonal(reduced.M).real)
            assert np.linalg.eigvalsh(scale[:, None] * reduced.M * scale)[0] > 1e-12
            scale = 1 / np.sqrt(np.diagonal(reduced.K).real)
            assert np.linalg.eigvalsh(scale[:, None] * reduced.K * scale)[0] > -1e-12
    assert min(kept, len(refusals)) > 20
    assert not any("\n" in text for text in refusals)


@pytest.mark.parametrize("masters", [(), ("force",)])
def test_what_is_not_held_is_named(ring_sector, masters):
    """A free ring: without masters nothing holds it, at each diameter of a rigid-body motion."""
    ring = ring_sector(clamped=False)
    if masters:
        assert rom.reduce(ring, masters, 3, nodal_diameters=range(4)).fixed_modes == 3
        return
    for k in (0, 1):
        text = refusal(ring, masters, 3, nodal_diameters=[k])
        assert "ring: free to move as a rigid body: 2 motions not held" in text
        assert f"(at nodal diameter {k}, the masters held)" in text
    assert rom.reduce(ring, masters, 3, nodal_diameters=[2, 3]).fixed_modes == 3
    text = refusal(ring, masters, 3)
    assert "ring: free to move as a rigid body: 6 motions not held" in text


@pytest.mark.parametrize("route", ["cyclic", "paper"])
def test_a_node_without_stiffness_is_named_by_every_route(ring_sector, route):
    model = ring_sector()
    node = model.part.node_sets["inner"][-1]
    kept = np.ones(model.K.shape[0])
    kept[model.dofs[node]] = 0
    K = sp.csc_array(sp.diags_array(kept) @ model.K @ sp.diags_array(kept))
    with pytest.raises(InputError, match=f"ring: 3 motions of some nodes .*: node {node} "):
        rom.reduce(replace(model, K=K), ("force",), 2, nodal_diameters=[1], route=route)
