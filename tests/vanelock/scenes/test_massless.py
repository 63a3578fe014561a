"""Rows without mass: pilot nodes, and rotations of elements without rotary inertia."""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg as sl

from tests.vanelock.scenes.conftest import Chain, Write, chain, joined, refused_by
from vanelock.nonlinear import Options, frequency_response
from vanelock.rom import linear_modes

SPRINGS = (3e5, 2e5, 1e5)
TOUCHES = (
    '[contacts.pad]\nbetween = ["one", "ground"]\npairs = [6]\nnormal = [1, 0, 0]\nkn = 1e4\n'
    'kt = 1e4\nmu = 0.3\ninterference = 1e-6\n[[loads]]\ncomponent = "one"\nnodes = [3]\n'
    "direction = [0, 0, 1]\namplitude = 1\n[response]\nmode = 1\n[outputs]\n"
    "loops = false\nreport = false\n"
)
SUPER = 'kind = "superelement"\n'
NEGATIVE = np.kron([[0.1, 0.2], [0.2, 0.1]], np.eye(3))
WITHOUT = {
    "inner": slice(3, 6),
    "at the contact": slice(15, 18),
    "at the load": slice(6, 9),
    "every y": slice(1, None, 3),
}


def scene_of(one: Chain, folder: Path, keys: str, scene_file: Write) -> Path:
    return scene_file(one.write(folder, "one") + keys + TOUCHES)


@pytest.mark.parametrize("keys", ['kind = "superelement"\n', "", "modes = 8\n", "cutoff = 1e4\n"])
@pytest.mark.parametrize("without", WITHOUT)
def test_massless_rows_follow_the_others(tmp_path, scene_file, without, keys):
    """Frequencies are those of the matrices with these rows condensed by hand."""
    one = chain(1, 6, SPRINGS, ground=1.0)
    one.M[WITHOUT[without]] = 0
    system = joined(scene_of(one, tmp_path, keys, scene_file))
    frequency, shapes = linear_modes(system, 0, 4)

    K = one.K.copy()
    K[15:, 15:] += 1e4 * np.eye(3)
    a = one.M.diagonal() > 0
    condensed = K[np.ix_(a, a)] - K[np.ix_(a, ~a)] @ sl.solve(K[np.ix_(~a, ~a)], K[np.ix_(~a, a)])
    exact = np.sqrt(sl.eigvalsh(condensed, one.M[np.ix_(a, a)])[:4]) / (2 * np.pi)
    np.testing.assert_allclose(frequency, exact, rtol=1e-3 if "modes" in keys else 1e-9)
    M = system.diameters[0].M
    np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(4), atol=1e-9)
    assert frequency_response(system, frequency[:1], Options(3)).converged.all()


@pytest.mark.parametrize(
    ("rows", "block", "keys", "expected"),
    [
        (slice(3, 9), NEGATIVE, SUPER, "mass matrix is not pos"),
        (slice(3, 9), NEGATIVE, "modes = 4\n", "components.one"),
        (slice(3, 6), 0.0, "modes = 13\n", "allowed are 0 to 12"),
    ],
)
def test_what_is_no_mass_is_refused(tmp_path, scene_file, rows, block, keys, expected):
    one = chain(1, 6, SPRINGS, ground=1.0)
    one.M[rows, rows] = block
    refused_by(joined, scene_of(one, tmp_path, keys, scene_file), expected)
