"""Steps that cases of a sweep share are made once, with the keys that each case has alone."""

from vanelock import parse_study
from vanelock.commands.run.graph import CaseWork, steps_of
from vanelock.input.cases.sweep import cases
from vanelock.input.cases.values import value_at
from vanelock.pipeline.step import reachable
from vanelock.stages import structure
from vanelock.stages.parts import components, segment, study_structure
from vanelock.stages.plan import plan
from vanelock.stages.response import responses

SWEPT = """
[sweep]
"joints.interlock.mu" = [0.1, 0.2, 0.3]
"joints.interlock.kt" = [1e6, 2e6]
"material.vane.E" = ["170 GPa", "171 GPa"]
"vane.thickness" = ["4.5 mm", "4.6 mm"]
"response.harmonics" = [1, 3]
"""


def test_cases_planned_together_have_the_keys_that_they_have_alone():
    """What workers rely on, who plan one case each, and so do runs that are taken up again."""
    found = cases(parse_study(SWEPT))
    planned = plan(found, lambda *_: None)
    for i in (0, 17, 30, 47):
        forget()
        (alone,) = plan([found[i]])
        assert names_of(alone) == names_of(planned[i])
        taken = {step.key for step in reachable(CaseWork(found[i]).steps())}
        assert names_of(alone).keys() <= taken


def names_of(planned):
    return {step.key: step.name for step in reachable(steps_of(planned))}


def forget():
    """All steps that cases share."""
    rooms = components, segment, study_structure, structure, responses
    for module in rooms:
        for value in vars(module).values():
            if hasattr(value, "cache_clear"):
                value.cache_clear()


def test_a_response_is_known_by_what_it_depends_on_and_not_by_its_case():
    """A swept key of which one value is the study's own adds nothing to compute for that value."""
    alone = plan(cases(parse_study("")), lambda *_: None)[0]
    swept = cases(parse_study('[sweep]\n"joints.interlock.mu" = [0.3, 0.5]\n'))
    same, other = plan(swept, lambda *_: None)
    louder = plan(cases(parse_study("[excitation]\nforce = 10")), lambda *_: None)[0]
    assert value_at(alone.case.study, "joints.interlock.mu") == 0.3
    assert {step.key for step in reachable(steps_of(same))} == {
        step.key for step in reachable(steps_of(alone))
    }
    assert same.response.name == "response mu=0.3"
    assert other.response.key != same.response.key
    stuck = [
        {step.key for step in reachable([each.response]) if step.stage == "stuck modes"}
        for each in (alone, same, other, louder)
    ]
    assert len(stuck[0]) == 2  # of rest and load, and of all harmonics
    assert stuck[0] == stuck[1] == stuck[2] == stuck[3]
