"""A scene's run: files, cache, sweeps, systems from files, mistakes."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.vanelock.results.one_file import contents
from tests.vanelock.scenes.conftest import chain, joined
from tests.vanelock.scenes.test_joined import rim
from vanelock import cases, load_scene, nonlinear, run_scene
from vanelock.commands.check.file import check_file
from vanelock.common.errors import InputError
from vanelock.pipeline.progress import Failed

SPRINGS = (3e5, 2e5, 1e5)
PAD = (
    '[contacts.pad]\nbetween = ["arm", "ground"]\npairs = [3]\nnormal = [0, 0, 1]\n'
    'kn = 4e4\nkt = 7e4\nmu = 0.2\ninterference = "400 um"\n'
    '[[loads]]\ncomponent = "arm"\nnodes = [4]\ndirection = [0, 1, 0]\namplitude = 1\n'
)


FEW = "[response]\nharmonics = 1\nrange = [78, 82]\npoints = 5\n"
QUIET = f"[outputs]\nshow = []\n{FEW}"


def arm(folder: Path) -> str:
    return 'name = "arm <b>"\n' + chain(1, 4, SPRINGS, ground=1.0).write(folder, "arm")


def test_a_system_from_a_file_is_the_scene_that_made_it(tmp_path, scene_file):
    path = scene_file(arm(tmp_path) + "modes = 2\n" + PAD + QUIET)
    joined(path).save(tmp_path / "joined.h5")
    whole = run_scene(load_scene(path), tmp_path / "whole")
    path = scene_file('[system]\nfile = "joined.h5"\n[contacts.pad]\nmu = 0.2\n' + QUIET)
    ready = run_scene(load_scene(path), tmp_path / "ready")
    assert ready[0].peak == whole[0].peak
    path = scene_file('[system]\nfile = "joined.h5"\n[contacts.pad]\nmu = 0.1\n' + QUIET)
    changed = run_scene(load_scene(path), tmp_path / "ready")
    assert changed[0].peak != whole[0].peak


def test_a_system_from_a_file_that_lacks_something_is_refused_before_a_response(
    tmp_path, scene_file
):
    one = rim(tmp_path, "cylindrical") + "[response]\nharmonics = 1\n"
    joined(scene_file(one)).save(tmp_path / "joined.h5")
    ready = '[system]\nfile = "joined.h5"\n'
    for more, expected in (
        ("[stability]\n", r"no matrices for nodal diameters .*: \[stability\] needs 0 to 3"),
        ("[contacts.bad]\nmu = 0.2\n", r"contacts\.bad: .*joined\.h5 has no such contacts"),
    ):
        path = scene_file(ready + more)
        with pytest.raises(InputError, match=expected):
            check_file(path)
        with pytest.raises(InputError, match=expected):
            run_scene(load_scene(path), tmp_path / "run")
        assert not list((tmp_path / "run").rglob("*esponse*"))


def test_damping_by_a_matrix_and_with_joints_open_or_stuck(tmp_path, scene_file):
    """C = β K, no ratio; joints are open where nothing is said, or as a system's own file says."""
    import scipy.io
    import scipy.sparse as sp

    one = chain(1, 4, SPRINGS, ground=1.0)
    scipy.io.mmwrite(tmp_path / "arm_C.mtx", sp.coo_array(2e-5 * one.K))
    text = arm(tmp_path) + 'damping = "arm_C.mtx"\nmodes = 3\n'
    system = joined(scene_file(text + PAD))
    assert system.damping_ratio is None
    np.testing.assert_allclose(system.diameters[0].C, 2e-5 * system.diameters[0].K, atol=1e-9)
    text = arm(tmp_path) + "modes = 2\n" + PAD
    assert joined(scene_file(text)).damping_joints == "open"
    stuck = joined(scene_file(text + '[damping]\njoints = "stuck"\n'))
    assert stuck.damping_joints == "stuck"
    stuck.save(tmp_path / "joined.h5")
    ready = '[system]\nfile = "joined.h5"\n'
    assert joined(scene_file(ready)).damping_joints == "stuck"
    assert joined(scene_file(ready + '[damping]\njoints = "open"\n')).damping_joints == "open"


def test_swept_values_are_checked_as_their_keys(tmp_path, scene_file):
    text = f"{arm(tmp_path)}{PAD}[sweep]\n"
    swept = '"loads[0].amplitude" = [1, "2 N"]\n"contacts.pad.mu" = [0.1]'
    found = [each.name for each in cases(load_scene(scene_file(text + swept)))]
    assert found == [f"loads[0].amplitude={i}N,mu=0.1" for i in (1, 2)]
    for sweep, expected in (
        ('"loads[3].amplitude" = [1]', "nothing of that name"),
        ('"name" = ["a"]', "only keys that hold a number"),
        ('"contacts.pad.mu" = []', "needs at least one value"),
    ):
        with pytest.raises(InputError, match=expected):
            cases(load_scene(scene_file(text + sweep)))


