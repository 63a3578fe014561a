"""The Campbell diagram of a run on a small ring, and a system made anew to compare with."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import parse_study, run_study
from vanelock.nonlinear import Response, linear_response
from vanelock.pipeline.progress import Done, Event, Notice
from vanelock.stages.campbell.speed_lines import Campbell, _of_order, _with_unbalance, lines_step
from vanelock.stages.parts.segment import Segment, segment_of
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
    """A run with a diagram: folder, events, the products."""
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


def test_a_linear_circle_by_a_dense_solve(scene):
    """The response to another engine order, C from all modes of the open structure."""
    study = parse_study('[ring]\nsectors = 12\n[excitation]\nunbalance = "1.5 kg*mm"')
    bare = replace(segment_of(study), joints=scene.joints)
    nodes = len(scene.casing_model.part.node_sets["force"])
    joined = _of_order(bare, 2, nodes, 12).join(scene.vane, scene.casing)
    system = _with_unbalance(joined, bare)
    assert system.engine_order == 2
    D, f = system.at(2), 273.0
    n, omega = len(D.K), 2 * np.pi * f
    B = system.contact_rows(2)
    stiffness = system.contacts.stiffness.ravel()

    def with_springs(closed):
        rows = B[closed].reshape(-1, n)
        return D.K + (rows.conj().T * stiffness[np.repeat(closed, 3)]) @ rows

    closed = ~system.contacts.opens
    squared, V = sl.eigh(with_springs(closed), D.M)
    MV = D.M @ V
    C = (MV * (2 * 0.003 * np.sqrt(squared))) @ MV.conj().T
    # Every force node of the ring of 12 shares U ω² as a pressure with the angle's cosine.
    per_node = 2 * 1.5e-3 / (12 * nodes) * omega**2
    unit = Segment(scene.joints, 2, force=1.0).join(scene.vane, scene.casing).force[1]
    matrix = with_springs(closed) - omega**2 * D.M + 1j * omega * C
    x = np.linalg.solve(matrix, per_node * unit.vector)
    expected = np.abs(D.output @ x)
    found = linear_response(system, [f], closed)
    np.testing.assert_allclose(found.amplitude[0], expected, rtol=1e-7)


@pytest.mark.parametrize("rom_table", ['route = "paper"', "modes = 12"])
def test_other_reductions_give_the_same_diagram(ran, stages, ring_text, rom_table):
    """Twelve modes a part instead of six, and Tran's faces, differ by less than a per cent."""
    text = ring_text("tetra10", COARSER).partition("[rom]")[0] + f"[rom]\n{rom_table}\n{AS_IT_IS}"
    planned = planned_of(text + HOT.replace("[temperature]", TEMPERATURE) + DIAGRAM)
    lines = stages.get(lines_step(planned))
    expected = ran[2]["diagram"].lines
    assert lines.diameters.tolist() == expected.diameters.tolist()
    for own, other in ((lines.free, expected.free), (lines.stuck, expected.stuck)):
        second = [
            np.interp(10000.0, each.speeds, values[0, :, 1])
            for each, values in ((lines, own), (expected, other))
        ]
        assert second[0] == pytest.approx(second[1], rel=0.01)
