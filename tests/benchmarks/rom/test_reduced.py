"""The unreduced reference of the reductions' benchmark."""

import numpy as np
import pytest

from benchmarks.rom import reduced
from benchmarks.segment import MATERIAL
from vanelock import fem, mesh

HOOK = mesh.HookDimensions(band_nodes=3)
VANE = mesh.VaneDimensions(hook=HOOK, aerofoils=1, interlock_nodes=3, root_fillet=0.0)


@pytest.mark.system
def test_unreduced_truth_and_smaller_models(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a vane of one aerofoil, of large elements."""
    vane_part, casing_part = (
        mesh.vane_segment(VANE, size=0.05),
        mesh.casing_sector(hook=HOOK, size=0.05),
    )
    monkeypatch.setattr(reduced, "vane_model", lambda size: fem.assemble(vane_part, MATERIAL))
    monkeypatch.setattr(reduced, "casing_model", lambda size: fem.assemble(casing_part, MATERIAL))
    bench = reduced.Bench(0.05, np.linspace(60.0, 120.0, 4))
    given = {"modes": 10, "interface_modes": 10, "interface": "published"}
    vane, casing, _ = bench.pair(reduced.Setting("", {"modes": 10}, given))
    outcome = bench.compared(vane, casing, 0.0)
    assert bench.sector("stuck", 1).doubt() < 1e-10
    assert bench.doubt_of_response() < 1e-9
    # Ten modes and ten face modes, as published, leave about a per cent on the first ten.
    assert 1e-3 < outcome.worst() < 5e-2
    assert min(error.min() for error in outcome.error.values()) > -1e-9
    # The largest model holds the smaller ones; a mode's sign is free.
    less = {"modes": 6, "interface_modes": 5, "interface": "published"}
    few_of_vane, few_of_casing, _ = bench.pair(reduced.Setting("", {"modes": 6}, less))
    for found, expected in (
        (reduced.fewer(vane, 6), few_of_vane),
        (reduced.fewer(casing, 6, 5), few_of_casing),
    ):
        assert found.diameters.keys() == expected.diameters.keys()
        for k, matrices in expected.diameters.items():
            for name in ("K", "M"):
                own, held = (abs(getattr(of, name)) for of in (matrices, found.diameters[k]))
                scale = np.sqrt(np.outer(own.diagonal(), own.diagonal()))
                np.testing.assert_allclose(held / scale, own / scale, rtol=0, atol=1e-9)
