"""More kills: in a response to an accuracy, and of a sweep on two workers.

Too long for a sample, so that no run of all tests collects it:
`python -m pytest tests/verification/kills/further_kills.py`.
"""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.verification.kills import killing
from tests.verification.kills.killing import Moment
from tests.verification.kills.victim import Victim, finish

SEED, EACH = 22, 5

ACCURATE = """
accuracy = 0.03
mesh.size = "coarse"
excitation.force = 30
joints.interlock.mu = 0.15
response.friction = "isotropic"
outputs = { shapes = false, loops = false, report = false }
"""
SWEPT = """
mesh.size = "coarse"
excitation.force = 30
response.harmonics = 1
sweep = { "joints.interlock.mu" = [0.1, 0.15, 0.2, 0.3] }
outputs = { shapes = false, loops = false, report = false }
"""


def test_killed_in_a_response_to_an_accuracy(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    rng = np.random.default_rng(SEED)
    study = tmp_path / "scene.toml"
    study.write_text(ACCURATE)
    assert killing.run(study, tmp_path / "whole").status == 0
    victim = Victim(study, tmp_path / "killed")
    victim.several = {"mesh-correction"}
    longest = killing.seconds(tmp_path / "whole")["response nominal"]
    for i in range(4 * EACH):
        if victim.hits["response"] == EACH:
            break
        after = float(rng.uniform(0, 0.3)) * longest
        if not victim.kill(Moment("response", "response ", after, alone=True)).hit:
            victim.forget("response ")
        elif i % 3 == 0:
            victim.tear(rng)
    finish(victim, tmp_path / "whole")
    assert victim.hits["response"] >= EACH
    record_property("kills in the response", victim.hits["response"])
    record_property("seed", SEED)


def test_killed_with_two_workers(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    rng = np.random.default_rng(SEED + 1)
    study = tmp_path / "scene.toml"
    study.write_text(SWEPT)
    began = time.monotonic()
    assert killing.run(study, tmp_path / "whole").status == 0  # by one process
    took = time.monotonic() - began
    victim = Victim(study, tmp_path / "killed", "--workers", "2")
    victim.several = {"preload"}
    for _ in range(EACH):
        victim.kill(Moment("any moment", after=float(rng.uniform(3, 0.6 * took))))
    for _ in range(EACH):  # as soon as a worker has solved a point
        if not victim.kill(Moment("within a case", file="cache/response*.points")).hit:
            victim.forget("response ")
    finish(victim, tmp_path / "whole")
    assert victim.hits["any moment"] >= EACH
    for name, count in victim.hits.items():
        record_property(name, count)
    record_property("processes left behind", 0)
    record_property("seed", SEED + 1)