SYSTEM = '[system]\nfile = "x.h5"\n'


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("kn = 4e4", "kn = 0", "contacts.pad.kn = 0: normal stiffness of a pair must be > 0 N/m"),
        ("mu = 0.2\n", "", "contacts.pad.mu: must be given"),
        ('"arm", "ground"', '"leg", "ground"', 'contacts.pad.between: no component "leg"'),
        ("pairs = [3]", "pairs = [[3, 4]]", "contacts.pad.pairs: expected node numbers"),
        ("pairs = [3]", "pairs = [7]", "node 7"),
        ("normal = [0, 0, 1]", "normal = [0, 0, 0]", "contacts.pad.normal: must not be zero"),
        ('"arm_K.mtx"', '"gone.mtx"', "gone.mtx: cannot be read: No such file"),
        ('mass = "arm_M.mtx"\n', "", "components.arm.mass: must be given"),
        ("[[loads]]", f"{SYSTEM}[[loads]]", "system.file holds it already"),
        ("amplitude = 1", "amplitude = 0", "loads: nothing vibrates: give one"),
        ("[contacts.pad]", '[contacts."a pad"]', 'contacts."a pad": a name must consist'),
        ("modes = 2", "modes = 2\ncutoff = 3", "give either this or modes, not both"),
    ],
)
def test_mistakes_are_one_clear_line(tmp_path, scene_file, old, new, expected):
    text = arm(tmp_path) + "modes = 2\n" + PAD
    assert old in text
    with pytest.raises(InputError, match=expected) as error:
        joined(scene_file(text.replace(old, new)))
    assert len(str(error.value).splitlines()) == 1


def test_vectors_are_directions_however_long(tmp_path, scene_file):
    """Their squares would overflow, or vanish."""
    text = arm(tmp_path) + "modes = 2\n" + PAD.replace("kn =", "tangent = [0, 1, 0]\nkn =")
    expected = joined(scene_file(text))
    for size in ("1e200", "1e-200"):
        for key in ("normal", "tangent", "direction"):
            (line,) = (each for each in text.splitlines() if each.startswith(f"{key} = "))
            system = joined(scene_file(text.replace(line, line.replace("1", size))))
            np.testing.assert_array_equal(system.at(0).own, expected.at(0).own)
            np.testing.assert_array_equal(system.force[1].vector, expected.force[1].vector)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A scene of three cases, and what one process finds of them."""
    folder = tmp_path_factory.mktemp("swept")
    sweep = '[sweep]\n"contacts.pad.mu" = [0.05, 0.1, 0.2]\n'
    path = folder / "scene.toml"
    path.write_text(arm(folder) + "modes = 2\n" + PAD + sweep + QUIET)
    run_scene(load_scene(path), folder / "run")
    return path, contents(folder / "run" / "results.h5")


def test_a_case_that_cannot_be_computed_is_listed_and_the_rest_is_there(
    swept, tmp_path, monkeypatch
):
    real, heard, tried = nonlinear.frequency_response, list[object](), list[float]()

    def response(system: nonlinear.System, *rest: Any, **options: Any) -> Any:
        tried.append(float(system.contacts.mu.min()))
        if tried[-1] == 0.1:
            raise MemoryError
        return real(system, *rest, **options)

    path, alone = swept
    scene, folder = load_scene(path), tmp_path / "run"
    with monkeypatch.context() as patched:
        patched.setattr(nonlinear, "frequency_response", response)
        found = run_scene(scene, folder, heard.append)
    assert sorted(tried) == [0.05, 0.1, 0.1, 0.2]
    assert [each.values["contacts.pad.mu"] for each in found] == [0.05, 0.2]
    failed = [event for event in heard if isinstance(event, Failed)]
    assert failed == [Failed("mu=0.1", "out of memory", 2)]
    with h5py.File(folder / "results.h5") as file:
        assert file["failed/mu=0.1"].attrs["reason"] == "out of memory"
        assert file["failed/mu=0.1"].attrs["sweep contacts.pad.mu"] == 0.1
        assert set(file["response"]) == {"mu=0.05", "mu=0.2", "free", "stuck"}
    run_scene(scene, folder)
    assert contents(folder / "results.h5") == alone


def test_a_range_beyond_the_reduced_components_is_followed_or_refused(tmp_path, scene_file):
    """The band follows the range; a band or modes that do not hold it are refused."""
    text, wide = arm(tmp_path), "[response]\nrange = [8000, 9000]\n"
    narrow = r"components\.arm\.band = 100: response\.range reaches 9000 Hz.*\"9500 Hz\""
    with pytest.raises(InputError, match=narrow):
        load_scene(scene_file(text + "band = 100\n" + PAD + wide))
    few = r"response\.range reaches 9000 Hz, and the reduced models answer up to .*\"9500 Hz\""
    with pytest.raises(InputError, match=few):
        run_scene(load_scene(scene_file(text + "modes = 1\n" + PAD + wide)), tmp_path / "few")
    followed = joined(scene_file(text + PAD + wide))
    assert followed.band is None or followed.band > 9000
