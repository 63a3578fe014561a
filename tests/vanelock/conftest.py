"""A system small enough to solve by hand, undrawn runs, and what golden runs keep."""

import os
import shutil
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vanelock.pipeline.cache import Cache
from vanelock.pipeline.progress import silent
from vanelock.pipeline.step import Stages
from vanelock.results.files.run_folder import OutputFiles
from vanelock.rom import Contacts, Diameter, Force, System

HOOK, INTERLOCK, SPRING = 3e6, 1e6, 2e6


@pytest.fixture
def ring():
    """Three sectors of two masses of 1 kg, normal contacts alone.

    The first mass hangs in its hook and holds the second by a spring; the second presses on that
    of the next sector, so that at nodal diameter 1 the interlock has the stiffness
    |1 - e^{-2πi/3}|² kn = 3 kn.
    """
    own = np.zeros((2, 3, 2))
    following = np.zeros((2, 3, 2))
    own[0, 0, 0] = own[1, 0, 1] = 1
    following[1, 0, 1] = -1
    K = np.array([[SPRING, -SPRING], [-SPRING, SPRING]])
    output = np.zeros((1, 3, 2))
    output[0, 1, 1] = 1
    matrices = Diameter(K, np.eye(2), own, following, output)
    return System(
        sectors=3,
        engine_order=1,
        diameters={0: matrices, 1: matrices},
        contacts=Contacts(
            kn=np.array([HOOK, INTERLOCK]),
            kt=np.full((2, 2), 1e6),
            mu=np.array([0.3, 0.3]),
            v0=np.array([1e-5, 1e-5]),
            joint=("hook", "interlock"),
            always_closed=("hook",),
        ),
        force={1: Force(np.array([1.0 + 0j, 0]))},
        output_names=("vane output 1",),
        damping_ratio=0.01,
    )


@pytest.fixture(scope="module")
def undrawn(shared):
    """Pictures of this file's runs are blank, but for golden ones; tables and pages are as ever."""
    golden = Path(os.environ.get("VANELOCK_GOLDEN", shared / "golden"))
    draw, made = OutputFiles.draw, BytesIO()
    Image.new("L", (1, 1)).save(made, "PNG")

    def blank(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(made.getvalue())

    def drawn(files, name, shows, function, quick=False):
        if name.endswith(".png") and not files.folder.is_relative_to(golden):
            function = blank
        return draw(files, name, shows, function, quick)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(OutputFiles, "draw", drawn)
        yield


@pytest.fixture
def kept_by(golden, tmp_path) -> Callable[[str], Stages]:
    """Function that gives stages which find all that a golden run has computed, in `tmp_path`."""

    def build(name: str) -> Stages:
        folder = tmp_path / "cache"
        shutil.copytree(golden(name).folder / "cache", folder, copy_function=os.link)
        return Stages(Cache(folder, print), silent)

    return build
