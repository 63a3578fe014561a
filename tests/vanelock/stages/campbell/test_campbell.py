"""Campbell diagrams of whole runs on the coarsest mesh, and a system made anew to compare with."""

import csv

import h5py
import numpy as np
import pytest
import scipy.linalg as sl

from vanelock import parse_study, rom, run_study
from vanelock.common.tables import Table
from vanelock.nonlinear import Response, linear_response
from vanelock.pipeline.progress import Done, Event, Notice
from vanelock.stages.campbell.campbell import Campbell
from vanelock.stages.campbell.engine_orders import joined_at
from vanelock.stages.campbell.speed_lines import at_diameter
from vanelock.stages.parts.systems import joining
from vanelock.stages.response.limits import Limits

HOT = """
[material.vane]
E_at = [[20, "200 GPa"], [620, "155 GPa"]]
[material.casing]
E_at = [[20, "200 GPa"], [620, "155 GPa"]]
[temperature]
vane = [[0, 20], [25000, 620]]
casing = [[0, 20], [25000, 320]]
[mesh]
size = "coarse"
correction = "none"
[response]
points = 9
harmonics = 1
[outputs]
shapes = false
loops = false
report = false
"""
DIAGRAM = """
[campbell]
engine_orders = [2, 14]
modes = 3
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run without and then with a diagram: folder, events of both, the products."""
    folder = tmp_path_factory.mktemp("campbell")
    heard: list[list[Event]] = [[], []]
    run_study(parse_study(HOT), folder, heard[0].append)
    run_study(parse_study(HOT + DIAGRAM), folder, heard[1].append)
    with h5py.File(folder / "results.h5") as file:
        found = {
            "diagram": Campbell.load(file["campbell/nominal"]),
            "limits": Limits.load(file["limits/all"]),
            "response": Response.load(file["response/nominal"]),
        }
    return folder, heard, found


def test_a_diagram_leaves_the_response_as_it_is(ran):
    _, (_, second), _ = ran
    computed = {event.stage for event in second if isinstance(event, Done) and not event.cached}
    expected = {f"Campbell response, EO {order}" for order in (1, 2, 14)}
    expected |= {"rom casing, ND 2", "Campbell lines", "figures/campbell.png"}
    assert expected <= computed
    others = ("mesh", "rom vane", "response", "linear", "preload")
    assert [stage for stage in computed if stage.startswith(others)] == []


def test_the_response_has_the_temperatures_of_the_crossing_of_interest(ran):
    """Frequency and speed of the free crossing are those of the response's own linear limit."""
    _, (first, _), found = ran
    lines, limits = found["diagram"].lines, found["limits"]
    (free,) = np.flatnonzero(lines.interest & ~lines.is_stuck)
    assert lines.frequency[free] == pytest.approx(limits.free_frequency, rel=1e-8)
    assert lines.speed[free] == pytest.approx(60 * limits.free_frequency, rel=1e-8)
    (notice,) = [e.text for e in first if isinstance(e, Notice) and "temperatures" in e.text]
    degrees = 20 + 600 * lines.speed[free] / 25000
    E = 200 - 45 * (degrees - 20) / 600
    assert f"at {lines.speed[free]:,.0f} rpm: vane {degrees:.4g} degC, E = {E:.5g} GPa" in notice


def test_lines_fall_with_the_modulus(ran):
    """Frequencies fall by no more than the moduli's root and some, as springs stay as given."""
    lines = ran[2]["diagram"].lines
    assert lines.engine_orders.tolist() == [1, 2, 14]
    assert lines.diameters.tolist() == [1, 2]  # 14 = 16 - 2
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
    assert diagram.frequency[top] in response.frequency[points]
    assert diagram.speed[top] == pytest.approx(60 * diagram.frequency[top])
    low, high = response.frequency.min(), response.frequency.max()
    within = (diagram.frequency > low) & (diagram.frequency < high) & (diagram.order == 1)
    assert own[within].all()


def test_tables_and_files(ran):
    folder, (_, second), found = ran
    (table,) = [e for e in second if isinstance(e, Table) and e.key == "crossings"]
    lines = found["diagram"].lines
    assert len(table.rows) == len(lines.speed)
    assert sum(bool(row[-1]) for row in table.rows) == 2
    assert (folder / "figures" / "campbell.png").stat().st_size > 20_000
    rows = (folder / "figures" / "campbell_lines.csv").read_text("utf-8").splitlines()
    header, *values = csv.reader(row for row in rows if not row.startswith("#"))
    assert header[:3] == [
        "rotor speed (rpm)",
        "vane temperature (degC)",
        "casing temperature (degC)",
    ]
    column = header.index("ND 2 mode 3 stuck (Hz)")
    assert [float(row[column]) for row in values] == lines.stuck[1, :, 2].tolist()


def test_a_linear_circle_by_a_dense_solve(scene):
    """The response to another engine order, C from all modes of the open structure."""
    study = parse_study('[excitation]\nunbalance = "1.5 kg*mm"')
    shells = {k: at_diameter(scene.casing, k) for k in (0, 2)}
    bare = joining(study)._replace(joints=scene.joints)
    system = joined_at(study, 2, scene.vane, shells, bare, (1.0, 1.0), {})
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
    # Every force node of the ring of 16 shares U ω² as a pressure with the angle's cosine.
    per_node = 2 * 1.5e-3 / (16 * 16) * omega**2
    unit = rom.join(scene.vane, shells[2], scene.joints, rom.Excitation(2, force=1.0)).force[1]
    matrix = with_springs(closed) - omega**2 * D.M + 1j * omega * C
    x = np.linalg.solve(matrix, per_node * unit.vector)
    expected = np.abs(D.output @ x)
    found = linear_response(system, [f], closed)
    np.testing.assert_allclose(found.amplitude[0], expected, rtol=1e-7)


@pytest.mark.parametrize("rom_table", ['route = "direct"', "vane_modes = 12\ncasing_modes = 12"])
def test_other_reductions_give_the_same_diagram(ran, tmp_path, rom_table):
    """Ten modes a part and Tran's faces are off by a few per cent at most."""
    text = HOT + f"[rom]\n{rom_table}\n" + DIAGRAM
    run_study(parse_study(text), tmp_path)
    with h5py.File(tmp_path / "results.h5") as file:
        lines = Campbell.load(file["campbell/nominal"]).lines
    expected = ran[2]["diagram"].lines
    assert lines.diameters.tolist() == expected.diameters.tolist()
    for own, other in ((lines.free, expected.free), (lines.stuck, expected.stuck)):
        second = [
            np.interp(10000.0, each.speeds, values[0, :, 1])
            for each, values in ((lines, own), (expected, other))
        ]
        assert second[0] == pytest.approx(second[1], rel=0.03)
