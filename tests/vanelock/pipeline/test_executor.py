"""A sweep by one process, by two and by a Dask cluster: the same results to the last bit."""

import json
import os
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest
from distributed import Client

import vanelock
from tests.vanelock.results.one_file import contents
from vanelock import parse_study, run_study
from vanelock.common.errors import InputError
from vanelock.pipeline import executor
from vanelock.pipeline.executor import _Cluster
from vanelock.pipeline.progress import Failed, Finished, Notice, Tasks

STUDY = """
mesh.size = "coarse"
response = { frequencies = [262, 266, 270], harmonics = 1 }
outputs = { show = [] }
[sweep]
"joints.interlock.mu" = [0.1, 0.15, 0.2, 0.3]
"""
BEFORE = "DASK_DISTRIBUTED__COMM__TLS__"


def run(folder, text=STUDY, **options):
    heard = []

    def listener(event):
        heard.append(event)
        if options.get("hook"):
            options["hook"](event)

    passed = {name: value for name, value in options.items() if name != "hook"}
    found = run_study(parse_study(text), folder, listener, text, **passed)
    return found, heard


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A run by this process alone."""
    folder = tmp_path_factory.mktemp("alone")
    return folder, *run(folder)


@pytest.fixture
def begun(alone, tmp_path):
    """A folder with the meshes and reduced parts of that run, but no response."""
    shutil.copytree(alone[0] / "cache", tmp_path / "run" / "cache")
    for path in (tmp_path / "run" / "cache").rglob("*.h5"):
        if path.name.startswith(("preload", "response")):
            path.unlink()
    return tmp_path / "run"


@contextmanager
def dask_of(folder, count, protocol="tcp", **more):
    """Address of a scheduler on the loopback interface, its workers, and what starts one more."""
    where = folder / "scheduler.json"
    path = os.pathsep.join([str(Path(vanelock.__path__[0]).parent), *sys.path])
    environment = {**os.environ, **more, "PYTHONPATH": path}
    own = folder / "dask"
    own.mkdir()

    def start(module, *options):
        command = [sys.executable, "-m", f"distributed.cli.{module}", *options]
        return subprocess.Popen(command, env=environment, cwd=own, stderr=-3, stdout=-3)

    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--protocol", protocol)
    scheduler = start("dask_scheduler", *options, "--no-jupyter", "--scheduler-file", str(where))
    processes = [scheduler]
    try:
        of = ["--scheduler-file", str(where), "--nthreads", "1", "--host", "127.0.0.1"]
        of += ["--protocol", protocol, "--no-dashboard"]

        def worker(*options):
            processes.append(start("dask_worker", *of, *options))
            return processes[-1]

        workers = [worker() for _ in range(count)]
        while not where.exists() or not where.read_text().strip():
            assert scheduler.poll() is None
            time.sleep(0.1)
        yield json.loads(where.read_text())["address"], workers, worker
    finally:
        for each in processes:
            for child in psutil.Process(each.pid).children(recursive=True):
                child.kill()
            each.kill()
            each.wait()


@pytest.fixture
def cluster(tmp_path):
    """A cluster of two workers."""
    with dask_of(tmp_path, 2) as found:
        yield found


@pytest.mark.system
def test_a_cluster_that_loses_a_worker_finds_the_same_bits(alone, begun, cluster):
    """Points that were written down go, too: taken up again they agree to 1e-9, not to the bit."""
    (address, workers, _), killed = cluster, list[object]()

    def lose(event):
        if isinstance(event, Tasks) and event.done == 1 and not killed:
            killed.append(workers[0])
            for child in psutil.Process(workers[0].pid).children(recursive=True):
                child.kill()
            workers[0].kill()
            for path in (begun / "cache").glob("*.points"):
                path.unlink()

    found, heard = run(begun, scheduler=address, hook=lose)
    assert killed
    assert len(found) == 4
    assert contents(begun / "results.h5") == contents(alone[0] / "results.h5")
    assert not [event for event in heard if isinstance(event, Failed)]
    (finished,) = [event for event in heard if isinstance(event, Finished)]
    assert finished.summary["failed"] == {}


ELSEWHERE = """
import vanelock.pipeline.executor as executor
if not hasattr(executor, "there"):  # Dask loads it more than once
    executor.there = executor._unfit
