"""The page on scenes and the commented file name every key, and what they show is a scene."""

import re
import tomllib
from pathlib import Path

import pytest

from vanelock import Scene, check_scene, template_text
from vanelock.__main__ import main
from vanelock.analyses import ANALYSES
from vanelock.common.checked import ANY, _known_keys

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "scene_file.md").read_text("utf-8")


def test_every_key_is_named() -> None:
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


def test_the_commented_file_is_a_scene_with_every_key() -> None:
    text = template_text("scene", all_keys=True)
    scene = check_scene(tomllib.loads(text))
    for key in _known_keys(Scene):
        last = key.rpartition(".")[2]
        assert last == ANY or re.search(rf"(?m)(^|[#\[{{, .]){last}( =|\.|\])", text), key
    load = {"component": "a", "nodes": [1], "direction": [1, 0, 0], "amplitude": 1}
    bare = check_scene({"components": {"a": {"stiffness": "a.mtx"}}, "loads": [load]})
    for table in ("ring", "response", "damping", "excitation"):
        assert getattr(scene, table) == getattr(bare, table)
