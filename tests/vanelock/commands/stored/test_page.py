"""All that a run shows is made again from its results alone, and is the same."""

import shutil
from pathlib import Path

import pytest

from vanelock.commands.stored.run import show_again
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Event
from vanelock.results.files.writer import Results


def shown(folder: Path) -> dict[str, bytes]:
    """All pictures, tables and pages in a run's folder."""
    files = [path for name in ("figures", "shapes") for path in (folder / name).rglob("*")]
    files = [path for path in (*files, folder / "report.html") if path.is_file()]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.mark.parametrize("name", ["default", "everything", "lap_joint"])
def test_everything_shown_follows_from_the_results_alone(golden, name, tmp_path):
    ran = golden(name)
    results = tmp_path / "elsewhere"
    results.mkdir()
    shutil.copy(ran.folder / "results.h5", results)
    shutil.copytree(ran.folder / "results", results / "results")
    heard: list[Event] = []
    hidden = ran.folder.with_name(f"{name}_scene"), tmp_path / "hidden"  # what a scene names
    if hidden[0].exists():
        hidden[0].rename(hidden[1])
    try:
        show_again(results, heard.append)
    finally:
        if hidden[1].exists():
            hidden[1].rename(hidden[0])
    again = {each.key: each.record() for each in heard if isinstance(each, Table)}
    assert again
    for key, record in again.items():
        assert record == ran.table(key).record()
    expected = shown(ran.folder)
    assert {name: made == expected.get(name) for name, made in shown(results).items()} == (
        dict.fromkeys(expected, True)
    )


def test_a_run_without_a_finished_case_has_no_page(tmp_path):
    results = Results(tmp_path / "results.h5")
    with results.edit() as file:
        about = file.create_group("provenance")
        about.create_group("versions")
        about.attrs.update({"date": "2026-01-01", "settings": "{}", "study": "", "given": "{}"})
    results.flush()
    with pytest.raises(InputError, match="no case is finished yet"):
        show_again(tmp_path)
