"""What is left out of a study for its linear limits, and for the modes with all contacts stuck."""

from vanelock.input.schema.study import Study
from vanelock.pipeline.step import Step
from vanelock.rom import Component, System
from vanelock.stages.parts.components import system_step


def linear_system_step(
    study: Study, vane: Step[Component], casing: Step[Component]
) -> Step[System]:
    """The system without friction and preload, which the linear limits do not depend on."""
    return system_step(without_friction(study), vane, casing)


def without_friction(study: Study) -> Study:
    """The study of the linear limits: no friction, no interference."""
    joints = study.joints.model_copy(
        update={
            name: getattr(study.joints, name).model_copy(update={"mu": 0.0, "interference": 0.0})
            for name in ("hook", "interlock")
        }
    )
    return study.model_copy(update={"joints": joints})


def without_load(study: Study) -> Study:
    """The study of the modes with all contacts stuck: no friction, and the default load."""
    load = study.excitation.model_copy(update={"force": None, "unbalance": None})
    return without_friction(study).model_copy(update={"excitation": load})


def is_loaded(study: Study) -> bool:
    """Whether a study has another load than the default one."""
    return (study.excitation.force, study.excitation.unbalance) != (None, None)
