"""What moves the peak of a run: keys of its file, against peaks of the system with one changed."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import vanelock
from tests.vanelock.commands.stored.test_run import inside, scene
from vanelock.nonlinear import Options, peak_response
from vanelock.quantities.sensitivities import Sensitivities
from vanelock.rom import System

pytestmark = pytest.mark.usefixtures("undrawn")

CASE = "response/mu=0.05"
STEP = 1e-4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("arm")
    scene(where)
    with inside(where):
        vanelock.run("arm.toml", quiet=True)
    return where / "runs" / "arm"


def test_keys_move_the_peak_as_differences_say(folder: Path) -> None:
    with h5py.File(folder / "results.h5") as file:
        found = Sensitivities.load(file[f"{CASE}/sensitivities"])
        system = System.load(file[f"{CASE}/system"])
    assert not found.reason
    expected = [
        "excitation",
        "damping.ratio",
        *(f"contacts.pad.{name}" for name in ("mu", "interference", "kn", "kt")),
    ]
    assert sorted(found.keys) == sorted(set(expected) & set(found.keys))
    assert {"contacts.pad.mu", "excitation"} <= set(found.keys)
    at = dict(zip(found.keys, zip(found.amplitude, found.frequency, strict=True), strict=True))
    frequency, amplitude = found.at
    near = 0.97 * frequency, 1.03 * frequency

    def peak(share: float) -> np.ndarray:
        contacts = replace(system.contacts, mu=(1 + share) * system.contacts.mu)
        moved = replace(system, contacts=contacts)
        solved = peak_response(moved, "force", [1.0], near, Options(3))
        return np.array([solved.amplitude[0], solved.frequency[0]])

    up, down, here = peak(STEP), peak(-STEP), peak(0.0)
    np.testing.assert_allclose(here, [amplitude, frequency], rtol=1e-7)
    by_mu = (up - down) / (2 * STEP) / here
    np.testing.assert_allclose(at["contacts.pad.mu"], by_mu, rtol=1e-3, atol=1e-7)
    displaces = [at[key][0] for key in ("excitation", "contacts.pad.interference") if key in at]
    assert sum(displaces) == pytest.approx(1, abs=1e-6)


def test_the_page_has_them_case_by_case(folder: Path) -> None:
    page = (folder / "report.html").read_text("utf-8")
    assert "What moves the peak" in page
    assert page.count("What moves the peak of ") == 2
