"""gmsh sessions: clean, quiet, repeatable, in any thread; missing libraries explained."""

import ctypes
import os
import signal
import socket
import threading
from pathlib import Path

import numpy as np
import pytest

from tests.refusals import refused
from vanelock.common.errors import InputError
from vanelock.mesh import Part, VaneDimensions, casing_sector, vane_segment
from vanelock.mesh.gmsh_session import _PACKAGES, load, session


def same(a: Part, b: Part) -> bool:
    return (
        np.array_equal(a.points, b.points)
        and np.array_equal(a.cells, b.cells)
        and all(np.array_equal(a.node_sets[name], b.node_sets[name]) for name in a.node_sets)
    )


def test_missing_library_is_named_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def opens(name: str) -> object:
        if name in ("libGLU.so.1", "libXft.so.2"):
            raise OSError(name)
        return name

    monkeypatch.setattr(ctypes, "CDLL", opens)
    with pytest.raises(InputError) as caught:
        load()
    assert str(caught.value) == (
        "gmsh: system libraries libGLU.so.1, libXft.so.2 are missing: run `apt-get install -y "
        "libglu1-mesa libxft2 libxcursor1 libxinerama1 libgomp1 libgl1`"
    )
    assert _PACKAGES in str(caught.value)


def test_session_leaves_nothing_behind() -> None:
    gmsh = load()
    casing_sector(size="coarse")
    assert not gmsh.isInitialized()
    with pytest.raises(InputError, match="^thing: these dimensions cannot be meshed"):  # noqa: PT012
        with session("thing") as inner:
            inner.model.occ.addBox(0, 0, 0, 0, 0, 0)
            inner.model.occ.synchronize()
    assert not gmsh.isInitialized()
    with pytest.raises(ZeroDivisionError), session("thing"):
        _ = 1 / 0
    assert not gmsh.isInitialized()


def test_another_s_session_is_left_alone() -> None:
    gmsh = load()
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        refused("^vane: gmsh is already initialised", vane_segment, size="coarse")
        assert gmsh.model.getCurrent() == "mine"
    finally:
        gmsh.finalize()


def test_meshes_are_the_same_bit_for_bit_in_every_thread(capfd: pytest.CaptureFixture[str]) -> None:
    first = casing_sector(size=0.03)
    vane_segment(VaneDimensions(aerofoils=1), size=0.03)  # between the two: changes nothing
    parts: list[Part] = []
    threads = [
        threading.Thread(target=lambda: parts.append(casing_sector(size=0.03))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(parts) == 2
    assert all(same(first, part) for part in parts)
    assert capfd.readouterr() == ("", "")


def test_meshing_changes_no_signal_s_handling() -> None:
    """As the system reports them: caught, ignored and blocked; C code's handlers are among them."""

    def handled() -> list[str]:
        lines = Path("/proc/self/status").read_text().splitlines()
        return [line for line in lines if line.startswith(("SigBlk", "SigIgn", "SigCgt"))]

    heard: list[int] = []
    numbers = (signal.SIGTERM, signal.SIGHUP)
    before = [signal.signal(each, lambda number, frame: heard.append(number)) for each in numbers]
    try:
        expected = handled()
        with session("thing"):
            os.kill(os.getpid(), signal.SIGTERM)
            assert handled() == expected
        os.kill(os.getpid(), signal.SIGHUP)
        assert handled() == expected
    finally:
        for each, handler in zip(numbers, before, strict=True):
            signal.signal(each, handler)
    assert heard == [signal.SIGTERM, signal.SIGHUP]
    here, there = socket.socketpair()
    there.close()
    with here, pytest.raises(BrokenPipeError):  # SIGPIPE's default ends the process
        here.sendall(b"anybody?")
