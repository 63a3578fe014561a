"""Tasks done by the workers of a Dask cluster.

Nothing is shared with them but the program itself, of the same version. What many tasks start from
is sent to one worker, from which the others fetch it; what a worker made comes back as bytes.
"""

import queue
import threading
import uuid
from collections.abc import Callable, Collection, Sequence
from ipaddress import ip_address
from typing import Any
from urllib.parse import urlsplit

from vanelock.common.errors import InputError
from vanelock.pipeline.executor.task_queue import TaskOutcome
from vanelock.pipeline.executor.tasks import Failure, Made, Task, Work, Worker, identity, reason
from vanelock.pipeline.progress import Listener, Notice

AHEAD = 2
"""Tasks that are out for each thread of the cluster, so that none waits for the next."""
PATIENCE = 10.0
"""Seconds to find the scheduler."""


class Cluster:
    """An existing cluster.

    Parameters
    ----------
    address : str
        Of its scheduler; for "tls://..." Dask's own configuration names the certificates.
    listener : callable
        Told of workers that are waited for.
    insecure : bool
        Whether the scheduler may be on another machine without encryption.

    Raises
    ------
    InputError
        If the connection would be neither encrypted nor to this machine, Dask is not installed, the
        scheduler does not answer, or a worker has another version of the program.
    """

    def __init__(self, address: str, listener: Listener, insecure: bool = False) -> None:
        if not insecure and not protected(address):
            raise InputError(
                f"--scheduler {address}: on another machine and without encryption, where anybody "
                "on the way can run programs here: use tls:// (docs/sweeps.md), or allow it with "
                "--insecure-scheduler"
            )
        try:
            import distributed
        except ImportError:
            raise InputError(
                f"--scheduler {address}: needs Dask: pip install 'dask[distributed]'"
            ) from None
        self._address, self._listener = address, listener
        try:
            client: Any = distributed.Client
            security: Any = distributed.Security
            self._client = client(
                address,
                timeout=PATIENCE,
                set_as_default=False,
                security=security(),  # as Dask's configuration says
            )
        except Exception as error:
            raise InputError(f"--scheduler {address}: no answer: {reason(error)}") from None
        try:
            self._check()
        except BaseException:
            self.close()
            raise
        self._ended: queue.SimpleQueue[tuple[Task, Any]] = queue.SimpleQueue()
        self._entries: dict[str, Any] = {}
        self._out: set[Any] = set()

    @property
    def slots(self) -> int:
        """How many tasks may be out at a time, by the workers there are now."""
        return int(max(AHEAD * sum(self._client.nthreads().values()), 1))

    def _check(self) -> None:
        """Refuse workers whose program is another; wait for the first of them."""
        if not self._client.nthreads():
            self._listener(Notice(f"{self._address}: waiting for a worker"))
            self._client.wait_for_workers(1)
        own, found = identity(), self._client.run(_identity, on_error="return")
        for worker, other in found.items():
            if isinstance(other, BaseException):
                raise InputError(f"worker {worker}: cannot import vanelock: {reason(other)}")
            if other != own:
                raise InputError(f"worker {worker}: has vanelock {other}, here it is {own}")
        if max(self._client.nthreads().values()) > 1:
            told = "does one task at a time in each worker: start workers with --nthreads 1"
            self._listener(Notice(f"{self._address}: {told}"))

    def send(self, task: Task, image: Callable[[str, str], bytes | None]) -> None:
        """Have a task done."""
        keys = []
        for stage, key in task.given:
            known = self._entries.get(key)
            if known is None or known.status in ("cancelled", "lost", "error"):
                if (found := image(stage, key)) is None:
                    continue
                self._entries[key] = self._client.scatter(found, hash=False)
            keys.append(key)
        future = self._client.submit(
            _perform,
            task.work,
            task.makes,
            identity(),
            keys,
            *(self._entries[key] for key in keys),
            key=f"vanelock-{uuid.uuid4().hex}",
            pure=False,
        )
        self._out.add(future)
        future.add_done_callback(lambda ended: self._ended.put((task, ended)))

    def wait(self, seconds: float) -> list[TaskOutcome]:
        """Tasks that ended."""
        try:
            found = [self._ended.get(timeout=seconds)]
            while not self._ended.empty():
                found.append(self._ended.get())
        except queue.Empty:
            if self._client.status != "running":
                raise InputError(f"{self._address}: the scheduler is gone") from None
            return []
        return [self._outcome(task, future) for task, future in found]

    def _outcome(self, task: Task, future: Any) -> TaskOutcome:
        from distributed import KilledWorker

        self._out.discard(future)
        try:
            answer: Made | Failure = future.result(timeout=60)
        except KilledWorker:
            told = "each of the workers that tried it was killed"
            return TaskOutcome(task, None, Failure(task.name, told), again=False)
        except Exception as error:  # what it starts from went with a worker, above all
            if self._client.status != "running":
                raise InputError(f"{self._address}: the scheduler is gone") from None
            for _, key in task.given:
                self._entries.pop(key, None)
            return TaskOutcome(task, None, Failure(task.name, reason(error)), counts=False)
        if isinstance(answer, Failure):
            if answer.reason.startswith(_OTHER):
                raise InputError(answer.reason)
            failure = Failure(task.name, answer.reason, refused=answer.refused)
            return TaskOutcome(task, None, failure, again=not answer.refused)
        return TaskOutcome(task, answer)

    def forget(self, keys: Collection[str]) -> None:
        """Let workers drop products."""
        for key in keys:
            self._entries.pop(key, None)

    def close(self) -> None:
        """Call back all tasks and leave; one that runs ends on its worker, unheard."""
        try:
            if self._client.status == "running":
                self._client.cancel(list(getattr(self, "_out", ())), force=True)
        finally:
            self._client.close(timeout=2)


def protected(address: str) -> bool:
    """Whether what goes to an address is encrypted, or stays on this machine."""
    scheme, found, rest = address.partition("://")
    if found and scheme in ("tls", "wss", "inproc"):
        return True
    try:
        host = urlsplit(f"//{rest if found else address}").hostname or ""
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False


_OTHER = "a worker has vanelock "
_workshop = Worker()
_known: set[str] = set()
_alone = threading.Lock()


def _identity() -> str:
    return identity()


def _perform(
    work: Work, makes: Sequence[str], expected: str, keys: Sequence[str], *entries: bytes
) -> Made | Failure:
    """On a worker: do a task."""
    if identity() != expected:
        return Failure("", f"{_OTHER}{identity()}, here it is {expected}", refused=True)
    with _alone:  # the mesher and the products in memory are for one at a time
        try:
            fresh: dict[str, Any] = dict(zip(keys, entries, strict=True))
            for key in _known.intersection(fresh):
                del fresh[key]
            gone = _known.difference(keys)
            _workshop.learn(fresh, gone)
            _known.difference_update(gone)
            _known.update(keys)
            return _workshop.perform(work, makes)
        except Exception as error:
            return Failure("", reason(error), refused=isinstance(error, InputError))
