"""Who computes the cases of a sweep: this process, others of this machine, or a cluster.

Both are executors of `concurrent.futures`; what they are sent and what comes of it, see
`vanelock.pipeline.tasks`.
"""

import ctypes
import os
import platform
import re
import secrets
import signal
import socket
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from ipaddress import ip_address
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import vanelock
from vanelock.common.errors import InputError
from vanelock.common.files.files import placed
from vanelock.common.lazy import library
from vanelock.common.process import keep_freed
from vanelock.pipeline.cache import code_of
from vanelock.pipeline.progress import Listener, Notice
from vanelock.pipeline.tasks import Failure, Killed, Workers, failure_of

AHEAD = 2
"""Tasks that are out for each thread of the cluster, so that none waits for the next."""
PATIENCE = 10.0
"""Seconds to find the scheduler."""
TOKEN = ".token"
"""File in the cache of a run by which a worker knows that it sees the same folder."""
_ADDRESS = re.compile(r"(?:(tcp|tls|wss?|ucx)://)?(\[[\da-fA-F:]+\]|[\w.-]+):(\d{1,5})", re.ASCII)
_PR_SET_PDEATHSIG = 1


def chosen_workers(
    count: int, scheduler: str | None, listener: Listener, cache: Path, insecure: bool = False
) -> Workers | None:
    """Other processes, as far as they are wanted; None where this one does all."""
    if scheduler is not None:
        return _Cluster(scheduler, listener, cache, insecure)
    return None if count < 2 else Processes(count)


class Processes(ThreadPoolExecutor):
    """So many processes of this machine, started when there is something to do.

    Each is a pool of its own, which a thread waits for: a process that is killed takes with it no
    task but its own. It ends with this one, however that ends.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count, initializer=_hold_back)
        self.slots = count
        self._own = threading.local()
        self._started: list[_OneProcess] = []
        self._lock, self._ended = threading.Lock(), False

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:  # type: ignore[override]
        """Have a function called by one of the processes."""
        return super().submit(self._called, function, *arguments)

    def _called(self, function: Callable[..., Any], *arguments: Any) -> Any:
        process: _OneProcess | None = getattr(self._own, "process", None)
        try:
            with self._lock:  # none is started behind the back of `shutdown`
                if self._ended:
                    raise Killed("it was called back")
                if process is None:
                    self._own.process = process = _OneProcess()
                    self._started.append(process)
                future = process.pool.submit(function, *arguments)
            return future.result()
        except BrokenProcessPool:
            assert process is not None
            self._own.process = None
            raise Killed(process.end()) from None

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """Kill all processes."""
        super().shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._ended = True
            for each in self._started:
                each.kill()
        super().shutdown(wait)
        for each in self._started:
            each.pool.shutdown()


class _OneProcess(SpawnContext):
    """A pool of one process, and how it ended."""

    def __init__(self) -> None:
        self.pool = ProcessPoolExecutor(1, self, _begin, (os.getpid(),))
        self._process: SpawnProcess | None = None

    def Process(self, *args: Any, **options: Any) -> SpawnProcess:  # type: ignore[override]
        """What the pool starts."""
        self._process = SpawnProcess(*args, **options, daemon=True)
        return self._process

    def kill(self) -> None:
        """End it at once."""
        if self._process is not None:
            self._process.kill()

    def end(self) -> str:
        """Wait until it has ended; how it did, in words."""
        self.pool.shutdown()
        code = (self._process and self._process.exitcode) or 0
        if code < 0:
            return f"its process was killed by signal {-code} ({signal.Signals(-code).name})"
        return f"its process ended with status {code}"


def _hold_back() -> None:
    """Have what this thread starts get neither Ctrl-C nor the signal of a broken pipe.

    Processes and threads inherit which signals are held back. Ctrl-C reaches every process of a
    terminal, and is for the one that runs the study to answer. Writing to a process that has died
    is to fail rather than to end this one: Python ignores that signal, but libraries that were
    loaded since may not.
    """
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGPIPE})


def _begin(parent: int) -> None:
    """In a process that does tasks: end as soon as its parent does, even if that is killed."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
    keep_freed()


