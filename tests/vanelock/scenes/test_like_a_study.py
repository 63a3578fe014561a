"""What a scene does as a study does; its page and commented file name every key."""

import re
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.vanelock.scenes.test_run import PAD, arm
from vanelock import Scene, cases, check_scene, load_scene, run_scene, template_text
from vanelock.__main__ import main
from vanelock.analyses import ANALYSES
from vanelock.common.checked import ANY, _known_keys
from vanelock.common.errors import InputError

QUIET = "[outputs]\nshow = []\n"
SMOOTH = PAD.replace("mu = 0.2", "mu = 0")
"""A pad that stays closed and has no friction: the response is linear in its load."""


def test_percentiles_of_a_linear_scene_are_those_of_its_load(tmp_path, scene_file):
    text = arm(tmp_path) + "modes = 2\n" + SMOOTH + QUIET
    text += "[response]\nharmonics = 1\nfrequencies = [80]\n"
    alone = run_scene(load_scene(scene_file(text)), tmp_path / "alone")[0].peak
    assert alone is not None
    scatter = (
        '[scatter]\nsamples = 10\n[scatter.keys."loads[0].amplitude"]\nuniform = ["0.5 N", 1.5]\n'
    )
    scene = load_scene(scene_file(text + scatter))
    run_scene(scene, tmp_path / "run")
    loads = [each.values["loads[0].amplitude"] for each in cases(scene)]
    expected = np.quantile(loads, [0.25, 0.5, 0.75], method="median_unbiased") * alone.amplitude
    with h5py.File(tmp_path / "run" / "results.h5") as file:
        found = file["scatter/amplitude_percentile"][1:4, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_rows_of_a_scene_vary_together(tmp_path, scene_file):
    text = arm(tmp_path) + "modes = 2\n" + PAD
    rows = '[rows]\n"contacts.pad.kn" = [1e4, "2e4 N/m"]\n"contacts.pad.kt" = [3e4, 5e4]\n'
    found = cases(load_scene(scene_file(text + rows)))
    assert [each.name for each in found] == ["kn=10000N_m,kt=30000N_m", "kn=20000N_m,kt=50000N_m"]
    with pytest.raises(InputError, match=r'rows\."contacts\.pad\.kx": unknown key'):
        load_scene(scene_file(text + rows.replace("pad.kt", "pad.kx")))


def test_a_measured_curve_is_drawn_beside_a_scene(tmp_path, scene_file):
    (tmp_path / "test.csv").write_text("frequency (Hz), amplitude (um)\n100, 7.5\n120, 9.25\n")
    text = arm(tmp_path) + "modes = 2\n" + PAD
    measured = '[[measured]]\nfile = "test.csv"\nname = "rig"\n'
    run_scene(load_scene(scene_file(text + measured + QUIET)), tmp_path / "run")
    table = (tmp_path / "run" / "figures" / "response.csv").read_text()
    assert "\nmeasured: rig,,120.0,9.25,,\n" in table
    with pytest.raises(InputError, match=r"measured\[0\]\.gauge: a scene of matrices has no"):
        load_scene(scene_file(text + measured + "gauge = 1\n"))
    with pytest.raises(InputError, match=r"measured\[0\]\.file.*outside"):
        load_scene(scene_file(text + measured.replace("test.csv", "../test.csv")))


def test_energy_and_wear_of_the_contacts_are_reported(golden):
    """Friction's work is what the loop encloses, and the balance closes: input = friction + C."""
    ran = golden("lap_joint")
    found = ran.summaries[0]
    with h5py.File(ran.folder / "results.h5") as file:
        answers = dict(file[f"response/{found.case}/answers"].attrs)
    assert answers["friction_work"] == pytest.approx(found.work["lap"], rel=1e-9)
    assert 0 < answers["friction_work"] < answers["input_work"]
    assert 0.002 < answers["damping_ratio"] < 1
    assert "goodman_reserve" not in answers
    page = (ran.folder / "report.html").read_text()
    for words in ("Equivalent damping", "wear indicators", "no field of stress", "lap 1"):
        assert words in page


@pytest.mark.parametrize("command", ["fit", "converge", "mesh"])
def test_what_needs_a_mesh_says_so_of_a_scene(tmp_path, scene_file, command, capsys):
    path = scene_file(arm(tmp_path) + PAD)
    with pytest.raises(SystemExit) as status:
        main([command, str(path), "-o", str(tmp_path / "out")])
    assert status.value.code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "a scene of matrices" in line
    assert not (tmp_path / "out").exists()


PAGE = (Path(__file__).resolve().parents[3] / "docs" / "scene_file.md").read_text("utf-8")


def test_every_key_is_named():
    elsewhere = ("response.", "units.", *(each.key for each in ANALYSES))
    keys = [key for key in _known_keys(Scene) if not key.startswith(elsewhere)]
    last = {key.rpartition(".")[2] for key in keys} - {ANY}
    missing = [
        key for key in sorted(last) if not re.search(rf"(?m)(^|[ `.\[\"]){key}[`\].=\" ]", PAGE)
    ]
    assert not missing


def test_the_example_is_a_scene_and_init_writes_the_commented_file(tmp_path, capsys):
    found = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    scene = check_scene(tomllib.loads(found[1]))
    assert set(scene.components) == {"lower", "upper"}
    assert scene.loads[1].harmonic == 0
    with pytest.raises(SystemExit) as status:
        main(["init", str(tmp_path / "my.toml"), "--scene", "--all"])
    assert not status.value.code
    assert (tmp_path / "my.toml").read_text() == template_text("scene", all_keys=True)
    assert "vanelock run" in capsys.readouterr().out


def test_the_commented_file_is_a_scene_with_every_key():
    text = template_text("scene", all_keys=True)
    scene = check_scene(tomllib.loads(text))
    for key in _known_keys(Scene):
        last = key.rpartition(".")[2]
        assert last == ANY or re.search(rf"(?m)(^|[#\[{{, .]){last}( =|\.|\])", text), key
    load = {"component": "a", "nodes": [1], "direction": [1, 0, 0], "amplitude": 1}
    bare = check_scene({"components": {"a": {"stiffness": "a.mtx"}}, "loads": [load]})
    for table in ("ring", "response", "damping", "excitation"):
        assert getattr(scene, table) == getattr(bare, table)
