"""The results file: what goes in comes out, whole at every moment; pictures of it in time."""

import os
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.vanelock.scenes.test_run import PAD, QUIET, arm
from vanelock import load_scene, load_system, open_results, run_scene
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, Response, frequency_response
from vanelock.pipeline.progress import Event, Notice, silent
from vanelock.results.files.results_file import check_results
from vanelock.results.files.run_folder import OutputFiles
from vanelock.results.files.writer import Results
from vanelock.rom import System


def same(a, b):
    assert a.contacts.joint == b.contacts.joint
    assert a.diameters.keys() == b.diameters.keys()
    for k in a.diameters:
        for name in ("K", "M", "own", "next", "output"):
            np.testing.assert_array_equal(
                getattr(a.diameters[k], name), getattr(b.diameters[k], name)
            )
    for name in ("kn", "kt", "mu", "v0"):
        np.testing.assert_array_equal(getattr(a.contacts, name), getattr(b.contacts, name))
    assert a.damping_ratio == b.damping_ratio
    np.testing.assert_array_equal(a.force[1].vector, b.force[1].vector)


def test_round_trip(tmp_path, ring):
    slippery = replace(ring, contacts=replace(ring.contacts, mu=np.array([0.1, 0.2])))
    response = frequency_response(ring, [150.0, 300.0], Options(1))
    results = Results(tmp_path / "results.h5")
    with results.edit("system") as file:
        results.put_system(file, "system", ring)
    with results.edit("response/mu=0.1") as file:
        results.put(file, "response/mu=0.1", response)
        results.put_system(file, "response/mu=0.1/system", slippery)
    results.flush()
    with open_results(results.path) as file:
        same(System.load(file["system"]), ring)
        # Cases that differ in their contacts share their matrices.
        shared = file["response/mu=0.1/system/nd"].file.filename
        assert file["system/nd"].file.filename == shared
        found = Response.load(file["response/mu=0.1"])
        assert file["response/mu=0.1/frequency"].attrs["unit"] == "Hz"
        where = file["response/mu=0.1"]
        codes = "0 stuck, 1 slips, 2 open, 3 slips and opens, 4 an element"
        assert where["state"].attrs["codes"] == codes
        assert {x.attrs["unit"] for x in where["x"].values()} == {"m; modal coordinates kg^0.5 m"}
        assert not file.attrs["complete"]
    same(load_system(results.path, "mu=0.1"), slippery)
    for name in ("frequency", "contact", "force", "state", "amplitude", "residual"):
        np.testing.assert_array_equal(getattr(found, name), getattr(response, name))
    np.testing.assert_array_equal(found.x[1], response.x[1])


def test_a_new_run_replaces_old_results_and_missing_files_and_cases_are_named(tmp_path, ring):
    path = tmp_path / "results.h5"
    for text in ("old", "new"):
        with Results(path).edit() as file:
            file[text] = 1
    with open_results(path) as file:
        assert set(file) == {"new"}
    path.unlink()
    check_results(path)
    with pytest.raises(InputError, match="no such file"), open_results(path):
        pass
    with Results(tmp_path / "results.h5").edit() as file:
        file.create_group("response/nominal")
    with pytest.raises(InputError, match=r"no case 'other' \(it has nominal\)"):
        load_system(tmp_path / "results.h5", "other")


@pytest.mark.parametrize("content", ["damaged", "cut", "foreign", "version", "folder"])
def test_files_that_are_not_ours(tmp_path, content):
    path = tmp_path / "results.h5"
    expected = "not a readable HDF5 file"
    if content == "folder":
        path.mkdir()
        expected = "is a folder, an HDF5 file is needed"
    elif content == "damaged":
        path.write_bytes(b"\x00" * 4000)
    else:
        with Results(path).edit() as file:
            file.create_group("system")
            if content == "version":
                file.attrs["version"] = 99
                expected = "results of format version 99, this program writes 4"
        if content == "cut":
            path.write_bytes(path.read_bytes()[:-500])
        elif content == "foreign":
            with h5py.File(path, "w") as file:
                file["mine"] = 1
            expected = "not a vanelock results file"
    with pytest.raises(InputError) as caught:
        check_results(path)
    assert str(caught.value).startswith(f"{path}: {expected}")
    assert "--output" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_damaged_part_is_reported_and_written_again(tmp_path):
    """The power cut that a run survives; in the cache its file is the same one."""
    (tmp_path / "scene.toml").write_text(arm(tmp_path) + PAD + QUIET)
    scene, folder = load_scene(tmp_path / "scene.toml"), tmp_path / "run"
    (before,) = run_scene(scene, folder)
    for damage in (lambda part: os.truncate(part, 1000), Path.unlink):
        (part,) = (folder / "results").glob("preload-*.h5")
        damage(part)
        said: list[Event] = []
        (after,) = run_scene(scene, folder, listener=said.append)
        assert after.peak == before.peak
        (notice,) = (e.text for e in said if isinstance(e, Notice) and "results are" in e.text)
        assert notice.startswith(f"results are damaged (results/{part.name}")
        with open_results(folder / "results.h5"):
            pass


def test_pictures_are_drawn_again_only_when_they_would_change(tmp_path):
    drawn = []

    def write(text):
        def function(path):
            drawn.append(text)
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)

        return function

    def draw(shows, text):
        output_files = OutputFiles(tmp_path, silent)
        path = output_files.draw("figures/a.png", shows, write(text))
        output_files.tidy()
        return path

    for shows, text in (([1], "one"), ([1], "one again"), ([2], "two")):
        path = draw(shows, text)
    assert drawn == ["one", "two"]
    path.write_text("spoilt")
    draw([2], "repaired")
    assert path.read_text() == "repaired"
    (tmp_path / "cache" / "pictures.json").write_text('{"figures/a.png": 3')
    draw([2], "list lost")
    assert path.read_text() == "list lost"


def test_what_is_drawn_last_is_known_to_the_next_run_and_bad_places_are_named(tmp_path):
    drawn = []
    for _ in range(2):
        output_files = OutputFiles(tmp_path, silent)
        output_files.tidy(keep=["report.html"])
        output_files.draw("report.html", [], lambda path: drawn.append(path.write_text("drawn")))
    assert len(drawn) == 1
    (tmp_path / "figures").write_text("a file")
    (tmp_path / "shapes" / "a.png").mkdir(parents=True)
    for name in ("figures/a.png", "shapes/a.png"):
        with pytest.raises(InputError) as caught:
            OutputFiles(tmp_path, silent).draw(name, [], lambda path: path.write_text("drawn"))
        assert str(caught.value).startswith(f"{tmp_path / name}: cannot be written: ")