executor._unfit = lambda path, *more: executor.there(path + ".elsewhere", *more)
"""
"""What a worker loads first that is to see another folder."""


@pytest.mark.system
@pytest.mark.parametrize("late", [False, True])
def test_a_worker_that_does_not_see_the_folder_is_named_and_not_used(alone, begun, tmp_path, late):
    preload = tmp_path / "elsewhere.py"
    preload.write_text(ELSEWHERE)
    with dask_of(tmp_path, 1) as (address, workers, start):
        if not late:
            workers.append(start("--preload", str(preload)))
            cluster = Client(address)
            cluster.wait_for_workers(2)
            cluster.close()

        def add(event):
            if isinstance(event, Tasks) and late and len(workers) == 1:
                workers.append(start("--preload", str(preload)))

        found, heard = run(begun, scheduler=address, hook=add)
    assert len(found) == 4
    assert contents(begun / "results.h5") == contents(alone[0] / "results.h5")
    said = [event.text for event in heard if isinstance(event, Notice) and "not used" in event.text]
    where = f"does not see {begun / 'cache'}, which all have to share: is not used"
    assert [text.partition(": ")[2] for text in said] in ([where], [] * late)
    assert not list((begun / "cache").glob(".token"))


@pytest.mark.parametrize(("address", "insecure"), [("127.0.0.1", False), ("192.0.2.1", True)])
def test_where_no_scheduler_answers_an_error_says_so(monkeypatch, tmp_path, address, insecure):
    """An unencrypted one elsewhere is asked if the option is given."""
    monkeypatch.setattr(executor, "PATIENCE", 0.3)
    with pytest.raises(InputError, match="no answer"):
        _Cluster(f"tcp://{address}:9", print, tmp_path, insecure)


@pytest.mark.parametrize("address", ["", "tcp://", "tcp://[bad", "file.json", "localhost"])
def test_what_is_no_address_of_a_scheduler_is_refused(tmp_path, address):
    with pytest.raises(InputError, match="no address of a scheduler, such as tcp://host:8786"):
        _Cluster(address, print, tmp_path)


@pytest.fixture
def certificates(tmp_path):
    """What Dask's configuration, here in the environment, says of certificates made for a test."""
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2"]
    made += ["-subj", "/CN=vanelock", "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(made, check=True, capture_output=True)
    found = {f"{BEFORE}CA_FILE": str(certificate)}
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        found |= {f"{BEFORE}{role}__CERT": str(certificate), f"{BEFORE}{role}__KEY": str(key)}
    return found


@pytest.mark.system
def test_an_encrypted_cluster_is_set_up_by_dasks_configuration(tmp_path, certificates):
    import dask.config
    import distributed  # noqa: F401  # brings its part of the configuration

    of = "distributed.comm.tls"
    names = {"CA_FILE": "ca-file", "CLIENT__CERT": "client.cert", "CLIENT__KEY": "client.key"}
    own = {f"{of}.{k}": certificates[f"{BEFORE}{name}"] for name, k in names.items()}
    with dask_of(tmp_path, 1, "tls", **certificates) as (address, *_):
        assert address.startswith("tls://127.0.0.1:")
        with pytest.raises(InputError, match="no answer") as caught:
            _Cluster(address, print, tmp_path)
        assert len(str(caught.value).splitlines()) == 1
        with dask.config.set(own):
            found = _Cluster(address, print, tmp_path)
            assert found.slots == 2
            assert found._client.scheduler.address == address
            found.shutdown()
        with pytest.raises(InputError, match="no answer"):
            _Cluster(address.replace("tls", "tcp"), print, tmp_path)


@pytest.mark.parametrize(
    ("address", "safe"),
    [
        ("tls://node7:8786", True),
        ("tcp://127.0.0.1:8786", True),
        ("localhost:8786", True),
        ("tcp://[::1]:8786", True),
        ("tcp://10.0.0.7:8786", False),
        ("node7:8786", False),
        ("tcp://127.0.0.1.example:8786", False),
    ],
)
def test_what_is_neither_encrypted_nor_on_this_machine_takes_an_option(tmp_path, address, safe):
    scheme, host, _ = executor._ADDRESS.fullmatch(address).groups()  # type: ignore[union-attr]
    assert executor._protected(scheme, host.strip("[]")) == safe
    if not safe:
        with pytest.raises(InputError, match="without encryption.*--insecure-scheduler"):
            _Cluster(address, print, tmp_path)
