"""Strain gauges of a study: what it may ask for, and what a run writes, prints and draws."""

import h5py
import numpy as np
import pytest
from matplotlib.image import imread

from vanelock import cases, fem, load_component, mesh, parse_study, rom, run_study
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import Response
from vanelock.pipeline.progress import Done, Event
from vanelock.report import Picture

ONE = "aerofoil = 2, span = 0.1, chord = 0.5"
STUDY = """
[mesh]
size = "coarse"
[response]
frequencies = [262, 266]
harmonics = 2
[outputs]
loops = false
report = false
[[outputs.gauges]]
aerofoil = 2
span = 0.1
chord = 0.5
[[outputs.gauges]]
aerofoil = 4
span = 0.8
chord = 0.3
side = "pressure"
direction = 30
"""


@pytest.mark.parametrize(
    ("gauge", "message"),
    [
        (
            "aerofoil = 5, span = 0, chord = 0",
            "outputs.gauges[0].aerofoil = 5: a vane segment has aerofoils 1 to 4",
        ),
        (
            "aerofoil = 0, span = 0, chord = 0",
            "outputs.gauges[0].aerofoil = 0: number of the aerofoil must be >= 1",
        ),
        (
            "aerofoil = 1, span = 1.2, chord = 0",
            "outputs.gauges[0].span = 1.2: fraction of the span must be <= 1",
        ),
        (
            f'{ONE}, side = "top"',
            'outputs.gauges[0].side = "top": side must be one of "suction" or "pressure"',
        ),
        (
            f'{ONE}, direction = "up"',
            'outputs.gauges[0].direction = "up": gauge direction must be "span", "chord" or the '
            "angle from the former to the latter, -180 to 180 deg",
        ),
        (
            f'{ONE}, length = "1 kg"',
            'outputs.gauges[0].length = "1 kg": expected a number in m, or text with a unit such '
            'as "1 m"',
        ),
        (
            "aerofoil = 1, span = 0, chrod = 0.5",
            "outputs.gauges[0].chord: must be given\n"
            "study: outputs.gauges[0].chrod = 0.5: unknown key; nearest known key: "
            "outputs.gauges.chord",
        ),
    ],
)
def test_what_a_study_may_ask_for(gauge, message):
    with pytest.raises(InputError) as caught:
        parse_study(f"[outputs]\ngauges = [{{ {gauge} }}]")
    assert str(caught.value) == f"study: {message}"


def test_gauges_are_not_swept():
    study = parse_study(
        f'[sweep]\n"outputs.gauges.span" = [0.1, 0.2]\n[outputs]\ngauges = [{{{ONE}}}]'
    )
    with pytest.raises(InputError, match="only keys that hold a number or a choice of words can"):
        cases(study)
    fewer = parse_study(f'[sweep]\n"vane.aerofoils" = [4, 1]\n[outputs]\ngauges = [{{{ONE}}}]')
    with pytest.raises(InputError, match=r"aerofoil = 2: a vane segment has aerofoils 1 to 1"):
        cases(fewer)


def test_a_run_writes_the_strain_of_the_recovered_field(tmp_path, monkeypatch):
    for other in ("all_modes", "response"):
        monkeypatch.setattr(f"vanelock.results.figures.pictures.{other}", lambda *_: [])
    bare = Picture(tmp_path / "mesh.png", "", "")
    monkeypatch.setattr("vanelock.results.figures.pictures.mesh", lambda *_: bare)
    heard: list[Event] = []
    study = parse_study(STUDY)
    (summary,) = run_study(study, tmp_path, heard.append)
    with h5py.File(tmp_path / "results.h5") as file:
        response = Response.load(file["response/nominal"])
        dataset = file["response/nominal/gauge"]
        written, about = dataset[()], dict(dataset.attrs)
        part = mesh.Part.load(file["mesh/vane"])
    components = [load_component(tmp_path / "results.h5", part) for part in ("vane", "casing")]
    assert written.shape == (2, 3, 2)
    assert about["unit"] == "1"
    assert about["name"].tolist() == [
        "aerofoil 2, suction side, span 0.1, chord 0.5, along span",
        "aerofoil 4, pressure side, span 0.8, chord 0.3, along 30 deg",
    ]
    # The same from the displacements of all nodes, through the gauges' own functionals.
    elastic = study.material.vane
    model = fem.assemble(part, fem.Material(elastic.E, elastic.nu, elastic.rho))
    recovery = rom.recovery(components[0], model)
    for g, (number, span, chord, side, direction) in enumerate(
        [(2, 0.1, 0.5, "suction", "span"), (4, 0.8, 0.3, "pressure", 30.0)]
    ):
        spot = mesh.on_aerofoil(study.vane, 16, number, span, chord, side, direction)
        gauge = fem.gauge(part, spot.position, spot.direction, 0.002, spot.normal)
        assert about["position"][g] == pytest.approx(gauge.position, abs=1e-12)
        for h in range(3):
            q = rom.split(*components, response.x[h].T)[0]
            u = recovery.displacement(q, int(response.harmonic_diameters[h]))
            np.testing.assert_allclose(
                written[:, h, g], gauge.strain(u), rtol=0, atol=1e-9 * np.abs(written).max()
            )
    # The table holds half the peak-to-peak at the peak, in microstrain.
    assert summary.peak is not None
    table = next(event for event in heard if isinstance(event, Table) and event.key == "gauges")
    angles = np.linspace(0, 2 * np.pi, 20001)
    wave = np.exp(1j * np.outer(angles, np.arange(3)))
    history = (wave @ written[summary.peak.point]).real
    for g, row in enumerate(table.shown):
        assert row[1] == about["name"][g]
        assert row[2] == pytest.approx(1e6 * np.ptp(history[:, g]) / 2, rel=1e-6)
        assert row[3] == pytest.approx(1e6 * written[summary.peak.point, 0, g].real)
    picture = imread(tmp_path / "shapes" / "stress_nominal.png")
    assert picture.shape[1] == 1800
    # At a sharp root half of a gauge would lie inside the shroud.
    sharp = "[vane]\nroot_fillet = 0\n" + STUDY
    rooted = parse_study(sharp.replace("span = 0.1", "span = 0"))
    heard.clear()
    with pytest.raises(
        InputError, match=r"^outputs.gauges\[0\]: vane: gauge of .* off the surface$"
    ):
        run_study(rooted, tmp_path, heard.append)
    stages = {event.stage for event in heard if isinstance(event, Done)}
    assert "linear limits" in stages
    assert "response nominal" not in stages  # refused before it, not after
    # A second run finds everything as it was; other gauges cost themselves alone.
    assert not _computed(study, tmp_path)
    moved = parse_study(STUDY.replace("span = 0.1", "span = 0.2"))
    own = {"fem vane", "rom vane, condensed", "gauges", "shapes/stress_nominal.png"}
    assert _computed(moved, tmp_path) == own


def _computed(study, folder):
    heard: list[Event] = []
    run_study(study, folder, heard.append)
    done = [event for event in heard if isinstance(event, Done) and not event.cached]
    return {event.stage for event in done if event.seconds > 0.01 or "gauges" in event.stage}