class _Cluster:
    """The workers of an existing Dask cluster that see the run's folder."""

    def __init__(
        self, address: str, listener: Listener, cache: Path, insecure: bool = False
    ) -> None:
        self._address, self._listener = address, listener
        self._client = _client(address, insecure)
        self._executor = self._client.get_executor(pure=False)
        self._token, self._asked = cache.absolute() / TOKEN, dict[str, str]()
        self._known = str(self._token), secrets.token_hex(8), _identity()
        try:
            with placed(self._token) as temporary:
                temporary.write_text(self._known[1])
            if not self._client.nthreads():
                listener(Notice(f"{address}: waiting for a worker"))
                self._client.wait_for_workers(1)
            if max(self._fit().values(), default=1) > 1:
                text = "does one task at a time in each worker: start workers with --nthreads 1"
                listener(Notice(f"{address}: {text}"))
        except BaseException:
            self.shutdown()
            raise

    @property
    def slots(self) -> int:
        """How many tasks may be out at a time, by the workers there are now."""
        if self._client.status != "running":
            raise InputError(f"{self._address}: the scheduler is gone")
        return max(AHEAD * sum(self._fit().values()), 1)

    def _fit(self) -> dict[str, int]:
        """Threads of the workers that can work for this run; the others are named once."""
        threads: dict[str, int] = self._client.nthreads()
        if new := [each for each in threads if each not in self._asked]:
            found = self._client.run(_unfit, *self._known, workers=new, on_error="return")
            for worker, why in found.items():
                self._asked[worker] = why if isinstance(why, str) else failure_of(why).reason
                if self._asked[worker]:
                    self._listener(Notice(f"worker {worker}: {self._asked[worker]}: is not used"))
        fit = {each: count for each, count in threads.items() if not self._asked.get(each, "gone")}
        if threads and not fit:
            why = next(filter(None, map(self._asked.get, threads)), "is gone")
            raise InputError(f"--scheduler {self._address}: worker {next(iter(threads))}: {why}")
        return fit

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Have a function called by a worker."""
        only = {"workers": list(self._fit())} if any(self._asked.values()) else {}
        future: Future[Any] = self._executor.submit(
            _called_if_fit, self._known, function, *arguments, **only
        )
        return future

    def shutdown(self) -> None:
        """Call back all tasks and leave; one that runs ends on its worker, unheard."""
        self._token.unlink(missing_ok=True)
        try:
            if self._client.status == "running":
                self._executor.shutdown(wait=False)
        finally:
            self._client.close(timeout=2)


def _client(address: str, insecure: bool) -> Any:
    """A client of a scheduler; refused where nobody answers, or anybody may listen."""
    parts = _ADDRESS.fullmatch(address)
    if parts is None:
        raise InputError(
            f"--scheduler {address}: no address of a scheduler, such as tcp://host:8786"
        )
    scheme, host, port = parts[1], parts[2].strip("[]"), int(parts[3])
    if not insecure and not _protected(scheme, host):
        raise InputError(
            f"--scheduler {address}: on another machine and without encryption, where anybody "
            "on the way can run programs here: use tls:// (`vanelock manual sweeps`), or "
            "allow it with --insecure-scheduler"
        )
    distributed = library("distributed", "cluster", f"--scheduler {address}", "Dask")
    try:
        with socket.create_connection((host, port), PATIENCE):
            pass  # where nobody listens, Dask tries on and complains when the program ends
        return distributed.Client(
            address,
            timeout=PATIENCE,
            set_as_default=False,
            security=distributed.Security(),  # as Dask's configuration says
        )
    except Exception as error:
        why = getattr(error, "strerror", None) or failure_of(error).reason
        raise InputError(f"--scheduler {address}: no answer: {why}") from None


def _protected(scheme: str | None, host: str) -> bool:
    """Whether what goes to a host is encrypted, or stays on this machine."""
    if scheme in ("tls", "wss") or host.lower() == "localhost":
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def _unfit(path: str, token: str, expected: str) -> str:
    """Why a worker cannot work for a run whose folder holds a token; "" if it can."""
    if _identity() != expected:
        return f"has vanelock {_identity()}, here it is {expected}"
    try:
        seen = Path(path).read_text()
    except OSError:
        seen = ""
    return "" if seen == token else f"does not see {Path(path).parent}, which all have to share"


def _called_if_fit(versions: tuple[str, str, str], function: Callable[..., Any], *of: Any) -> Any:
    """On a worker: call a function, unless it came too late to be asked and is not fit."""
    if why := _unfit(*versions):
        return Failure(f"a worker {why}", unfit=True)
    return function(*of)


def _identity() -> str:
    """Release of the program with a digest of its source files, and version of Python."""
    rooms = sorted(each.name for each in iter_modules(vanelock.__path__) if each.ispkg)
    python = ".".join(platform.python_version_tuple()[:2])
    return f"{code_of(*rooms)}, Python {python}"
