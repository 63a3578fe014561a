"""Error against cost, measured: a small study at few frequencies; what settings there are."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.small_study import SMALL
from vanelock import converge_study, parse_study
from vanelock.commands.converge.converge import vertex
from vanelock.commands.converge.settings import markdown, settings_of, table
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Event, Finished, Notice

STUDY = f"""
name = "small"
{SMALL}
joints.interlock.mu = 0.15
response = {{ harmonics = 1, range = [251, 256], points = 3 }}
sweep."joints.interlock.mu" = [0.1, 0.2]
"""


def values(text, key):
    levels = settings_of(parse_study(text))[key]
    return [level.shown for level in levels], [level.shown for level in levels if level.chosen]


def test_every_setting_has_the_studys_own_value_once():
    found = settings_of(parse_study(""))
    every = "mesh.size rom.accuracy response.harmonics response.samples response.points"
    every += " response.coupling joints.patch"
    assert list(found) == every.split()
    for key, levels in found.items():
        assert sum(level.chosen for level in levels) == 1, key
        assert len({level.shown for level in levels}) == len(levels)
    listed = settings_of(parse_study("[response]\nfrequencies = [250, 260]"))
    assert "response.points" not in listed
    refusal = r'--setting "mesh": this study has mesh.size, rom.accuracy'
    with pytest.raises(InputError, match=refusal):
        settings_of(parse_study(""), 1e5, ("mesh",))


def test_values_lie_around_what_the_study_has_and_meshes_grow_up_to_the_limit_alone():
    assert values("[rom]\naccuracy = 5e-4", "rom.accuracy")[1] == ["0.0005"]
    assert values("[rom]\nmodes = 8", "rom.modes") == (["4", "8", "16", "32"], ["8"])
    assert values("[rom]\nmodes = [8, 5]", "rom.modes")[0][:2] == ["4 + 2", "8 + 5"]
    assert values('[rom]\nroute = "paper"', "rom.modes")[1] == ["10"]
    assert values("[response]\nharmonics = 12", "response.harmonics")[0][-1] == "23"
    assert values("[response]\npoints = 50", "response.points")[1] == ["50"]
    isotropic = parse_study('[response]\nfriction = "isotropic"')
    assert "response.samples" not in settings_of(isotropic, 1e5)
    study = parse_study('[mesh]\nsize = "coarse"\nface_nodes = 170')
    few, many = (settings_of(study, dofs)["mesh.size"] for dofs in (1.2e5, 3e5))
    assert [level.shown for level in few] == ["coarse", "11.3 mm"]
    assert len(many) > len(few)
    assert [level.study.mesh.face_nodes for level in few] == [170, None]


def test_the_vertex_of_a_parabola():
    f = np.linspace(9.0, 11.0, 9)
    a = 3 - (f - 10.1) ** 2
    np.testing.assert_allclose(vertex(f, a), (3, 10.1), rtol=1e-12)
    at_end = vertex(f, f)
    assert at_end == (11.0, 11.0)
    jump = np.where(f > 10, 0.1, f)  # no parabola passes a jump
    assert vertex(f, jump) == (10.0, 10.0)
    lost = np.where(f == 10.25, np.nan, a)
    assert vertex(f, lost) == (a[f == 10.0][0], 10.0)


FEW = ("1", "3", "5", "uncoupled", "coupled")
"""Values that are tried."""


@pytest.fixture(scope="module", autouse=True)
def few_values():
    def few(*given):
        return {
            key: [level for level in levels if level.shown in FEW]
            for key, levels in settings_of(*given).items()
        }

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("vanelock.commands.converge.converge.settings_of", few)
        yield


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("converge")
    heard: list[Event] = []
    only = ("response.harmonics", "response.coupling")
    found = converge_study(parse_study(STUDY), folder, heard.append, only)
    return folder, found, heard


def test_the_finest_value_is_the_reference(measured):
    _, found, _ = measured
    by_setting = {
        name: [o for o in found if o.setting == name] for name in {o.setting for o in found}
    }
    assert {name: [o.value for o in each] for name, each in by_setting.items()} == {
        "response.harmonics": ["1", "3", "5"],
        "response.coupling": ["uncoupled", "coupled"],
    }
    for outcomes in by_setting.values():
        *rest, last = outcomes
        assert np.isnan(last.amplitude_error)
        for o in rest:
            assert o.amplitude_error == pytest.approx(abs(o.amplitude / last.amplitude - 1))
            assert o.frequency_error == pytest.approx(abs(o.frequency / last.frequency - 1))
        assert sum(o.chosen for o in outcomes) == 1
    harmonics = by_setting["response.harmonics"]
    assert harmonics[0].frequency_error > 10 * harmonics[1].frequency_error
    assert harmonics[0].amplitude_error > harmonics[1].amplitude_error
    own = {o.setting: o for o in found if o.chosen}
    assert own["response.harmonics"].amplitude == own["response.coupling"].amplitude


def test_what_a_measurement_leaves(measured):
    folder, found, heard = measured
    assert any(isinstance(e, Notice) and "unswept" in e.text for e in heard)
    records = json.loads((folder / "converge.json").read_text())
    assert [r["amplitude"] for r in records] == [o.amplitude for o in found]
    assert (folder / "converge.md").read_text() == markdown(found)
    assert (folder / "figures" / "converge.png").stat().st_size > 20_000
    (shown,) = [e for e in heard if isinstance(e, Table)]
    assert shown == table(found, "small")
    lost = table([replace(found[0], lost=2)], "x").notes
    assert "response.harmonics = 1: 2 points DID NOT CONVERGE" in lost
    assert isinstance(heard[-1], Finished)
