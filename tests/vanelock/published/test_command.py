"""A small campaign from end to end: what it leaves, and that a second run finds it all."""

import csv

import pytest

from vanelock import open_results, parse_study, run_campaign
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Done, Event
from vanelock.published.maps.plane import Plane

pytestmark = pytest.mark.system
TEXT = """
name = "small campaign"
[mesh]
size = "coarse"
[campbell]
engine_orders = [1]
[campaign]
mu = [0.1, 0.3]
interference = ["1 um", "2 um"]
harmonics = [1, 2]
map_mu = [0.1, 0.3]
map_interference = ["1 um", "2 um"]
map_load = [0.5, 1]
slants = []
[outputs]
shapes = false
loops = false
animations = false
report = false
"""


def test_statements_are_judged_by_numbers_which_a_second_run_finds(tmp_path):
    heard: list[Event] = []
    stated = run_campaign(parse_study(TEXT), tmp_path, heard.append, TEXT)
    (table,) = [event for event in heard if isinstance(event, Table) and event.key == "agreement"]
    assert [row[0] for row in table.rows] == [each.figure for each in stated]
    by_words = {each.says: each.agrees for each in stated}
    for words in (
        "hooks alone: nonlinear response coincides with the linear free one, no slip",
        "all stuck, small load: coupled and uncoupled responses coincide",
        "the peak falls as the friction coefficient grows",
    ):
        assert by_words[words] == "yes"
    with (tmp_path / "figures" / "agreement.csv").open() as file:
        rows = list(csv.DictReader(file))
    # a cell that begins with a sign is marked as text, lest a spreadsheet computes it
    assert [row["found"].removeprefix("'") for row in rows] == [each.found for each in stated]
    pictures = sorted(path.stem for path in (tmp_path / "figures").glob("fig*.png"))
    assert len(pictures) == 10
    for name in (*pictures, "map_interference", "map_load", "optimum"):
        assert (tmp_path / "figures" / f"{name}.png").is_file()
        assert (tmp_path / "figures" / f"{name}.csv").is_file()

    with open_results(tmp_path / "results.h5") as file:
        assert file.attrs["complete"]
        plane = Plane.load(file["campaign/map_interference"])
        peak = file["response/mu=0.1"].attrs["peak_amplitude"]
        again = file["response/harmonics=2"].attrs["peak_amplitude"]
    assert not plane.lost.any()
    # mu, interference, method: the case's own response adds a point at the vertex of its peak.
    assert plane.amplitude[0, 1, 0] == pytest.approx(peak, rel=1e-6)
    assert plane.amplitude[1, 1, 3] == pytest.approx(again, rel=1e-6)

    heard.clear()
    found = run_campaign(parse_study(TEXT), tmp_path, heard.append, TEXT)
    kept = ("fem", "system")
    computed = [event.stage for event in heard if isinstance(event, Done) and not event.cached]
    assert [stage for stage in computed if not stage.startswith(kept)] == []
    assert {each.says: each.agrees for each in found} == by_words
