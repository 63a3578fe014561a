"""Study files: what is accepted, a clear line for all that is not, texts with other values."""

import re
import tomllib

import pytest
from pydantic import BaseModel

from tests.vanelock.input.conftest import complaint, mistakes
from vanelock import Study, load_study, parse_study, template_text
from vanelock.analyses import ANALYSES
from vanelock.common.errors import InputError
from vanelock.input.rewrite import rewritten
from vanelock.input.schema.comparison import CampbellKeys, Fit, MeasuredCurve, Optimise
from vanelock.input.schema.distributions import Distribution, Scatter
from vanelock.input.schema.structure.loads import RestLoadKeys
from vanelock.input.schema.structure.structure import _mesh_size
from vanelock.mesh.element_size import LARGEST, SMALLEST


def test_smallest_studies_are_the_scene():
    assert parse_study("") == Study()
    named = parse_study('name = "mine"')
    assert named.name == "mine"
    assert named.joints.hook.interference == 20e-6
    assert named.joints.interlock.kn == 1e6
    assert named.vane.interlock_slant == 35
    assert named.excitation.force_per_node == 30
    assert named.damping.ratio == 0.003


def leaves(table, prefix=""):
    for key, value in table.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def test_template_states_every_default():
    written = dict(leaves(parse_study(template_text(all_keys=True)).model_dump()))
    defaults = dict(leaves(Study().model_dump())) | {"excitation.force": 30.0}
    assert written.keys() == defaults.keys()
    for key, value in defaults.items():
        close = pytest.approx(value, rel=1e-12) if isinstance(value, float) else value
        assert written[key] == close, key


@pytest.mark.parametrize("kind", ["study", "scene"])
def test_the_first_keys_to_set_are_lines_of_the_whole_template(kind):
    """Which mean the same there: tables, values and what is only shown."""
    short, every = template_text(kind), template_text(kind, all_keys=True)
    assert len(short.splitlines()) <= 40
    keys = dict(leaves(tomllib.loads(short)))
    assert len(keys) > 14
    keys.pop("loads", None)  # a list of tables
    assert keys.items() <= dict(leaves(tomllib.loads(every))).items()
    # What holds a number says its unit: in the value, or after it.
    for line in short.splitlines()[3:]:
        if re.match(r"(kn|kt|rho|force|range|E|interference|amplitude) = ", line):
            assert re.search(r"Pa|N/m|kg/m|\bN\b|Hz|um", line), line


def test_template_mentions_every_key():
    text = template_text(all_keys=True)
    tables: dict[str, type[BaseModel]] = {
        "loads": RestLoadKeys,
        **{each.key: each.keys for each in ANALYSES if each.keys and not each.table},
        "campbell": CampbellKeys,
        "measured": MeasuredCurve,
        "fit": Fit,
        "optimise": Optimise,
        "scatter": Scatter,
        "scatter.keys": Distribution,
    }
    for key, _ in leaves(Study().model_dump()):
        if key not in tables:
            assert f"{key.rpartition('.')[2]} = " in text, key
    assert "# [loads.pressure]" in text
    for key in ("mesh", "unit"):
        assert f"# {key} = " in text, key
    for name, table in tables.items():
        _, _, after = text.partition(f"# [{name}]" if f"# [{name}]" in text else f"# [[{name}]]")
        own = after.partition("\n# [")[0]
        for key in table.model_fields.keys() - {"keys", "pressure"}:
            inside = f" {key} = " if name == "scatter.keys" else f"\n# {key} = "
            assert inside in own, f"{name}.{key}"


def test_what_the_template_shows_of_measurements_is_valid():
    """The commented tables, with the gauge that they name."""
    _, _, after = template_text(all_keys=True).partition("# A Campbell diagram")
    after = after.partition("# Between which values")[0]
    gauge = "[outputs]\ngauges = [{ aerofoil = 2, span = 0.1, chord = 0.5 }]\n"
    lines = [line.removeprefix("# ") for line in after.splitlines() if line.startswith("# ")]
    tables = [line for line in lines if line.startswith("[") or " = " in line.partition("#")[0]]
    found = parse_study(gauge + "\n".join(tables))
    assert found.campbell == CampbellKeys(speeds=(0.0, 20000.0))
    assert found.fit is not None
    assert found.fit.starts == Fit().starts
    (curve,) = found.measured
    assert curve.direction == MeasuredCurve(file="a").direction


@pytest.mark.parametrize("text", ["0.05", '"50 mm"', '"5 cm"', '"50000 um"', '"50e3 µm"'])
def test_lengths(text):
    assert parse_study(f"vane.chord = {text}").vane.chord == pytest.approx(0.05, rel=1e-14)
    for wrong in ('"0.05"', '"50 kg"'):
        line = complaint(f"vane.chord = {wrong}")
        assert line.startswith(f"vane.chord = {wrong}: expected a number in")


