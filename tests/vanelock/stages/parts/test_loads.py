"""Loads in a study: resultants, growth, fields from files, what is kept, and words."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.mesh.conftest import RADIUS, SECTORS
from tests.refusals import refused
from vanelock import nonlinear, parse_study, run_study
from vanelock.analyses.preload_by_cause import LoadsByCause, _by_cause_step
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.files import load_study
from vanelock.input.cases.sweep import cases
from vanelock.input.schema.scene import LoadKeys, Scene
from vanelock.rom import System
from vanelock.rom.joining.connections import Load
from vanelock.stages.matrices.gather import Gathered
from vanelock.stages.matrices.piece import NodalForces
from vanelock.stages.parts.components import model_step
from vanelock.stages.parts.load_lines import load_lines
from vanelock.stages.parts.loads import _nodal_field, growth
from vanelock.stages.plan import plan

pytestmark = pytest.mark.usefixtures("undrawn")


HEAT = """
[material.vane]
expansion = 1.3e-5
[material.casing]
expansion = 1.2e-5
[temperature]
casing = 600
reference = 100
"""
EPSILON = 1.3e-5 * (620 - 100) - 1.2e-5 * (600 - 100)


def planned_of(study):
    return plan(cases(study), lambda *_: None)[0]


@pytest.fixture
def ring(ring_text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = ring_text("hexahedron20") + "[response]\nharmonics = 1\n"
    return lambda more: parse_study(text + more)


def test_joints_hold_a_segment_against_gas(golden):
    run = golden("everything")
    study = parse_study(run.text)
    with h5py.File(run.folder / "results.h5") as file:
        found = LoadsByCause.load(file["response/nominal/preload_by_cause"])
        system = System.load(file["response/nominal/system"])
    assert found.causes == ("interference", "gas", "heat")
    assert found.converged.all()
    assert found.resultant[0] == pytest.approx(4 * 20, rel=1e-9)
    middle = 0.5 * (study.vane.inner_shroud_outer_radius + study.vane.outer_shroud_inner_radius)
    assert found.resultant[1] == pytest.approx(4 * -15 * middle, rel=0.01)
    assert np.abs(found.reaction.sum(axis=0) + found.resultant).max() < 1e-9 * 4 * 15 * middle
    assert np.abs(found.reaction[1]).max() < 1e-9  # of neighbours on each other
    # All causes together, at rest in harmonic balance with all contacts where they are at last.
    rest = nonlinear.static_response(system, nonlinear.Options())
    normal = [rest.force[0, 0, system.contacts.of(name), 0].real.sum() for name in found.joints]
    assert np.allclose(found.normal[-1], normal, rtol=1e-6)


END = (RADIUS**2 - (RADIUS - 0.1) ** 2) * np.pi / SECTORS
"""Area of a sector's end, m²."""


def test_pressure_on_a_set_and_from_a_file(ring, stages, tmp_path):
    """The same constant either way; its resultant is p A, which the joints balance."""
    study = ring('[loads.pressure]\nend = "2 bar"\n')
    found = stages.get(_by_cause_step(planned_of(study)))
    assert found.causes[0] == "interference"
    assert found.resultant[0] == pytest.approx(-2e5 * END, rel=1e-5)
    assert np.abs(found.reaction.sum(axis=0) + found.resultant).max() < 1e-9 * 2e5 * END
    none = planned_of(ring(""))
    assert _by_cause_step(none) is None
    rest, contacts = stages.get(none.preload), stages.get(none.system).contacts
    normal = [rest.force[0, 0, contacts.of(name), 0].real.sum() for name in found.joints]
    assert np.allclose(found.normal[0], normal, rtol=1e-5)  # a reduction without static answers

    rows = [f"{x},{y},200,0.2\n" for x in range(700, 1001, 50) for y in range(-300, 301, 50)]
    file = tmp_path / "flow.csv"
    file.write_text("x (mm),y (mm),z (mm),pressure (MPa)\n" + "".join(rows))
    study = ring('[loads.pressure]\nend = "flow.csv"\n')
    planned = planned_of(study)
    again = stages.get(_by_cause_step(planned))
    assert np.allclose(again.normal, found.normal, rtol=1e-9)
    assert np.allclose(again.resultant, found.resultant, rtol=1e-12)

    file.rename(tmp_path / "moved.csv")
    moved = ring('[loads.pressure]\nend = "moved.csv"\n')
    assert planned_of(moved).system.key == planned.system.key
    (tmp_path / "moved.csv").write_text(
        (tmp_path / "moved.csv").read_text().replace("200,0.2", "200,0.3")
    )
    harder = stages.get(_by_cause_step(planned_of(moved)))
    assert harder.resultant[0] == pytest.approx(1.5 * found.resultant[0], rel=1e-9)


