"""Several engine orders, couplings and kinds of friction in runs of a small study."""

import numpy as np
import pytest

from tests.small_study import SMALL
from vanelock import load_system, open_results, parse_study, run_study
from vanelock.common.tables import Table
from vanelock.nonlinear import STUCK, Options, Response, frequency_response
from vanelock.pipeline.progress import Done, Event

pytestmark = pytest.mark.usefixtures("undrawn")

HEAD = f"""{SMALL}
joints.interlock.mu = 0.1
mesh.correction = "none"
outputs = {{ show = [] }}
[response]
harmonics = 1
"""


def run(text, folder):
    heard: list[Event] = []
    found = run_study(parse_study(HEAD + text), folder, heard.append)
    return found, heard


def response(folder, case):
    with open_results(folder / "results.h5") as file:
        return Response.load(file[f"response/{case}"])


def computed(heard):
    return [event.stage for event in heard if isinstance(event, Done) and not event.cached]


def test_engine_orders_are_responses_of_their_own(tmp_path):
    frequencies = "frequencies = [253, 256]\n"
    orders = (-2, 16)
    found, heard = run(f"{frequencies}[sweep]\nexcitation.engine_order = {list(orders)}", tmp_path)
    names = [f"engine_order={order}" for order in orders]
    assert [each.case for each in found] == names
    assert computed(heard).count("rom casing, ND 0") == 1
    table = next(event for event in heard if isinstance(event, Table) and event.key == "cases")
    assert [row[0] for row in table.rows] == names
    assert (tmp_path / "figures" / "response.png").exists()
    for order, name in zip(orders, names, strict=True):
        kept = response(tmp_path, name)
        system = load_system(tmp_path / "results.h5", name)
        assert system.engine_order == order
        assert set(system.diameters) == {0, abs(order) % 16}
        assert kept.harmonic_diameters.tolist() == [0, order % 16]
        assert kept.converged.all()
        again = frequency_response(system, kept.frequency, Options(1))
        np.testing.assert_array_equal(again.contact, kept.contact)
    # A study of one order has the same response, to the last bit.
    together = response(tmp_path, "engine_order=16")
    run(f"{frequencies}[excitation]\nengine_order = 16", tmp_path)
    alone = response(tmp_path, "nominal")
    np.testing.assert_array_equal(together.amplitude, alone.amplitude)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder whose cache several runs share."""
    return tmp_path_factory.mktemp("run")


def test_couplings_and_friction_are_swept_like_numbers(folder):
    text = (
        'frequencies = [256]\n[excitation]\nforce = 30\n[sweep]\n"response.coupling" = '
        '["coupled", "uncoupled", "constant-load"]\n'
        '"response.friction" = ["orthogonal", "isotropic"]'
    )
    found, heard = run(text, folder)
    assert [each.case for each in found] == [
        f"coupling={coupling},friction={friction}"
        for coupling in ("coupled", "uncoupled", "constant-load")
        for friction in ("orthogonal", "isotropic")
    ]
    stages = computed(heard)
    assert stages.count("preload") == 2  # one for each kind of friction
    assert stages.count("linear response, free") == 1
    peaks = {}
    for each in found:
        kept = response(folder, each.case)
        assert kept.converged.all()
        settings = dict(item.split("=") for item in each.case.split(","))
        assert (kept.coupling, kept.friction) == (settings["coupling"], settings["friction"])
        assert kept.samples == 0
        assert np.any(kept.state != STUCK)
        peaks[kept.coupling, kept.friction] = each.peak.amplitude
        with open_results(folder / "results.h5") as file:
            group = file[f"response/{each.case}"]
            assert group.attrs["sweep response.coupling"] == kept.coupling
            static = Response.load(group["preload"])
        assert static.friction == kept.friction
        if kept.coupling != "coupled":
            np.testing.assert_allclose(kept.force[0, 0], static.force[0, 0], atol=1e-6)
    assert len(set(peaks.values())) == 6


def test_samples_of_the_study_reach_the_law(folder):
    run("frequencies = [254]\nsamples = 64", folder)
    kept = response(folder, "nominal")
    assert kept.samples == 64
    system = load_system(folder / "results.h5", "nominal")
    again = frequency_response(system, [254.0], Options(1, samples=64))
    np.testing.assert_array_equal(again.contact, kept.contact)