MISTAKES = """
joints.interlock.mu = -0.1: friction coefficient must be >= 0
joints.interlock.muu = 0.1: unknown key; nearest known key: joints.interlock.mu
ring.sectors = 16.0: expected a whole number
ring.sectors = true: expected a whole number
joints.hook.mu = nan: expected a finite number
joints.hook.mu = "high": expected a number
joints = 3: expected a table
name = 3: expected text
joints.hook.kn = "-2 N/m": normal stiffness must be > 0 N/m
rom.route = "fast": route must be one of "cyclic" or "paper"
joints.interlock.friction = 0.1: unknown key; nearest known key: response.friction
joints.hook.mu = 1001: friction coefficient must be <= 1000
joints.hook.interference = "2 mm": interference must be <= 0.001 m
excitation.force = 1e-20: radial force per node must be >= 1e-06 N
excitation.unbalance = 1500: unbalance must be <= 100 kg m; 1500 is 1500 kg m: "1500 g*mm"?
vane.chord = "1 km": chord of an aerofoil must be <= 0.5 m
vane.chord = 40: chord of an aerofoil must be <= 0.5 m; 40 is 40 m: "40 mm"?
excitation.engine_orders = [1, 2]: unknown key; nearest known key: excitation.engine_order
excitation.engine_order = 0: engine order must not be 0; negative is a backward wave
response.range = [300, 200]: must be [low, high] with low < high
response.frequencies = [250, 240]: frequencies must ascend
material.vane.E = 170: Young's modulus must be >= 1000 Pa; 170 is 170 Pa: "170 GPa"?
accuracy = 0.5: relative error of the largest response must be < 0.3
excitation.force = 1 | excitation.unbalance = 0.001: \
give either unbalance or excitation.force, not both
excitation.engine_order = 2 | excitation.unbalance = 0.001: \
an unbalance excites excitation.engine_order 1 or -1 only
mesh.size = "tiny": element size must be "coarse", "medium", "paper", "fine" or 1 mm to 50 mm, \
or [vane, casing], where that makes at most 1,000,000 degrees of freedom
response.harmonics = 5 | response.samples = 20: \
number of samples must be >= 24 for 5 harmonics
response.friction = "isotropic" | response.samples = 40: \
isotropic friction has its events located: leave it out
rom.route = "paper" | accuracy = 0.01: \
rom.route = "paper" gives no estimate of what it leaves out; choose "cyclic"
response.points = 3 | accuracy = 0.01: response.points = 3: needs at least 5
"""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        *mistakes(MISTAKES),
        ("joint.hook.mu = 0.1", "joint: unknown key; nearest known key: joints"),
        (
            'mesh.size = "2 mm"',
            "mesh.size = 2 mm: about 5,300,000 degrees of freedom: "
            "at most 1,000,000 are allowed, that is sizes from 4 mm here",
        ),
        (
            "response.frequencies = [1, 2, -3]",
            "response.frequencies[2] = -3: excitation frequency must be > 0 Hz",
        ),
        ("a = = 1", "line 1: not valid TOML: Invalid value"),
        ('name = "a"\nname = "b"', "line 2: not valid TOML: Cannot overwrite a value"),
        ("[ring]\nsectors = [1,\n", "line 2: not valid TOML: Invalid value"),
        (
            "campbell.speeds = [-1, -2]",  # wrong entries do not make a list too short
            "campbell.speeds[0] = -1: [low, high] rotor speed must be >= 0 rpm\n"
            "study: campbell.speeds[1] = -2: [low, high] rotor speed must be >= 0 rpm",
        ),
    ],
)
def test_one_line_for_one_mistake(text, line):
    assert complaint(text) == line


def test_dimensions_that_contradict_one_another_are_refused_on_reading(tmp_path):
    message = complaint("[vane]\nleg_front = 0.09")
    assert message.startswith("vane.leg_rear = 0.0885")
    assert "leg_front = 0.09" in message
    assert len(message.splitlines()) == 1
    path = tmp_path / "vane.toml"
    path.write_text("[vane]\naerofoils = 12")
    line = complaint(path, load_study)
    assert line.startswith(f"{path}: vane.")
    assert "\n" not in line