def test_a_uniform_field_of_temperature_is_one_number(ring, stages, tmp_path):
    one = stages.get(planned_of(ring(HEAT + "vane = 620\n")).preload)
    rows = [
        f"{x},{y},{z},893.15\n"
        for x in range(900, 1001, 50)
        for y in range(-250, 251, 50)
        for z in range(0, 201, 50)
    ]
    (tmp_path / "t.csv").write_text("x (mm),y (mm),z (mm),temperature (K)\n" + "".join(rows))
    study = ring(HEAT.replace("casing = 600", 'casing = 600\nfield = "t.csv"'))
    field = stages.get(planned_of(study).preload)
    assert np.abs(one.force[0] - field.force[0]).max() < 1e-8 * np.abs(one.force[0]).max()
    part = stages.get(model_step(study, "vane")).part
    assert np.abs(np.asarray(growth(study, "vane", part)) / EPSILON - 1).max() < 1e-9


def test_what_does_not_fit_is_refused(ring, stages, tmp_path):
    (tmp_path / "far.csv").write_text("x,y,z,pressure\n0,0,0,1\n0,0,1,1\n")
    for more, line in (
        ('end = "far.csv"', r"far\.csv: the node at .* lies .* are the units and axes"),
        ("none = 3", r"vane\.vtu: no set none for vane\.none; it has"),
        ("output = 3", r"vane: no face of the surface has all its nodes in 'output'"),
    ):
        with pytest.raises(InputError, match=line):
            stages.get(planned_of(ring(f"[loads.pressure]\n{more}\n")).preload)


def test_a_joint_that_lifts_is_shown(ring, tmp_path):
    events: list[Any] = []
    study = ring(HEAT + "vane = 400\n[outputs]\nshow = ['report']\n")
    run_study(study, tmp_path / "run", events.append)
    tables = {each.title: each for each in events if isinstance(each, Table)}
    causes = tables["Preload by cause"]
    rows: dict[Any, Any] = {row[0]: row for row in causes.rows}
    assert rows["interlock"][-2] == 0 < rows["interlock"][1]
    assert "heat opens 23 of interlock's 23 contacts" in causes.notes
    assert tables["Reactions at rest"].rows[-1][0] == "sum"
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        group = file["response/nominal/preload_by_cause"]
        assert np.allclose(group["normal"][-1], [rows[name][-2] for name in ("hook", "interlock")])
    assert "Preload by cause" in (tmp_path / "run" / "report.html").read_text()


def test_forces_on_nodes_are_summed_over_nodes_and_segments(tmp_path):
    """1.5 kN on each of 40 nodes of 16 segments are 960 kN."""
    file = tmp_path / "study.toml"
    file.write_text("[ring]\nsectors = 16\n[excitation]\nforce = 1500\n")
    (line,) = load_lines(load_study(file), 40)
    assert line == (
        "excitation: 1,500 N on each of 40 nodes, 60,000 N together, 960,000 N around the ring, "
        "radial"
    )
    assert not list(load_lines(load_study(file), None))


