"""Tasks done by the workers of a Dask cluster.

Nothing is shared with them but the program itself, of the same version. What many tasks start from
is sent to one worker, from which the others fetch it; what a worker made comes back as bytes.
"""

import re
import socket
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Future
from ipaddress import ip_address
from typing import Any
from urllib.parse import urlsplit
from weakref import WeakSet

from vanelock.common.errors import InputError
from vanelock.common.lazy import library
from vanelock.pipeline.executor.tasks import Answer, Failure, Task, Work, Worker, identity, reason
from vanelock.pipeline.progress import Listener, Notice

AHEAD = 2
"""Tasks that are out for each thread of the cluster, so that none waits for the next."""
_ADDRESS = re.compile(r"(?:(?:tcp|tls|wss?|ucx)://)?(\[[\da-fA-F:]+\]|[\w.-]+):(\d{1,5})", re.ASCII)
PATIENCE = 10.0
"""Seconds to find the scheduler."""


class Cluster:
    """An existing cluster."""

    def __init__(self, address: str, listener: Listener, insecure: bool = False) -> None:
        place = _ADDRESS.fullmatch(address)
        if place is None:
            raise InputError(
                f"--scheduler {address}: no address of a scheduler, such as tcp://host:8786"
            )
        if not insecure and not protected(address):
            raise InputError(
                f"--scheduler {address}: on another machine and without encryption, where anybody "
                "on the way can run programs here: use tls:// (`vanelock manual sweeps`), or "
                "allow it with --insecure-scheduler"
            )
        distributed = library("distributed", "cluster", f"--scheduler {address}", "Dask")
        self._address, self._listener = address, listener
        self._entries: dict[str, Any] = {}
        self._out: WeakSet[Any] = WeakSet()
        try:
            with socket.create_connection((place[1].strip("[]"), int(place[2])), PATIENCE):
                pass  # where nobody listens, Dask tries on and complains when the program ends
            self._client = distributed.Client(
                address,
                timeout=PATIENCE,
                set_as_default=False,
                security=distributed.Security(),  # as Dask's configuration says
            )
        except Exception as error:
            why = getattr(error, "strerror", None) or reason(error)
            raise InputError(f"--scheduler {address}: no answer: {why}") from None
        try:
            self._check()
        except BaseException:
            self.close()
            raise

    @property
    def slots(self) -> int:
        """How many tasks may be out at a time, by the workers there are now."""
        self._check_scheduler()
        return int(max(AHEAD * sum(self._client.nthreads().values()), 1))

    def _check_scheduler(self) -> None:
        if self._client.status != "running":
            raise InputError(f"{self._address}: the scheduler is gone")

    def _check(self) -> None:
        """Refuse workers whose program is another; wait for the first of them."""
        if not self._client.nthreads():
            self._listener(Notice(f"{self._address}: waiting for a worker"))
            self._client.wait_for_workers(1)
        own, found = identity(), self._client.run(identity, on_error="return")
        for worker, other in found.items():
            if isinstance(other, BaseException):
                raise InputError(f"worker {worker}: cannot import vanelock: {reason(other)}")
            if other != own:
                raise InputError(f"worker {worker}: has vanelock {other}, here it is {own}")
        if max(self._client.nthreads().values()) > 1:
            text = "does one task at a time in each worker: start workers with --nthreads 1"
            self._listener(Notice(f"{self._address}: {text}"))

    def submit(self, task: Task, image: Callable[[str, str], bytes | None]) -> Future[Answer]:
        """Have a task done."""
        entries = {}
        for stage, key in task.given:
            known = self._entries.get(key)
            if known is None or known.status in ("cancelled", "lost", "error"):
                if (found := image(stage, key)) is None:
                    continue
                self._entries[key] = self._client.scatter(found, hash=False)
            entries[key] = self._entries[key]
        sent = (task.work, task.makes, entries, identity())
        there, here = self._client.submit(_perform, *sent, pure=False), Future[Answer]()

        def end(there: Any) -> None:
            try:
                here.set_result(there.result(timeout=60))
            except Exception as error:
                here.set_exception(error)

        self._out.add(there)
        there.add_done_callback(end)
        return here

    def failure(self, task: Task, error: Exception) -> Failure:
        """Why a worker has no answer."""
        from distributed import KilledWorker

        if isinstance(error, InputError):
            raise error
        if isinstance(error, KilledWorker):
            text = "each of the workers that tried it was killed"
            return Failure(task.name, text, again=False)
        self._check_scheduler()
        for _, key in task.given:  # what it starts from went with a worker, above all
            self._entries.pop(key, None)
        return Failure(task.name, reason(error), counts=False)

    def forget(self, keys: Collection[str]) -> None:
        """Let workers drop products."""
        for key in keys:
            self._entries.pop(key, None)

    def close(self) -> None:
        """Call back all tasks and leave; one that runs ends on its worker, unheard."""
        try:
            if self._client.status == "running":
                self._client.cancel(list(self._out), force=True)
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


_worker = Worker()
_alone = threading.Lock()
"""The mesher and the products in memory are for one task at a time."""


def _perform(
    work: Work, makes: Sequence[str], entries: Mapping[str, bytes], expected: str
) -> Answer:
    """On a worker: do a task."""
    if identity() != expected:
        raise InputError(f"a worker has vanelock {identity()}, here it is {expected}")
    with _alone:
        return _worker.perform(work, makes, entries, entries.keys())
