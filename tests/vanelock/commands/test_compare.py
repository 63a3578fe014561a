"""Which cases of two runs belong together, and what is said of those that do not."""

from pathlib import Path

import numpy as np
import pytest

from tests.vanelock.pipeline.test_display import summary
from tests.vanelock.run_results import case_of
from vanelock import compare_runs, parse_study
from vanelock.commands.compare import compared, matched
from vanelock.commands.stored.contents import StoredRun
from vanelock.common.errors import InputError
from vanelock.input.settings import as_text, settings
from vanelock.pipeline.progress import silent
from vanelock.results.files.run_folder import OutputFiles
from vanelock.results.files.writer import Results
from vanelock.stages.response.responses import Monitor
from vanelock.stages.response.summary import Peak


def case(name, values, peak=1e-5, **counts):
    f = np.array([1.0, 2, 3])
    own = summary(case=name, values=values, peak=Peak(1, 250.0, peak, False), **counts)
    return case_of(name, values, (), (f, f, np.ones(3)), summary=own)


def run(label, *cases, text="", complete=True, monitor="vane output 1, radial"):
    study = parse_study(text)
    return StoredRun(
        study,
        Monitor(monitor, 0, 0),
        OutputFiles(Path(label), silent),
        label=label,
        complete=complete,
        settings=study.model_dump(mode="json"),
        cases={each.name: each for each in cases},
    )


MU, H = "joints.interlock.mu", "response.harmonics"


def test_cases_are_paired_by_name_values_and_order_and_not_guessed():
    one = run("A", case("mu=0.1", {MU: 0.1}), case("mu=0.2", {MU: 0.2}), case("nominal", {}))
    other = run(
        "B",
        case("mu=0.2,harmonics=3", {MU: 0.2, H: 3}),
        case("mu=0.1", {MU: 0.1}),
        case("force=2", {"excitation.force": 2.0}),
        case("force=3", {"excitation.force": 3.0}),
    )
    pairs, notes = matched(one, other)
    assert [(one.name, other.name) for one, other in pairs] == [
        ("mu=0.1", "mu=0.1"),
        ("mu=0.2", "mu=0.2,harmonics=3"),
        ("nominal", "force=2"),
    ]
    assert [note.rpartition(", ")[2] for note in notes] == [
        "by values",
        "by order",
        "force=3 is in B alone",
    ]
    one = run("A", case("mu=0.2", {MU: 0.2}))
    other = run("B", *(case(f"mu=0.2,harmonics={h}", {MU: 0.2, H: h}) for h in (1, 3)))
    pairs, notes = matched(one, other)
    assert len(pairs) == 1
    assert notes[0].endswith("by order")
    assert notes[-1] == "mu=0.2,harmonics=3 is in B alone"


def test_differences_are_those_of_the_second_over_the_first():
    _, inputs, results, _ = compared(
        run("A", case("nominal", {}, 4e-5, harmonics=3)),
        run("B", case("nominal", {}, 3e-5, harmonics=5), text='[vane]\nthickness = "5 mm"'),
    )
    assert inputs.rows == [("vane.thickness", "4.5 mm", "5 mm")]
    assert [column.head for column in results.columns] == ["of", "what", "A", "B", "difference"]
    lines = {what: rest for _, what, *rest in results.rows}
    assert lines["peak"] == ["40 µm", "30 µm", "-25 %"]
    assert lines["at"] == ["250 Hz", "250 Hz", "same"]
    assert lines["H"] == ["3", "5", ""]  # a count is no measured value


def test_what_is_missing_is_said():
    notes, *_ = compared(
        run("A", case("nominal", {})), run("B", complete=False, monitor="vane output 2, axial")
    )
    assert notes[0].startswith("B: the run is not complete; compared: 0 cases")
    assert "different displacements: vane output 1, radial in A" in notes[1]
    assert notes[2] == "nominal is in A alone"


def test_folders_without_whole_results_are_refused_in_one_line(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        with Results(tmp_path / name / "results.h5").edit() as file:
            file.attrs["complete"] = True
    for one, other, expected in (
        ("none", "a", "none: no such folder"),
        ("a", "b", r"a/results.h5: lacks what a run writes .*provenance"),
    ):
        with pytest.raises(InputError, match=expected):
            compare_runs(tmp_path / one, tmp_path / other)


def test_settings_are_given_in_peoples_units():
    values = {
        "vane.thickness": (0.0045, "4.5 mm"),
        "joints.hook.interference": (20e-6, "20 µm"),
        "joints.hook.kn": (1.67e7, "16.7 N/µm"),
        "material.vane.E": (170e9, "170 GPa"),
        "vane.stagger": (35.0, "35°"),
        "response.frequencies": ([250.0, 260.0], "250, 260 Hz"),
        "outputs.show": (["loops"], '["loops"]'),
        "joints.interlock": (False, "no"),
        "sweep.mesh.size": ("coarse", "coarse"),
        "accuracy": (None, "not set"),
    }
    assert {key: as_text(key, value) for key, (value, _) in values.items()} == {
        key: text for key, (_, text) in values.items()
    }


def test_changed_settings_are_those_that_differ_from_the_defaults():
    text = '[excitation]\nforce = 30\n[vane]\nthickness = "4.5 mm"\nchord = "50 mm"'
    assert [each.key for each in settings(parse_study(text)) if each.changed] == ["vane.chord"]
