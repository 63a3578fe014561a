"""A run that ends early leaves in its results what was solved, shown or not."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.vanelock.scenes.test_run import PAD, QUIET, arm
from vanelock import load_scene, run_scene
from vanelock.common.tables import Table
from vanelock.pipeline.progress import Event

pytestmark = pytest.mark.usefixtures("undrawn")

NAMES = ["mu=0.05", "mu=0.1", "mu=0.2"]


def stopped(event: Event) -> None:
    """Ctrl-C at the first table of the first case."""
    if isinstance(event, Table) and event.title.startswith("Preload"):
        raise KeyboardInterrupt


def test_cases_that_are_solved_are_in_results_after_an_interrupt(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(f'{arm(tmp_path)}{PAD}{QUIET}[sweep]\n"contacts.pad.mu" = [0.05, 0.1, 0.2]')
    folder, results = tmp_path / "run", tmp_path / "run" / "results.h5"
    run_scene(load_scene(path), folder)
    with h5py.File(results) as file:
        whole = {name: file[f"response/{name}/amplitude"][()] for name in NAMES}
        peaks = {name: file[f"response/{name}"].attrs["peak_amplitude"] for name in NAMES}
    results.unlink()
    entries = (folder / "cache").glob("*/response-*.h5")
    max(entries, key=lambda each: each.stat().st_mtime_ns).unlink()  # the last is not solved yet
    with pytest.raises(KeyboardInterrupt):
        run_scene(load_scene(path), folder, stopped)
    with h5py.File(results) as file:
        found = [name for name in NAMES if name in file["response"]]
        assert len(found) == 2
        assert not file.attrs["complete"]
        for name in found:
            np.testing.assert_array_equal(file[f"response/{name}/amplitude"], whole[name])
            assert file[f"response/{name}"].attrs["peak_amplitude"] == peaks[name]
    run_scene(load_scene(path), folder)
    with h5py.File(results) as file:
        assert file.attrs["complete"]
        assert all(name in file["response"] for name in NAMES)
