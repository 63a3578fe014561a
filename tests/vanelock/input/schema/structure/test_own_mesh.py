"""Studies whose parts are meshes from files: keys, refusals, cache, and the same response."""

import json
import shutil

import h5py
import numpy as np
import pytest

from tests.small_study import SMALL
from tests.vanelock.input.conftest import complaint, mistakes
from vanelock import Study, load_study, parse_study, run_study
from vanelock.commands.mesh import mesh_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.input.schema.structure.own_mesh import OwnCasing, OwnVane
from vanelock.mesh import read_mesh
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Event, silent
from vanelock.pipeline.step import Stages
from vanelock.stages.parts.components import PARTS, mesh_step
from vanelock.stages.plan import plan

pytestmark = pytest.mark.usefixtures("undrawn")

VANE = '[vane]\nmesh = "vane.inp"\nunit = "mm"\n'
CASING = '[casing]\nmesh = "casing.bdf"\nunit = "mm"\n'


MISTAKES = """
VANE | vane.chord = 0.05: a mesh is given, so dimensions cannot be
vane.mesh = 3: expected text
vane.mesh = "": mesh file must have at least 1 characters
VANE | mesh.tolerance = 0: largest distance between mates must be > 0 m
mesh.tolerance = 2e-05: needs vane.mesh or casing.mesh
vane.mesh = "a" | vane.unit = "kg": expected a unit of length, such as
VANE | vane.sets.left = "A": node set must be one of "hook_front", "hook_rear", "key", \
"interlock_left", "interlock_right", "output" or "fixed"
VANE | vane.sets.key = []: expected the name of a set
VANE | vane.sets.key = [1.5]: expected the name of a set
VANE | joints.patch = "area": needs dimensions, while vane.mesh is given
VANE | joints.hook.kn = "0 N/m^3": stiffness per area must be > 0 and <= 1e+20 N/m^3
VANE | joints.hook.kn_area = 10: unknown key; known here: kn, kt, mu, interference, wear_coefficient
VANE | joints.hook.kn = "3 Pa": expected a number in N/m, or text with a unit such as "1 N/m"
VANE | joints.interlock = 3: expected a table, or false: the inner shrouds do not touch
CASING | mesh.face_nodes = 326: casing.mesh is given
CASING | outputs.monitor = "vane output 4": expected an output node
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        *mistakes(
            MISTAKES,
            VANE='vane.mesh = "vane.inp"; vane.unit = "mm"',
            CASING='casing.mesh = "casing.bdf"; casing.unit = "mm"',
        ),
        ("vane.sets.key = 'A'", "vane.mesh: must be given"),
        (VANE + "[vane.hook]\nlip_radius = 0.58\n" + CASING, "vane.hook: both parts are given as"),
        (
            VANE + "[outputs]\ngauges = [{ aerofoil = 1, span = 0.1, chord = 0.5 }]",
            "outputs.gauges: a gauge's place needs dimensions, while vane.mesh is given",
        ),
        (
            CASING + "[joints.interlock]\nkt = '1 N/mm^3'",
            "joints.interlock.kt = 1e+09 N/m^3: needs vane.mesh, whose contact sets consist of",
        ),
    ],
)
def test_refusals_are_one_line(text, expected):
    line = complaint(text)
    assert "\n" not in line
    assert line.startswith(expected)


def test_what_goes_with_a_mesh():
    study = parse_study(VANE + "[vane.sets]\nkey = [7, 5]\nhook_rear = 'B'\n" + CASING)
    assert isinstance(study.vane, OwnVane)
    assert isinstance(study.casing, OwnCasing)
    assert study.vane.sets == {"key": (7, 5), "hook_rear": "B"}
    assert parse_study("mesh.tolerance = '20 um'\n" + VANE).mesh.tolerance == 2e-5
    assert study.patches == {"hook": "node", "interlock": "node"}
    assert (study.stretch, parse_study(VANE).stretch) == (1, 3)
    assert parse_study(CASING).patches == {"hook": "node", "interlock": "area"}
    assert parse_study("").patches == {"hook": "area", "interlock": "area"}
    wanted = '[outputs]\nmonitor = "vane output 12, axial"'
    assert parse_study(VANE + wanted).outputs.monitor == "vane output 12, axial"
    assert Study.model_validate(study.model_dump()) == study


SHAPE = "\n".join(line for line in SMALL.splitlines() if line.startswith(("vane", "mesh"))) + "\n"
"""Keys of the smallest parts."""


@pytest.fixture(scope="module")
def files(tmp_path_factory, write_mesh):
    """The program's own meshes as files; tables name their sets, output nodes by number."""
    place = tmp_path_factory.mktemp("files")
    stages = Stages(Cache(place / "cache", print), silent)
    small = (stages.get(mesh_step(parse_study(SHAPE), name)) for name in PARTS)
    for part, ending in zip(small, (".inp", ".bdf"), strict=True):
        path = place / f"{part.name}{ending}"
        called = write_mesh(path, part)
        found = read_mesh(path, "mm")
        outputs = part.points[part.node_sets["output"]]
        rows = np.linalg.norm(found.points - outputs[:, None], axis=2).argmin(axis=1)
        called["output"] = found.numbers[rows].tolist()
        table = "".join(f"{name} = {json.dumps(value)}\n" for name, value in called.items())
        (place / f"{part.name}.toml").write_text(f"[{part.name}.sets]\n{table}")
    return place


