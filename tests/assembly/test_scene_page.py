"""The page on scenes names every key, and its example is one."""

import re
import tomllib
from pathlib import Path

from vanelock.assembly import Scene, check_scene
from vanelock.study.messages import ANY, known_keys

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "scene_file.md").read_text("utf-8")


def test_every_key_is_named() -> None:
    keys = [key for key in known_keys(Scene) if not key.startswith(("response.", "units."))]
    last = {key.rpartition(".")[2] for key in keys} - {ANY}
    missing = [
        key for key in sorted(last) if not re.search(rf"(?m)(^|[ `.\[\"]){key}[`\].=\" ]", PAGE)
    ]
    assert not missing


def test_the_example_is_a_scene() -> None:
    found = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    scene = check_scene(tomllib.loads(found[1]))
    assert set(scene.components) == {"lower", "upper"}
    assert scene.loads[1].harmonic == 0
