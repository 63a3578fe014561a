"""A small campaign from end to end: what it leaves, and that a second run finds it all."""

import csv
import shutil

import pytest

from tests.verification.kills.killing import numbers
from vanelock import open_results, parse_study, run_campaign
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Done, Event, Tasks
from vanelock.published.maps.plane import Plane

TEXT = """
name = "small campaign"
[mesh]
size = "coarse"
[campaign]
mu = [0.1, 0.3]
interference = ["1 um", "2 um"]
harmonics = [1, 2]
map_mu = [0.1, 0.3]
map_interference = ["1 um", "2 um"]
map_load = [0.5, 1]
slants = [45]
[outputs]
shapes = false
loops = false
animations = false
report = false
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    heard: list[Event] = []
    stated = run_campaign(parse_study(TEXT), folder, heard.append, TEXT)
    return folder, heard, stated


def test_every_statement_is_judged_by_numbers(ran):
    folder, heard, stated = ran
    (table,) = [event for event in heard if isinstance(event, Table) and event.key == "agreement"]
    assert [row[0] for row in table.rows] == [each.figure for each in stated]
    by_words = {each.says: each for each in stated}
    hooks = by_words["hooks alone: nonlinear response coincides with the linear free one, no slip"]
    assert hooks.agrees == "yes"
    stuck = by_words["all stuck, small load: coupled and uncoupled responses coincide"]
    assert stuck.agrees == "yes"
    falls = by_words["the peak falls as the friction coefficient grows"]
    assert falls.agrees == "yes"
    with (folder / "figures" / "agreement.csv").open() as file:
        rows = list(csv.DictReader(file))
    # a cell that begins with a sign is marked as text, lest a spreadsheet computes it
    found = [row["found"].removeprefix("'") for row in rows]
    assert found == [each.found for each in stated]


def test_every_figure_has_its_data_beside_it(ran):
    folder, _, _ = ran
    pictures = sorted(path.stem for path in (folder / "figures").glob("fig*.png"))
    assert len(pictures) == 10
    assert all((folder / "figures" / f"{stem}.csv").is_file() for stem in pictures)
    for name in ("map_interference", "map_load", "map_slant45", "optimum"):
        assert (folder / "figures" / f"{name}.png").is_file()
        assert (folder / "figures" / f"{name}.csv").is_file()


def test_the_map_is_that_of_the_cases(ran):
    folder, _, _ = ran
    with open_results(folder / "results.h5") as file:
        assert file.attrs["complete"]
        plane = Plane.load(file["campaign/map_interference"])
        peak = file["response/mu=0.1"].attrs["peak_amplitude"]
        again = file["response/harmonics=2"].attrs["peak_amplitude"]
    assert not plane.lost.any()
    # mu, interference, method: the case's own response adds a point at the vertex of its peak.
    assert plane.amplitude[0, 1, 0] == pytest.approx(peak, rel=1e-6)
    assert plane.amplitude[1, 1, 3] == pytest.approx(again, rel=1e-6)


def test_a_second_run_computes_nothing(ran):
    folder, _, stated = ran
    heard: list[Event] = []
    again = run_campaign(parse_study(TEXT), folder, heard.append, TEXT)
    kept = ("fem", "system")
    computed = [event.stage for event in heard if isinstance(event, Done) and not event.cached]
    assert [stage for stage in computed if not stage.startswith(kept)] == []
    same = [(each.says, each.agrees) for each in stated]
    assert [(each.says, each.agrees) for each in again] == same


def test_two_processes_compute_the_same(ran, tmp_path):
    """A third of the cases by two processes, and of a map: all numbers are those of one process."""
    folder, _, _ = ran
    gone = ("response-*", "map-friction--load*")
    shutil.copytree(folder, tmp_path / "two", ignore=shutil.ignore_patterns("results.h5"))
    for pattern in gone:
        for path in sorted((tmp_path / "two" / "cache").rglob(pattern))[::3]:
            path.unlink()
    heard: list[Event] = []
    run_campaign(parse_study(TEXT), tmp_path / "two", heard.append, TEXT, workers=2)
    assert [event.done for event in heard if isinstance(event, Tasks)][-1] >= 2
    found, expected = (numbers(path / "results.h5") for path in (tmp_path / "two", folder))
    assert found == expected