def test_monitors_name_a_node_and_the_smallest_and_largest_elements_may_be_asked_for():
    wanted = "casing output 2, axial"
    assert parse_study(f'[outputs]\nmonitor = "{wanted}"').outputs.monitor == wanted
    for absent in ("blade", "vane output 9, radial", "casing output 0"):
        text = complaint(f'[outputs]\nmonitor = "{absent}"')
        assert text.startswith(f'outputs.monitor = "{absent}": expected an output node')
        assert "output 1 to 3" in text
    assert [_mesh_size(size) for size in (SMALLEST, LARGEST)] == [SMALLEST, LARGEST]
    assert _mesh_size(["8 mm", 0.005]) == (0.008, 0.005)
    for size in (0.999 * SMALLEST, 1.001 * LARGEST, [0.008, 0.1], [0.008], ["coarse", 0.01]):
        with pytest.raises(ValueError, match="element size must be"):
            _mesh_size(size)


TEXT = """# mine
name = "rig"   # kept
damping.ratio = 0.002

[joints.hook]
mu = 0.3
[joints.interlock] # faces
mu = 0.4                 # friction
interference = "2 um"    # a # in a comment

[[measured]]
file = "a.csv"
[[measured]]
file = 'b.csv'
"""


def test_what_is_left_out_goes_and_the_rest_stays():
    swept = TEXT + "\n[sweep]\njoints.hook.mu = [0.1, 0.2]\n"
    without = ["sweep", "rows", "joints.interlock.interference"]
    made = rewritten(swept, {"joints.hook.mu": 0.2}, without)
    assert made.rstrip() == "\n".join(
        line.replace("mu = 0.3", "mu = 0.2") for line in TEXT.splitlines() if "2 um" not in line
    )


def test_values_change_where_they_stand_and_comments_stay():
    made = rewritten(
        TEXT,
        {
            "joints.interlock.mu": 0.25,
            "joints.interlock.interference": 1.5e-6,
            "damping.ratio": 0.003,
            "measured[1].file": "../c.csv",
        },
    )
    lines = made.splitlines()
    assert lines[7] == "mu = 0.25                 # friction"
    assert lines[8] == "interference = 1.5e-06    # a # in a comment"
    assert lines[2] == "damping.ratio = 0.003"
    assert lines[-1] == 'file = "../c.csv"'
    changed = {2, 7, 8, 13}
    assert [line for i, line in enumerate(lines) if i not in changed] == [
        line for i, line in enumerate(TEXT.splitlines()) if i not in changed
    ]


def test_keys_that_are_not_there_are_added_and_the_template_can_be_fitted():
    made = rewritten(
        TEXT, {"joints.interlock.kt": 2e6, "joints.hook.kt": 3e7, "excitation.force": 20.0}
    )
    found = tomllib.loads(made)
    assert found["joints"]["interlock"] == {"kt": 2e6, "mu": 0.4, "interference": "2 um"}
    assert found["joints"]["hook"] == {"kt": 3e7, "mu": 0.3}
    assert found["excitation"] == {"force": 20.0}
    assert rewritten("", {"joints.interlock.mu": 0.1}).strip() == "[joints.interlock]\nmu = 0.1"
    keys = {"joints.interlock.mu": 0.11, "joints.hook.kn": 2e7, "material.vane.E": 1.8e11}
    study = parse_study(rewritten(template_text(all_keys=True), keys))
    assert study.joints.interlock.mu == 0.11
    assert study.joints.hook.kn == 2e7
    assert study.material.vane.E == 1.8e11


@pytest.mark.parametrize(
    ("text", "made"),
    [
        (
            "joints = { interlock = { mu = 0.3 } } # faces",
            "joints = { interlock = { mu = 0.2 } } # faces",
        ),
        ("[joints]\ninterlock.mu = 0.3\n", "[joints]\ninterlock.mu = 0.2\n"),
        (
            "[joints.interlock]\nkt = 1\n[joints.hook]\nmu = 0.3\n",
            "[joints.interlock]\nkt = 1\nmu = 0.2\n[joints.hook]\nmu = 0.3\n",
        ),
        (
            'name = """\n[joints.interlock]\nmu = 0.1\n"""\n',
            'name = """\n[joints.interlock]\nmu = 0.1\n"""\n\n[joints.interlock]\nmu = 0.2\n',
        ),
    ],
)
def test_a_table_may_be_written_in_any_way(text, made):
    assert rewritten(text, {"joints.interlock.mu": 0.2}) == made


@pytest.mark.parametrize("text", ["joints = 3", "[joints]\ninterlock = []", "mu = ", "[joints"])
def test_what_cannot_be_changed_is_refused(text):
    with pytest.raises(
        InputError, match="cannot be changed: set joints.interlock.mu in it yoursel"
    ):
        rewritten(text, {"joints.interlock.mu": 0.2})


def test_strings_are_escaped_and_fields_of_inline_lists_found():
    made = rewritten('measured = [{ file = "a" }, { file = "b" }]', {"measured[1].file": 'C:\\"c"'})
    assert made == 'measured = [{ file = "a" }, { file = "C:\\\\\\"c\\"" }]'
