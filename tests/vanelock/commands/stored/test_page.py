"""All that a run shows, its pictures drawn, is made again from its results alone, the same."""

import shutil
from pathlib import Path

import pytest

from vanelock.commands.stored.run import show_again
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Event


def shown(folder: Path) -> dict[str, bytes]:
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
