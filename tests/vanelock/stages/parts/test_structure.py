"""Parts and what joins them: mesh correction, patches, modes of a vane alone, gauges."""

import h5py
import numpy as np
import pytest

from tests.vanelock.stages.conftest import COARSER, planned_of
from vanelock import cases, fem, load_component, mesh, parse_study, rom
from vanelock.analyses.mistuning import _vane_modes_step
from vanelock.commands.fit.refit_model import rejoined
from vanelock.common.errors import InputError
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import Done, silent
from vanelock.pipeline.step import Stages
from vanelock.stages.parts.components import averaged
from vanelock.stages.parts.outputs import gauges_step
from vanelock.stages.response.limits import Limits

TEXT = """
[material.vane]
E = [[20, "200 GPa"], [620, "155 GPa"]]
[temperature]
vane = 420
[response]
harmonics = 1
"""


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return Stages(Cache(tmp_path_factory.mktemp("kept"), print), silent)


@pytest.fixture(scope="module")
def model(kept, ring_text):
    return rejoined(parse_study(ring_text("tetra10", COARSER) + TEXT), kept)


def test_limits_are_lower_by_what_the_mesh_adds_and_hold_it(golden):
    with h5py.File(golden("default").folder / "results.h5") as file:
        limits = Limits.load(file["limits/all"])
        response = Response.load(file["response/nominal"])
    # What the same vane has with elements of 8 mm, 0.9 % lower than with 16 mm.
    assert limits.free_frequency == pytest.approx(251.5, rel=0.01)
    assert limits.stuck_frequency == pytest.approx(282.2, rel=0.01)
    assert 0.07 < limits.stuck_lowered < limits.free_lowered < 0.1
    worst = np.nanmax([limits.free_error[:6], limits.stuck_error[:6]])
    assert 0 < worst < 1e-4  # of the reduction alone
    peak = response.frequency[response.amplitude.max(axis=(1, 2)).argmax()]
    assert limits.free_frequency < peak < limits.stuck_frequency


def test_a_fit_joins_the_structure_of_the_run(kept, model, ring_text):
    own = model.system({})
    expected = kept.get(planned_of(ring_text("tetra10", COARSER) + TEXT).system)
    for k, one in expected.diameters.items():
        scale = np.abs(one.K).max()
        np.testing.assert_allclose(own.at(k).K, one.K, atol=1e-12 * scale)


def test_at_rest_the_answers_to_interference_lose_what_the_mesh_adds(kept, ring_text):
    text = ring_text("tetra10", COARSER) + TEXT
    plain, corrected = (
        kept.get(planned_of(each).system) for each in (text + '[mesh]\ncorrection = "none"\n', text)
    )
    for shape in rom.rest_shapes(plain, ("hook", "interlock")).T:
        before, after = (np.vdot(shape, each.at(0).K @ shape).real for each in (plain, corrected))
        assert 0.5 * before <= after < before


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


RIGID = 6
"""Modes of a body that nothing holds."""


def test_modes_of_a_vane_alone_are_all_its_stiffness(stages, ring_text):
    """Σ g k gᵀ of all of them is what (1 + δ)² times the modulus adds, over (1 + δ)² - 1."""
    text, deviation = ring_text("tetra10", COARSER) + '[mesh]\ncorrection = "none"\n', 0.03
    modulus = parse_study(text).material.vane.E
    stiffer = f"[material.vane]\nE = {modulus * (1 + deviation) ** 2!r}\n"
    planned, other = planned_of(text), planned_of(text + stiffer)
    whole = planned.structure.whole
    vane = stages.get(planned.part("vane", 0))
    modes = stages.get(_vane_modes_step(planned, vane.size - RIGID))
    system, changed = stages.get(whole), stages.get(other.structure.whole)
    for k in range(7):
        g = modes.rows[k]
        added = changed.at(k).K - system.at(k).K
        found = ((1 + deviation) ** 2 - 1) * (g.conj().T * modes.stiffness) @ g
        np.testing.assert_allclose(found, added, atol=1e-7 * np.abs(added).max())


ONE = "aerofoil = 2, span = 0.1, chord = 0.5"
COARSE = '[mesh]\nsize = "coarse"\n'


REFUSED = {
    "aerofoil = 5, span = 0, chord = 0": "aerofoil = 5: a vane segment has aerofoils 1 to 4",
    "aerofoil = 1, span = 1.2, chord = 0": "span = 1.2: fraction of the span must be <= 1",
    f'{ONE}, direction = "up"': 'direction = "up": gauge direction must be "span", "chord" or the ',
    f'{ONE}, length = "1 kg"': 'length = "1 kg": expected a number in m, or text with a unit such ',
    "aerofoil = 1, span = 0, chrod = 1": "chord: must be given\nstudy: outputs.gauges[0].chrod = 1",
}


