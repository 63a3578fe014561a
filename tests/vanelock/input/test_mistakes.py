"""Every wrong value of a study is reported at once, then contradictions, none that nobody made."""

import pytest

from tests.vanelock.input.conftest import complaint
from vanelock import load_study


def mistakes(folder, text):
    path = folder / "vane.toml"
    path.write_text(text)
    return complaint(path, load_study).replace(f"{path}: ", "").splitlines()


def test_every_mistake_gets_its_line(tmp_path):
    """Also every wrong entry of a sweep, and all dimensions that do not fit."""
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
