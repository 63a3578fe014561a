"""A results file that was altered, damaged or mixed up is refused by all that read it."""

import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest

from vanelock import load_system, open_results
from vanelock.commands.check.study import check_file
from vanelock.commands.compare.load import load_run
from vanelock.common.errors import InputError
from vanelock.nonlinear import Response, frequency_response, static_response
from vanelock.results.files.results_file import Results, put, put_answers, put_system
from vanelock.rom import System

CASES = {"mu=0.1": 0.1, "mu=0.3": 0.3}


@pytest.fixture
def written(tmp_path, ring):
    """Results of two cases, written as a run writes them, whole or stopped."""

    def write(complete=True):
        results = Results(tmp_path / "results.h5")
        with results.edit("provenance") as file:
            about = file.create_group("provenance")
            about.create_group("versions").attrs["numpy"] = "2"
            about.attrs.update({"date": "2026-01-01", "settings": "{}"})
        with results.edit("system") as file:
            put_system(file, "system", ring)
        for name, mu in CASES.items():
            changed = replace(ring, contacts=replace(ring.contacts, mu=np.full(2, mu)))
            response = frequency_response(changed, [150.0, 300.0], harmonics=1)
            where = f"response/{name}"
            values = {"monitor": "vane accessory 1, y", "sweep mu": mu, "peak_amplitude": 1.0}
            with results.edit(where) as file:
                put(file, where, response, values)
                put(file, f"{where}/preload", static_response(changed), {})
                put_system(file, f"{where}/system", changed, "system")
        with results.edit(*(f"response/{name}" for name in CASES)) as file:
            for name in CASES:
                put_answers(file, f"response/{name}", {"goodman_reserve": (2.0, "")})
        if complete:
            with results.edit("provenance", "/") as file:
                file.attrs["complete"] = True
        results.end()
        return results.path

    return write


def checked(path):
    check_file(path)


def compared(path):
    load_run(path.parent, "it")


def by_name(path):
    for name in CASES:
        load_system(path, name)


def in_python(path):
    """As somebody reads products who opens the file by himself."""
    with h5py.File(path) as file:
        System.load(file["system"])
        for name in CASES:
            Response.load(file[f"response/{name}"])
            System.load(file[f"response/{name}/system"])


DOORS = (checked, compared, by_name, in_python)


def refused(door, path, *words):
    with pytest.raises(InputError) as caught:
        door(path)
    told = str(caught.value)
    assert told.startswith(f"{path}: /"), told
    assert len(told.splitlines()) == 1
    assert any(word in told for word in words), told


def datasets(path):
    found = []
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.append(name) if hasattr(item, "dtype") else None)
    return found


def alter(path, name):
    """Five per cent more; what that does not change, something else."""
    with h5py.File(path, "r+") as file:
        item = file[name]
        before = item[()]
        if item.dtype.kind == "O":
            item[...] = "other"
        else:
            item[...] = (~before if item.dtype.kind == "b" else before * 1.05).astype(item.dtype)
            if np.array_equal(item[()], before, equal_nan=True):
                item[...] = before + 1


@pytest.mark.parametrize("complete", [True, False])
@pytest.mark.parametrize("door", DOORS)
def test_what_was_written_is_read(written, complete, door):
    door(written(complete))


@pytest.mark.parametrize("door", DOORS)
def test_every_data_set_counts(written, tmp_path, door):
    path = written()
    kept = shutil.copy(path, tmp_path / "kept.h5")
    names = datasets(path)
    assert len(names) > 60
    assert {"response/mu=0.3/amplitude", "response/mu=0.1/preload/x/0"} < {*names}
    for name in names if door is in_python else names[::12]:
        shutil.copy(kept, path)
        alter(path, name)
        refused(door, path, "is not what was written")


@pytest.mark.parametrize("door", DOORS)
def test_every_bit_of_the_numbers_counts(written, tmp_path, door):
    path = written(False)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    with h5py.File(path) as file:
        places = [
            (file[name].id.get_offset(), file[name].nbytes)
            for name in datasets(path)
            if file[name].id.get_offset() is not None and file[name].dtype.kind in "fc"
        ]
    for i in rng.permutation(len(places))[:5]:
        at = places[i][0] + int(rng.integers(places[i][1]))
        damaged = bytearray(whole)
        damaged[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        refused(door, path, "is not what was written")


@pytest.mark.parametrize("complete", [True, False])
@pytest.mark.parametrize("door", DOORS)
def test_a_case_has_its_own_name(written, complete, door):
    path = written(complete)
    with h5py.File(path, "r+") as file:
        file.move("response/mu=0.1", "response/between")
        file.move("response/mu=0.3", "response/mu=0.1")
        file.move("response/between", "response/mu=0.3")
    refused(door, path, "was written as /response/mu=0.")


@pytest.mark.parametrize("complete", [True, False])
@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("lost", ["residual", "x/1", "preload", "system/contact/v0", "answers"])
def test_nothing_may_be_missing(written, complete, door, lost):
    path = written(complete)
    with h5py.File(path, "r+") as file:
        del file[f"response/mu=0.3/{lost}"]
    refused(door, path, "is not what was written")


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("name", ["peak_amplitude", "monitor", "sweep mu", "coupling", "digest"])
def test_attributes_count(written, door, name):
    path = written(False)
    with h5py.File(path, "r+") as file:
        attributes = file["response/mu=0.3"].attrs
        value = attributes[name]
        attributes[name] = value + "x" if isinstance(value, str) else value + value.dtype.type(1)
    refused(door, path, "is not what was written")


def test_a_whole_case_is_missed_where_the_run_was_complete(written):
    path = written()
    with h5py.File(path, "r+") as file:
        del file["response/mu=0.3"]
    refused(checked, path, "/response: is not what was written")


def test_what_has_no_digest_cannot_be_checked(written):
    path = written(False)
    with h5py.File(path, "r+") as file:
        del file["response/mu=0.3"].attrs["digest"]
    refused(checked, path, "/response/mu=0.3: lacks the digest that it was written with")


def test_matrices_that_cases_share_are_written_once(written):
    with open_results(written()) as file:
        assert file["response/mu=0.1/system/nd"] == file["response/mu=0.3/system/nd"]
