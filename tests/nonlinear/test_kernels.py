"""Compiled kernels: their threads, and what is kept of them."""

import os
import subprocess
import sys

from vanelock.nonlinear import fourier


def run(program, **environment):
    return subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_wrong_number_of_threads_is_named():
    for number in ("0", "-1"):
        said = run(
            "from vanelock.nonlinear import frequency_response", NUMBA_NUM_THREADS=number
        ).stderr
        line = f"NUMBA_NUM_THREADS = {number}: must be a whole number above 0"
        assert said.splitlines()[-1] == f"vanelock.common.errors.InputError: {line}"


def test_cached_kernels_are_kept_by_all_their_sources():
    names = {path.stem for path in fourier._sources()}
    assert {"fourier", "isotropic_law", "disc_slider", "time_marching"} <= names
    assert "newton" not in names


def test_where_nothing_can_be_kept_kernels_are_compiled_all_the_same():
    program = (
        "import numpy as np\n"
        "from vanelock.nonlinear.fourier import value\n"
        "print(type(value._cache).__name__, value(np.array([1.0, 3.0, 4.0]), 0.0))"
    )
    assert run(program, NUMBA_CACHE_DIR="/dev/null/kept").stdout.split() == ["NullCache", "4.0"]
