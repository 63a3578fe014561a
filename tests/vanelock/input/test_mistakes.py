"""Mistakes of a study, each its line; limits of input; numbers that look like other units."""

import os
from pathlib import Path

import pytest

from tests.vanelock.input.conftest import complaint
from vanelock import Study, check_file, load_study, parse_study, template_text
from vanelock.common.errors import InputError
from vanelock.common.toml import LARGEST, toml_tables
from vanelock.input.settings import unusual
from vanelock.results.files.run_folder import claimed


def mistakes(folder, text):
    path = folder / "vane.toml"
    path.write_text(text)
    return complaint(path, load_study).replace(f"{path}: ", "").splitlines()


def test_every_mistake_gets_its_line(tmp_path):
    lines = mistakes(tmp_path, "[joints.hook]\nmu = -1\nkn = 0\n[ring]\nsectors = 2")
    assert lines == [
        "ring.sectors = 2: number of sectors must be >= 6",
        "joints.hook.kn = 0: normal stiffness must be > 0 N/m",
        "joints.hook.mu = -1: friction coefficient must be >= 0",
    ]
    text = '"joints.interlock.mu" = [0.1, -0.1, 0.1]\n"joints.interlok.kn" = [1e6]'
    assert [line.partition(": ")[0] for line in mistakes(tmp_path, f"[sweep]\n{text}")] == [
        'sweep."joints.interlock.mu"[1] = -0.1',
        'sweep."joints.interlock.mu"[2] = 0.1',
        'sweep."joints.interlok.kn"',
    ]
    text = "[casing]\nrail_inner_radius = 0.572\ngroove_mouth = 0.084"
    assert [line.partition(" = ")[0] for line in mistakes(tmp_path, text)] == [
        "casing.groove_mouth",
        "vane.outer_shroud_outer_radius",
    ]


@pytest.mark.parametrize("table", ["sweep", "rows", "scatter"])
def test_values_that_are_no_list_are_lines_of_their_table(tmp_path, table):
    text = f'[{table}]\n"joints.interlock.mu" = {{ from = 0.1, to = 0.9 }}\n'
    lines = mistakes(tmp_path, text)
    assert lines
    assert all(line.startswith(table) for line in lines)


def test_wrong_values_and_contradictions_of_tables_that_are_right_come_together(tmp_path):
    text = (
        "damping.ratio = 2\nvane = { leg_front = 0.09, thickness = 0.001 }\n"
        'casing.length = "4 km"\nrom = { route = "paper", accuracy = 0.1 }\n'
    )
    heads = [line.partition(": ")[0] for line in mistakes(tmp_path, text)]
    assert heads == [
        "vane.leg_rear = 0.0885 m",
        "vane.edge_thickness = 0.0022",
        'casing.length = "4 km"',
        "rom.accuracy = 0.1",
        "damping.ratio = 2",
    ]


