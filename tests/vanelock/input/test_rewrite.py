"""A study's text with other values: what changes, and that nothing else does."""

import tomllib

import pytest

from vanelock import parse_study, template_text
from vanelock.common.errors import InputError
from vanelock.input.rewrite import rewritten

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
