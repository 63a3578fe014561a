"""Reduced models answer as far as a study asks, or the run is refused with the line to write."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg as spl

from benchmarks.unreduced import UnreducedPart, unreduced
from tests.small_study import SMALL
from vanelock import nonlinear, parse_study
from vanelock.common.errors import InputError
from vanelock.input.band import asked_by, least_band, softest
from vanelock.input.cases.sweep import cases
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages
from vanelock.stages.parts.components import model_step, part_step
from vanelock.stages.parts.study_structure import StudyStructure
from vanelock.stages.plan import plan
from vanelock.stages.response.limits import frequencies, limits


def test_a_study_far_above_the_tenth_mode_answers_like_the_unreduced_sector(tmp_path):
    """Beyond the fourteenth elastic mode of the vane, 2,855 Hz: a fixed number, ten, ends below."""
    study = parse_study(
        f'{SMALL}mesh.correction = "none"\nrom.accuracy = 1e-5\nresponse.range = [3040, 3060]\n'
        "response.harmonics = 1\ndamping.ratio = 1e-7\n"
        'joints.patch = "node"\n'
    )
    stages = Stages(Cache(tmp_path, print), lambda event: None)
    (case,) = cases(study)
    (planned,) = plan([case])
    system = stages.get(planned.linear.system)
    assert system.band is not None
    assert system.band > 3060
    f = 3060.0
    found = nonlinear.linear_response(system, [f]).output[0, 1, 0]
    blade, shell = (stages.get(model_step(study, part, True)) for part in ("vane", "casing"))
    parts = UnreducedPart(blade), UnreducedPart(shell, 1)
    sector = StudyStructure(study).bare.segment.assembly(*parts)
    K, M = unreduced(sector, 1)
    casing = stages.get(planned.part("casing", 1))
    nodes = casing.masters.set("force")
    own = system.force[1].vector[casing.dofs(nodes).ravel()]
    load = np.zeros(K.shape[0], complex)
    load[sector.places("casing", nodes, "").ravel()] = own
    seen = blade.part.node_sets["output"][0]
    assert system.output_names[0] == "vane output 1"
    dynamic = (K - (2 * np.pi * f) ** 2 * M).tocsc()
    x = spl.splu(dynamic, "MMD_AT_PLUS_A", 0.01, options={"SymmetricMode": True}).solve(load)
    assert np.linalg.norm(dynamic @ x - load) < 1e-9 * np.linalg.norm(load)
    true = np.linalg.norm(x[sector.places("vane", np.array([seen]), "").ravel()])
    assert np.linalg.norm(found) == pytest.approx(true, rel=1e-4)


def test_what_a_study_asks_for_and_a_little_wider_range_needs_no_new_models():
    text = "[response]\nrange = [240, 300]\n[campbell]\nspeeds = [0, 20000]\nengine_orders = [7]\n"
    asked = asked_by(parse_study(text))
    assert asked == {"response.range": 300, "campbell.speeds": pytest.approx(20000 / 60 * 7)}
    least = least_band(asked)
    assert least is not None
    assert 1.05 * 20000 / 60 * 7 <= least <= 1.05 * 2 ** (1 / 3) * 20000 / 60 * 7
    heated = '[material.vane]\nE = [[20, "200 GPa"], [600, "50 GPa"]]\n'
    assert softest(parse_study(heated + "[temperature]\nvane = 480\n")) == pytest.approx(0.25)
    assert least_band({}) is None
    keys = {
        part_step(parse_study(f"[response]\nrange = [240, {high}]"), "vane").key
        for high in (315, 340, 380)
    }
    assert len(keys) == 1


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("response.range = [200, 900]", r"response\.range reaches 900 Hz.*write response\.range"),
        ("response.range = [200, 900]\nrom.modes = 2", r"leave out rom\.modes"),
        (
            'response.frequencies = [900]\nrom.route = "paper"',
            r"response\.frequencies reaches 900 Hz.*give more rom\.modes",
        ),
        ("", r"response\.mode = 2 reaches"),
    ],
)
def test_frequencies_beyond_what_modes_answer_are_refused(ring, text, line):
    """Modes of the two masses lie at 195 to 480 Hz."""
    found = replace(limits(ring, 2), band=300.0)
    with pytest.raises(InputError, match=line):
        frequencies(parse_study(text), found)


def test_a_system_with_a_band_refuses_frequencies_beyond_it(ring, tmp_path):
    known = replace(ring, band=300.0)
    place = tmp_path / "system.h5"
    known.save(place)
    assert nonlinear.System.load(place).band == 300.0
    line = r"frequencies: given 400 Hz: .* answer up to 300 Hz .*reduce them with band = 420"
    one, shares = nonlinear.Options(1), nonlinear.Shares(0.01, 0.01)
    for ask in (
        lambda: nonlinear.frequency_response(known, [250.0, 400.0], one),
        lambda: nonlinear.frequency_response(known, (250.0, 400.0), one),
        lambda: nonlinear.linear_response(known, [400.0]),
        lambda: nonlinear.adaptive_response(lambda h: known, [400.0], shares, one),
        lambda: nonlinear.parameter_response(known, 400.0, "mu", [0.1], one),
        lambda: nonlinear.peak_response(known, "mu", [0.1], (100.0, 400.0), one),
        lambda: nonlinear.hysteresis(known, (250.0, 400.0), one),
        lambda: nonlinear.time_response(known, 400.0, periods=1),
    ):
        with pytest.raises(InputError, match=line):
            ask()
    assert nonlinear.linear_response(known, [300.0]).converged.all()
