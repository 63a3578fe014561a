"""The Campbell diagram of a run; its lines against the unreduced sector."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import fem, parse_study, run_study
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, Event, Notice
from vanelock.stages.campbell.frequencies import ModesOverSpeed, grid
from vanelock.stages.campbell.speed_lines import Campbell
from vanelock.stages.parts.segment import Segment
from vanelock.stages.response.limits import Limits

HOT = """
[material.vane]
E = [[20, "200 GPa"], [620, "155 GPa"]]
[material.casing]
E = [[20, "200 GPa"], [620, "155 GPa"]]
[temperature]
vane = [[0, 20], [25000, 620]]
casing = [[0, 20], [25000, 320]]
[response]
points = 9
harmonics = 1
mode = 1
[outputs]
show = []
"""
DIAGRAM = """
[campbell]
engine_orders = [2, 10]
modes = 3
"""


TEMPERATURE = "[temperature]\nspeed = 9000"
AS_IT_IS = '[mesh]\ncorrection = "none"\n'


@pytest.fixture(scope="module")
def ran(tmp_path_factory, ring_text):
    folder, heard = tmp_path_factory.mktemp("campbell"), list[Event]()
    run_study(
        parse_study(ring_text("tetra10", COARSER) + AS_IT_IS + HOT + DIAGRAM), folder, heard.append
    )
    with h5py.File(folder / "results.h5") as file:
        found = {
            "diagram": Campbell.load(file["response/nominal/campbell"]),
            "limits": Limits.load(file["limits/all"]),
            "response": Response.load(file["response/nominal"]),
        }
    return folder, heard, found


def test_a_diagram_leaves_the_response_as_it_is(ran, ring_text):
    computed = {event.stage for event in ran[1] if isinstance(event, Done)}
    expected = {f"Campbell response, EO {order}" for order in (1, 2, 10)}
    expected |= {"rom casing, ND 2", "Campbell lines", "figures/campbell.png"}
    assert expected <= computed
    text = ring_text("tetra10", COARSER) + HOT.replace("[temperature]", TEMPERATURE)
    alone, beside = (planned_of(each) for each in (text, text + DIAGRAM))
    assert alone.response.key == beside.response.key


def test_the_response_has_the_temperatures_of_the_crossing_of_interest(ran):
    """Frequency and speed of the free crossing are those of the response's own linear limit."""
    _, heard, found = ran
    lines, limits = found["diagram"].lines, found["limits"]
    (free,) = np.flatnonzero(lines.interest & ~lines.is_stuck)
    assert lines.frequency[free] == pytest.approx(limits.free_frequency, rel=1e-8)
    assert lines.speed[free] == pytest.approx(60 * limits.free_frequency, rel=1e-8)
    (notice,) = [e.text for e in heard if isinstance(e, Notice) and "temperatures" in e.text]
    degrees = 20 + 600 * lines.speed[free] / 25000
    E = 200 - 45 * (degrees - 20) / 600
    assert f"at {lines.speed[free]:,.0f} rpm: vane {degrees:.4g} degC, E = {E:.5g} GPa" in notice


def test_lines_fall_with_the_modulus(ran):
    """Frequencies fall by no more than the moduli's root and some, as springs stay as given."""
    lines = ran[2]["diagram"].lines
    assert lines.engine_orders.tolist() == [1, 2, 10]
    assert lines.diameters.tolist() == [1, 2]  # 10 = 12 - 2
    for values in (lines.free, lines.stuck):
        fall = values[:, -1] / values[:, 0]
        assert fall.max() < 1
        assert fall.min() > (155 / 200) ** 0.5
    np.testing.assert_array_less(lines.free, lines.stuck + 1e-6)


def test_circles_are_the_nonlinear_response_where_it_is(ran):
    """The study's largest is a point of the response, at 60 f; none within its range is linear."""
    diagram, response = ran[2]["diagram"], ran[2]["response"]
    own = diagram.nonlinear
    assert set(diagram.order[own]) == {1}
    top = np.flatnonzero(own)[diagram.amplitude[own].argmax()]
    watched = response.amplitude.reshape(len(response.frequency), -1)
    points, _ = np.nonzero(np.isclose(watched, diagram.amplitude[top], rtol=1e-12))
    assert np.isclose(response.frequency[points], diagram.frequency[top], rtol=1e-14).any()
    assert diagram.speed[top] == pytest.approx(60 * diagram.frequency[top])
    low, high = response.frequency.min(), response.frequency.max()
    within = (diagram.frequency > low) & (diagram.frequency < high) & (diagram.order == 1)
    assert own[within].all()


SPEEDS = (0.0, 20000.0)


def factors(speed):
    """Moduli that fall by a third and by a fifth, the first with a bend."""
    return float(np.interp(speed, [0, 12000, 20000], [1.1, 0.95, 0.75])), 1.05 - 1.1e-5 * speed


@pytest.fixture(scope="module")
def over_speed(scene):
    def build(k=1, moduli=factors):
        casing = replace(scene.casing, diameters={k: scene.casing.at(k)})
        system = Segment(scene.joints, 1, force=1.0).join(scene.vane, casing)
        return ModesOverSpeed(system, {"vane": scene.vane, "casing": casing}, k, moduli, SPEEDS)

    return build


@pytest.mark.parametrize("stuck", [False, True])
def test_crossings_are_those_of_the_unreduced_sector(scene, over_speed, stuck):
    """Sparse matrices assembled with the moduli at the crossing meet its line, within 1e-4."""
    order = 4
    met = over_speed().meetings(order, stuck, 2, grid(*SPEEDS, [12000.0]))
    assert [each.mode for each in met] == [0, 1]
    for each in met:
        assert each.frequency == pytest.approx(order * each.speed / 60, rel=1e-12)
        models = []
        for model, factor in zip(
            (scene.vane_model, scene.casing_model), factors(each.speed), strict=True
        ):
            metal = model.material
            models.append(
                fem.assemble(model.part, fem.Material(factor * metal.E, metal.nu, metal.rho))
            )
        joints = scene.joints if stuck else scene.joints[:1]
        omega2, _ = fem.eigenpairs(*unreduced(*models, joints, 1), 3)
        hertz = np.sqrt(omega2) / (2 * np.pi)
        assert each.frequency == pytest.approx(hertz[each.mode], rel=1e-4)