@pytest.mark.parametrize("gauge", REFUSED)
def test_what_a_study_may_ask_for(gauge):
    with pytest.raises(InputError) as caught:
        parse_study(f"[outputs]\ngauges = [{{ {gauge} }}]")
    assert str(caught.value).startswith(f"study: outputs.gauges[0].{REFUSED[gauge]}")


def test_gauges_are_not_swept():
    study = parse_study(
        f'[sweep]\n"outputs.gauges.span" = [0.1, 0.2]\n[outputs]\ngauges = [{{{ONE}}}]'
    )
    with pytest.raises(InputError, match="only keys that hold a number or a choice of words can"):
        cases(study)
    fewer = parse_study(f'[sweep]\n"vane.aerofoils" = [4, 1]\n[outputs]\ngauges = [{{{ONE}}}]')
    with pytest.raises(InputError, match=r"aerofoil = 2: a vane segment has aerofoils 1 to 1"):
        cases(fewer)


def test_a_run_writes_the_strain_of_the_recovered_field(golden):
    run = golden("accuracy")
    study, (summary,) = parse_study(run.text), run.summaries
    with h5py.File(run.folder / "results.h5") as file:
        response = Response.load(file["response/nominal"])
        system = rom.System.load(file["response/nominal/system"])
        dataset = file["response/nominal/gauge"]
        written, about = dataset[()], dict(dataset.attrs)
        part = mesh.Part.load(file["mesh/vane"])
    components = [load_component(run.folder / "results.h5", part) for part in ("vane", "casing")]
    H = response.harmonics
    assert written.shape == (response.points, H + 1, 1)
    assert about["unit"] == "1"
    elastic = study.material.vane
    model = fem.assemble(part, fem.Material(elastic.E, elastic.nu, elastic.rho))
    recovery = rom.recovery(components[0], model)
    other = 'aerofoil = 4, span = 0.8, chord = 0.3, side = "pressure", direction = 30'
    two = parse_study(f"outputs.gauges = [{{ {ONE} }}, {{ {other} }}]\n{COARSE}")
    found = gauges_step(two).compute(recovery)
    assert found.names == (
        "aerofoil 2, suction side, span 0.1, chord 0.5, along span",
        "aerofoil 4, pressure side, span 0.8, chord 0.3, along 30 deg",
    )
    assert about["name"].tolist() == [found.names[0]]
    # The same from the displacements of all nodes at the peak, through the gauges' functionals.
    top, known = summary.peak.point, range(3)
    q = [system.at(h).split(response.x[h][top])["vane"] for h in known]
    fields = [recovery.displacement(q[h], int(response.harmonic_diameters[h])) for h in known]
    for g, (number, span, chord, side, direction) in enumerate(
        [(2, 0.1, 0.5, "suction", "span"), (4, 0.8, 0.3, "pressure", 30.0)]
    ):
        spot = mesh.on_aerofoil(study.vane, 16, number, span, chord, side, direction)
        gauge = fem.gauge(part, spot.position, spot.direction, 0.002, spot.normal)
        assert found.positions[g] == pytest.approx(gauge.position, abs=1e-12)
        strain = np.array([gauge.strain(u) for u in fields])
        scale = 1e-9 * np.abs(strain).max()
        np.testing.assert_allclose(found.rows[g] @ np.transpose(q), strain, rtol=0, atol=scale)
        if g == 0:
            assert about["position"][0] == pytest.approx(gauge.position, abs=1e-12)
            np.testing.assert_allclose(written[top, known, 0], strain, rtol=0, atol=scale)
    # Half of one of 5 cm would lie beyond the trailing edge; it is refused before the response.
    long = 'aerofoil = 2, span = 0.5, chord = 1, direction = "chord", length = "50 mm"'
    beyond = gauges_step(parse_study(f"{COARSE}[outputs]\ngauges = [{{ {long} }}]"))
    line = r"^outputs.gauges\[0\]: vane: gauge of .* off the surface$"
    with pytest.raises(InputError, match=line):
        beyond.compute(recovery)
    done = [event.stage for event in run.events if isinstance(event, Done)]
    assert done.index("gauges") < done.index("response nominal")
    # The table holds half the peak-to-peak at the peak, in microstrain.
    wave = np.exp(1j * np.outer(np.linspace(0, 2 * np.pi, 20001), np.arange(H + 1)))
    (row,) = run.table("gauges").shown
    assert row[1] == found.names[0]
    assert row[2] == pytest.approx(1e6 * np.ptp((wave @ written[top, :, 0]).real) / 2, rel=1e-6)
    assert row[3] == pytest.approx(1e6 * written[top, 0, 0].real)