def test_directions_are_shown_at_length_one():
    loads = [
        {"component": "a", "nodes": [1, 2], "direction": [0, 3, 4], "amplitude": 5},
        {"component": "a", "nodes": [3], "direction": [1, 0, 0], "amplitude": 2},
        {"component": "a", "file": "gas.csv", "scale": 2.0},
    ]
    given = Scene.model_construct(loads=tuple(LoadKeys.model_validate(each) for each in loads))
    acting = [Load(f"loads[{i}]", "a", np.arange(2 - i), np.zeros(3, complex), 1) for i in (0, 1)]
    forces = np.array([[1.0, 2.0, 0.0], [0.5, -2.0, 0.0]])
    gas = NodalForces("loads[2]", "a", "", np.array([8, 9]), forces, 2.0, 0)
    lists = Gathered((), (), tuple(acting), (gas,), (), ())
    assert list(load_lines(given, None, lists)) == [
        "loads[0]: 5 N on each of 2 nodes, 10 N together, along [0, 0.6, 0.8], "
        "the direction [0, 3, 4] at length 1",
        "loads[1]: 2 N on 1 node, along [1, 0, 0]",
        "loads[2]: forces on 2 nodes, sum [3, 0, 0] N",
    ]


def _smooth(x):
    return 1e5 * (1 + 0.3 * x[:, 0] / 0.1 - 0.2 * (x[:, 1] / 0.1) ** 2)


def _points_file(path: Path, points, values) -> Path:
    rows = [
        f"{v / 1e3:.17g};{1e3 * x:.17g};{z:.17g};{1e3 * y:.17g}"
        for (x, y, z), v in zip(points, values, strict=True)
    ]
    path.write_text("# of a flow\n\npressure (kPa);x (mm);z [m];y (mm)\n" + "\n".join(rows))
    return path


def test_points_keep_their_values_whatever_the_order_and_units_of_columns(tmp_path):
    points = np.random.default_rng(2).uniform(0, 0.1, (50, 3))
    path = _points_file(tmp_path / "p.csv", points, _smooth(points))
    found = _nodal_field(path, "pressure", "Pa", points)
    np.testing.assert_allclose(found, _smooth(points), rtol=1e-9)


def test_between_points_the_error_falls_with_their_distance(tmp_path):
    nodes = np.column_stack([*np.random.default_rng(3).uniform(0, 0.1, (2, 400)), np.zeros(400)])
    errors = []
    for count in (10, 40):
        x, y = np.meshgrid(*[np.linspace(0, 0.1, count)] * 2)
        points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        found = _nodal_field(
            _points_file(tmp_path / "p.csv", points, _smooth(points)), "pressure", "Pa", nodes
        )
        errors.append(np.abs(found / _smooth(nodes) - 1).mean())
    assert errors[0] < 0.01
    assert errors[1] < errors[0] / 3


@pytest.mark.parametrize(("text", "message"), [
    ("x,y,z\n0,0,0\n", "line 1: 0 columns pressure: needed are x .m., y .m., z .m., pressure"),
    ("x,y,z,pressure (mm)\n0,0,0,1\n", "line 1: pressure .mm.: not a unit like Pa"),
    ("x,y,z,pressure\n0,0,0,1\n0,0,one,1\n", "line 3: needs a number in each column"),
    ("x,y,z,pressure\n0,0,0,1\n0,0\n", "line 3: needs a number in each column"),
    ("x,y,z,pressure\n0,0,0,nan\n", "line 2: numbers must be finite"),
    ("x,y,z,pressure\n", "needs a line of names and one of numbers at least"),
    ("x,y,z,pressure\n5,0,0,1\n", "the node at 0, 0, 0 mm lies 5e.03 mm from the nearest"),
    ("x,y,z,pressure\n0,0,0,1\n0.089,0,0,1\n", "the node at 100, 0, 0 mm lies 11 mm from"),
])  # fmt: skip
def test_what_is_no_field_is_refused(tmp_path, text, message):
    path = tmp_path / "p.csv"
    path.write_text(text)
    refused(message, _nodal_field, path, "pressure", "Pa", np.array([[0.0, 0, 0], [0.1, 0, 0]]))
