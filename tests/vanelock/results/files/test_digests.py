"""A results file that was altered, damaged or mixed up is refused by all that read it."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.vanelock.run_results import case_of
from vanelock import check_file, load_component, load_system, open_results
from vanelock.commands.stored.contents import load_run
from vanelock.common.errors import InputError
from vanelock.nonlinear import Options, Response, frequency_response, static_response
from vanelock.pipeline.cache import Cache
from vanelock.results.files.results_file import as_json
from vanelock.results.files.writer import Results
from vanelock.results.record import STORED, _put_answers
from vanelock.rom import System

CASES = {"mu=0.1": 0.1, "mu=0.3": 0.3}
SYSTEMS = [f"response/{name}/system" for name in CASES]


@pytest.fixture(scope="module")
def known():
    return {}


@pytest.fixture
def written(tmp_path, tmp_path_factory, ring, known):
    """Results of two cases, written as a run writes them, whole or stopped."""

    def write(complete=True):
        if complete not in known:
            known[complete] = run_of(ring, tmp_path_factory.mktemp("run"), complete)
        return shutil.copytree(known[complete], tmp_path / "run") / "results.h5"

    return write


def run_of(ring, folder, complete):
    results = Results(folder / "results.h5")
    cache = Cache(folder / "cache", print)
    with results.edit() as file:
        about = file.create_group("provenance")
        about.create_group("versions").attrs["numpy"] = "2"
        about.attrs.update({"date": "2026-01-01", "settings": "{}", "study": "", "given": "{}"})
    with results.edit("system") as file:
        results.put_system(file, "system", ring)
    for name, mu in CASES.items():
        changed = replace(ring, contacts=replace(ring.contacts, mu=np.full(2, mu)))
        response = frequency_response(changed, [150.0, 300.0], Options(1), find_jumps=False)
        kept = cache.store("response", f"key {mu}", response, 1.0).product
        where = f"response/{name}"
        values = {"monitor": "vane output 1, y", "sweep mu": mu, "peak_amplitude": 1.0}
        with results.edit(where) as file:
            results.put(file, where, kept)
            file[where].attrs.update(values)
            results.put(file, f"{where}/preload", static_response(changed))
            results.put_system(file, f"{where}/system", changed)
    for name in CASES:
        with results.edit(f"response/{name}") as file:
            numbers = {"goodman_reserve": (2.0, "")}
            _put_answers(file[f"response/{name}"], numbers)
            none: Any = {"given": {}, "places": {}, "number": 0, "linear_name": ""}
            case = case_of(name, {"mu": CASES[name]}, numbers=numbers)
            stored = {each: getattr(case, each) for each in STORED}
            file[f"response/{name}/about"] = as_json({**none, **stored})
    if complete:
        with results.edit() as file:
            file.attrs["complete"] = True
    results.end()
    shutil.rmtree(folder / "cache")  # what it has is in the results
    return folder


def checked(path):
    check_file(path)


def compared(path):
    load_run(path.parent)


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


def refused(door, path, *words, file=""):
    message = ""
    try:
        door(path)
    except InputError as error:  # kept no longer, with all that it holds open
        message = str(error)
    assert message.startswith(f"{path.parent if file else path}{file}"), message
    assert len(message.splitlines()) == 1
    assert any(word in message for word in words), message


def datasets(path):
    found = []

    def take(group, place):
        for name, item in group.items():
            if isinstance(item, h5py.Group):
                take(item, f"{place}{name}/")
            else:
                found.append(place + name)

    with h5py.File(path) as file:
        take(file, "")
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
def test_what_was_written_is_read(written, tmp_path, complete, door):
    path = written(complete)
    door(path)
    moved = tmp_path / "elsewhere"
    shutil.move(path.parent, moved)
    door(moved / path.name)


def test_every_data_set_and_every_bit_counts(written):
    path = written()
    names = datasets(path)
    assert {"response/mu=0.3/amplitude", "response/mu=0.1/preload/x/0"} < {*names}
    own = [name for name in names if "mu=0.1" not in name]  # the cases are alike
    assert len(own) > 30
    for name in own:
        with h5py.File(path) as file:
            holder = Path(file[name].file.filename)
        before = holder.read_bytes()
        alter(path, name)
        refused(in_python, path, "is not what was written", file="/results/")
        holder.write_bytes(before)
    files = [*(path.parent / "results").iterdir()]
    assert len(files) == 6  # two cases, their responses, the system, its matrices
    for each in files:
        flipped(each, lambda: refused(in_python, path, *DAMAGED, file="/"))
    in_python(path)


DAMAGED = "is not what was written", "not a readable HDF5 file", "not a"


def flipped(file, then):
    """Do something while one bit of a file is another."""
    whole = file.read_bytes()
    rng = np.random.default_rng(len(whole))
    place, damaged = int(rng.integers(len(whole))), bytearray(whole)
    damaged[place] ^= 1 << int(rng.integers(8))
    file.write_bytes(damaged)
    then()
    file.write_bytes(whole)


@pytest.mark.parametrize("door", [checked, compared, by_name])
def test_cases_and_files_have_their_own_names(written, door):
    path = written(door is checked)
    with h5py.File(path, "r+") as file:
        file.move("response/mu=0.1", "response/between")
        file.move("response/mu=0.3", "response/mu=0.1")
        file.move("response/between", "response/mu=0.3")
    refused(door, path, "is not what was written")
    shutil.rmtree(path.parent)
    path = written()
    one, other = sorted((path.parent / "results").glob("mu0*.h5"))
    between = one.rename(path.parent / "between.h5")
    other.rename(one)
    between.rename(other)
    refused(door, path, "is not what was written", file="/results/mu0.1-")


def lost(place):
    def change(case):
        del case[place]

    return change


def other(name):
    def change(case):
        value = case.attrs[name]
        case.attrs[name] = value + "x" if isinstance(value, str) else value + value.dtype.type(1)

    return change


CHANGES = (
    *map(lost, ("residual", "x", "preload", "system/contact/v0", "answers")),
    *map(other, ("peak_amplitude", "monitor", "sweep mu", "coupling")),
)


def test_no_array_and_no_attribute_may_be_missing_or_other(written):
    path = written(False)
    (holder,) = (path.parent / "results").glob("mu0.3-*.h5")
    whole = holder.read_bytes()
    for change in CHANGES:
        with h5py.File(path, "r+") as file:
            change(file["response/mu=0.3"])
        refused(in_python, path, "is not what was written", file="/results/mu0.3-")
        holder.write_bytes(whole)
    in_python(path)


@pytest.mark.parametrize("door", [checked, compared, by_name])
def test_all_who_open_results_notice_and_miss_a_file(written, door):
    path = written()
    (holder,) = (path.parent / "results").glob("mu0.3-*.h5")
    whole = holder.read_bytes()
    flipped(holder, lambda: refused(door, path, *DAMAGED, file="/"))
    with h5py.File(path, "r+") as file:
        lost("preload")(file["response/mu=0.3"])
    refused(door, path, "is not what was written", file="/results/mu0.3-")
    holder.write_bytes(whole)
    for each in [*(path.parent / "results").iterdir()]:
        each.rename(path.parent / "away")
        refused(door, path, "is missing")
        (path.parent / "away").rename(each)
    door(path)


@pytest.mark.parametrize("complete", [True, False])
def test_a_whole_case_is_missed(written, complete):
    path = written(complete)
    with h5py.File(path, "r+") as file:
        del file["response/mu=0.3"]
    refused(checked, path, "is not what was written")


def test_what_cases_share_is_written_once(written):
    path = written()
    with open_results(path) as file:
        found = [file[f"{where}/nd"].file.filename for where in ("system", *SYSTEMS)]
    assert len({*found}) == 1
    (each,) = (path.parent / "results").glob("matrices-*.h5")
    assert each.samefile(found[0])


@pytest.mark.parametrize("links", [True, False])
def test_what_the_cache_has_takes_no_room_where_files_can_be_linked(
    tmp_path, ring, monkeypatch, links
):
    def refuses(*_):
        raise PermissionError(1, "Operation not permitted")

    if not links:
        monkeypatch.setattr("os.link", refuses)
    cache, results = Cache(tmp_path / "cache", print), Results(tmp_path / "results.h5")
    found = frequency_response(ring, [150.0, 300.0], Options(1), find_jumps=False)
    kept = cache.store("response", "key", found, 1.0).product
    for name in ("one", "other"):
        with results.edit(f"response/{name}") as file:
            results.put(file, f"response/{name}", kept)
    results.flush()
    (entry,) = cache.folder.rglob("*.h5")
    (held,) = (tmp_path / "results").glob("response-*.h5")
    assert entry.samefile(held) == links
    entry.unlink()
    with open_results(results.path) as file:
        for name in ("one", "other"):
            again = Response.load(file[f"response/{name}"])
            np.testing.assert_array_equal(again.contact, found.contact)


def test_a_reduced_part_whose_whole_is_gone_is_refused_in_one_line(tmp_path):
    path, name = tmp_path / "results.h5", "rom-vane-0123456789abcdef0123.h5"
    with Results(path).edit() as file:
        file.create_group("rom/vane").attrs["whole"] = f"cache/01/{name}"
        file.create_group("rom/casing").attrs["whole"] = "../cache/x.h5"
    with open_results(path, complete=False):
        pass
    for part, expected in {
        "vane": f"{name}: cannot be read: No such file or directory",
        "casing": "outside the study file's folder",
        "ring": r"no part 'ring' \(it has casing, vane\)",
    }.items():
        with pytest.raises(InputError, match=expected):
            load_component(path, part)