@pytest.fixture
def folder(files, tmp_path):
    return shutil.copytree(files, tmp_path / "study")


def written(folder, text):
    sets = [(folder / f"{name}.toml").read_text() for name in ("vane", "casing")]
    (folder / "study.toml").write_text(f"{text}\n{VANE}{sets[0]}{CASING}{sets[1]}")
    return load_study(folder / "study.toml")


SIZE = 'mesh.size = "40 mm"\n'


def keys(study):
    planned = plan(cases(study), lambda *_: None)[0]
    meshes = [mesh_step(study, part).key for part in PARTS]
    parts = (planned.part(part, 1).key for part in PARTS)
    return [*meshes, *parts, planned.system.key]


def test_cache_follows_the_contents(folder):
    """A new friction coefficient or place recomputes no mesh; a node moved by a nanometre does."""
    study = written(folder, SIZE)
    before = keys(study)
    harder = keys(written(folder, SIZE + "joints.hook.mu = 0.5"))
    assert harder[:4] == before[:4]
    assert harder[4] != before[4]
    assert keys(written(shutil.copytree(folder, folder / "moved"), SIZE)) == before
    text = (folder / "vane.inp").read_text()
    (folder / "vane.inp").write_text(text.replace("*HEADING", "*HEADING\nchanged", 1))
    after = keys(study)
    assert all(a != b for a, b in zip(after, before, strict=True))
    (folder / "vane.inp").write_text(text)
    assert keys(study) == before
    inches = (folder / "study.toml").read_text().replace('unit = "mm"', 'unit = "inch"')
    (folder / "study.toml").write_text(inches)
    larger = keys(load_study(folder / "study.toml"))
    assert all(a != b for a, b in zip(larger, before, strict=True))
    table = (folder / "casing.toml").read_text()
    (folder / "casing.toml").write_text(table.replace("[casing.sets]\n", "[casing.sets]\n#\n"))
    assert keys(written(folder, SIZE)) == before
    (folder / "casing.toml").write_text(table.partition("fixed = ")[0])
    assert keys(written(folder, SIZE))[0] != before[0]


RESPONSE = """
rom = { modes = 6 }
joints.hook = { kn = 5e7, kt = 3e7 }
joints.interlock = { mu = 0.1, kn = 1.67e6, kt = 1e6 }
joints.patch = "node"
excitation.force = 80
response = { harmonics = 1, frequencies = [264, 268] }
[outputs]
monitor = "casing output 1, radial"
show = []
"""


@pytest.fixture(scope="module")
def own_run(files, tmp_path_factory):
    folder = shutil.copytree(files, tmp_path_factory.mktemp("own") / "study")
    study = written(folder, SIZE + RESPONSE)
    (summary,) = run_study(study, folder / "run")
    return folder / "run", study, summary


def test_same_response_from_files(own_run, tmp_path):
    folder, _, summary = own_run
    assert summary.converged == 2
    assert summary.slipping > 0
    with h5py.File(folder / "results.h5") as file:
        found = Response.load(file["response/nominal"])
    (planned,) = plan(cases(parse_study(SHAPE + RESPONSE)), lambda *_: None)
    expected = Stages(Cache(tmp_path, print), silent).get(planned.response)
    assert expected.converged.all()
    np.testing.assert_array_equal(found.frequency, expected.frequency)
    size = expected.amplitude.max(axis=(0, 1, 2))
    np.testing.assert_allclose(found.amplitude, expected.amplitude, rtol=1e-8, atol=1e-8 * size)


def test_areas_are_asked_for_before_the_reductions(folder):
    """Rows of nodes have no area: refused at once, with the key and the set."""
    study = written(folder, SIZE + "joints.interlock = { kn = '1e11 N/m^3', kt = '1e11 N/m^3' }")
    stages: list[Event] = []
    for action in (run_study, mesh_study):
        with pytest.raises(InputError) as caught:
            action(study, folder / action.__name__, stages.append)
        assert str(caught.value) == (
            "joints.interlock.kn = 1e+11 N/m^3: the vane's set interlock_left does not consist of "
            "whole faces: give stiffnesses per node pair"
        )
    assert not any("rom" in str(event) for event in stages)
    assert any("match" in str(event) for event in stages)
