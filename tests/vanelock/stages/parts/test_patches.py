"""Contacts on nodes and on patches, as a study says it, on segments of one aerofoil."""

import numpy as np
import pytest

from benchmarks.unreduced import unreduced_segment as unreduced
from tests.vanelock.stages.conftest import PARTS, STEEL
from vanelock import fem, parse_study
from vanelock.common.errors import InputError
from vanelock.input.cases.sweep import cases
from vanelock.stages.parts.components import averaged
from vanelock.stages.parts.segment import Joint
from vanelock.stages.plan import plan

SWEPT = """
[ring]
sectors = 64
[vane]
aerofoils = 1
root_fillet = 0
interlock_nodes = 3
[vane.hook]
band_nodes = 5
[mesh]
size = "40 mm"
correction = "none"
[joints]
interlock = false
[response]
frequencies = [266]
harmonics = 1
[sweep]
"joints.patch" = ["node", "area"]
"""


def test_a_study_says_what_its_contacts_act_on():
    hooks, interlock = ("hook_front", "hook_rear"), ("interlock_left", "interlock_right")
    for text, vane, casing in (
        ("", hooks + interlock, hooks),
        ("joints.interlock = false", hooks, hooks),
        ("joints.interlock = true", hooks + interlock, hooks),
        ('joints.patch = "node"', (), ()),
    ):
        study = parse_study(text)
        assert averaged(study, "vane") == vane
        assert averaged(study, "casing") == casing
    with pytest.raises(InputError, match=r'joints.patch = "face"'):
        parse_study('joints.patch = "face"')


def test_hooks_on_nodes_and_on_patches_side_by_side(stages):
    """Both cases have the frequencies of the unreduced sector, to the accuracy of the reduction."""
    planned = plan(cases(parse_study(SWEPT)), lambda *_: None)
    models = [fem.assemble(stages.get(planned[0].meshes[part]), STEEL) for part in PARTS]
    hook, found = Joint("hook", 1.67e7, 1.67e7, 0.3, 20e-6), []
    for each, sets in zip(planned, ((), ("hook_front", "hook_rear")), strict=True):
        squared, _ = fem.eigenpairs(*unreduced(*models, [hook], 1, sets), 3)
        truth = np.sqrt(squared) / (2 * np.pi)
        free = stages.get(each.linear.limits).free[:3]
        assert free == pytest.approx(truth, rel=1e-4)
        assert stages.get(each.response).converged.all()
        found.append(free)
    assert np.abs(found[1] / found[0] - 1).max() > 1e-3  # nodes and patches can be told apart
