"""The unreduced reference of the reductions' benchmark."""

import numpy as np

from benchmarks.rom import reduced


def test_unreduced_truth_and_smaller_models() -> None:
    bench = reduced.Bench("coarse", np.linspace(60.0, 120.0, 4))
    given = {"modes": 10, "interface_modes": 10, "route": "direct"}
    vane, casing, _ = bench.pair(reduced.Setting("", {"modes": 10}, given))
    outcome = bench.compared(vane, casing, 0.0)
    assert bench.sector("stuck", 1).doubt() < 1e-10
    assert bench.doubt_of_response() < 1e-9
    # Ten modes and ten face modes, as published, leave about a per cent on the first ten.
    assert 1e-3 < outcome.worst() < 5e-2
    assert min(error.min() for error in outcome.error.values()) > -1e-9
    # The largest model holds the smaller ones.
    less = {"modes": 6, "interface_modes": 5, "route": "direct"}
    direct = bench.pair(reduced.Setting("", {"modes": 6}, less))
    expected = bench.compared(*direct)
    found = bench.compared(reduced.fewer(vane, 6), reduced.fewer(casing, 6, 5), 0.0)
    for case, error in expected.error.items():
        np.testing.assert_allclose(found.error[case], error, rtol=1e-4, atol=1e-9)