def test_what_depends_on_a_wrong_value_is_not_checked(tmp_path):
    """Not with the default in its place, which would be a mistake that nobody made."""
    for text in (
        "[response]\nharmonics = 200\nsamples = 20",
        "[vane]\nleg_front = 0.09\nleg_rear = -1",
        "[ring]\nsectors = 3\n[vane]\naerofoils = 12",
        '[response]\nfriction = "none"\n[stability]',
        "[temperature]\nvane = 1e9\nspeed = 3000",
        "[outputs]\ngauges = [{ aerofoil = 0, span = 0.5, chord = 0.5 }]",  # needed and wrong
        "[outputs]\ngauges = [{ aerofoil = 9, span = 0.5 }]",
    ):
        (line,) = mistakes(tmp_path, text)
        assert "must" in line or "at least" in line


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("#" * (LARGEST + 1), "more than 2,000,000 bytes"),
        (".".join("a" * 1000) + " = 1", "line 1: nested too deeply"),
        ("a = " + "[" * 1000, "nested too deeply"),
        ("a = " + "{b = " * 300 + "1" + "}" * 300, "nested too deeply"),
        ("name = " + "1" * 10_000, "not valid TOML"),
        ("[a]\nb = [1, 0x" + "f" * 10_000 + "]", "a.b[1]: not valid TOML: an integer of more"),
    ],
    ids=["size", "a long key", "brackets", "tables", "digits", "hexadecimal digits"],
)
def test_where_the_limits_lie(tmp_path, text, expected):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        load_study(path)
    assert expected in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_the_limits_leave_room_mistakes_are_counted_and_a_pipe_is_not_waited_for(tmp_path):
    text = "\n".join(f"# {'comment ' * 20}" for _ in range(10_000))
    assert len(text) < LARGEST
    assert toml_tables(text, "study") == {}
    assert toml_tables("a.b.c.d.e.f = 1", "study")["a"]["b"]["c"]["d"]["e"]["f"] == 1
    assert toml_tables('n = "1.2.3.4.5.6.7.8.9.10.11.12.13"', "study")
    with pytest.raises(InputError) as error:
        parse_study("".join(f"k{i} = 1\n" for i in range(1000)))
    lines = str(error.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "study: and 980 more mistakes"
    os.mkfifo(tmp_path / "study.toml")
    with pytest.raises(InputError, match="is no regular file"):
        load_study(tmp_path / "study.toml")


@pytest.mark.parametrize("name", ["cache", "figures", "shapes", "mesh"])
def test_links_in_the_folder_are_not_followed(tmp_path, name):
    folder, other = tmp_path / "run", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    (folder / name).symlink_to(other)
    with pytest.raises(InputError, match=f"{name}: is a link, which is not followed"):
        enter(folder)
    (folder / name).unlink()
    (folder / ".lock").unlink()
    (folder / ".lock").symlink_to(other / "made")
    with pytest.raises(InputError, match="cannot be used as a folder"):
        enter(folder)
    assert list(other.iterdir()) == []


def enter(folder: Path) -> None:
    with claimed(folder):
        pass


def test_a_folder_is_used_that_is_new_empty_or_of_a_run(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / ".gitkeep").touch()
    for name in ("new", "empty"):
        with claimed(tmp_path / name):
            (tmp_path / name / "report.html").write_text("page")
        with claimed(tmp_path / name):
            pass


UNUSUAL = """
material.vane.rho = 8.2e-09 kg/m^3: density, 50 to 25000 kg/m^3; "8.2e-09 t/mm^3"?
material.casing.E = 1.7e+08 Pa: Young's modulus, 1e+09 to 1.5e+12 Pa; "170000000 kPa"?
joints.interlock.kn = 0.001 N/m: normal stiffness, 1 to 1e+13 N/m; "0.001 kN/um"?
sweep."material.vane.rho"[1] = 8.2 kg/m^3: density, 50 to 25000 kg/m^3; "8.2 g/cm^3"?
material.vane.E[0] = 200000 Pa: Young's modulus, 1e+09 to 1.5e+12 Pa; \
"200000 MPa"?
"""
LISTS = {
    "material.vane.E": "[[20, 2e5], [600, 170e9]]",
    'sweep."material.vane.rho"': "[8.2e3, 8.2]",
}


@pytest.mark.parametrize("line", UNUSUAL.strip().splitlines())
def test_a_number_of_another_unit_is_reported(tmp_path, line):
    head, _, value = line.partition(": ")[0].partition(" = ")
    key, in_list, _ = head.partition("[")
    path = tmp_path / "my.toml"
    path.write_text(f"{key} = {LISTS[key] if in_list else value.split()[0]}")
    expected = line.replace(", ", " is hardly ever outside ")
    assert unusual(load_study(path)) == (expected,)
    assert ("warning", expected) in check_file(path).rows


def test_usual_numbers_are_not_reported(tmp_path):
    (tmp_path / "my.toml").write_text(template_text(all_keys=True))
    assert unusual(load_study(tmp_path / "my.toml")) == unusual(Study()) == ()
