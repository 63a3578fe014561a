"""Study, mesh, matrix and results files of every kind of damage, each through the command line.

Every mutation ends with exit status 0 or 2 within 10 s of processor time and 1 GB, with a few plain
lines on standard error, no traceback, and nothing half-written.
"""

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyuff

from tests.conftest import FULL
from tests.fem.matrix_files.conftest import Model
from tests.fem.matrix_files.test_formats import WRITERS
from tests.mesh.conftest import ring_sectors
from tests.vanelock.results.one_file import in_one_file
from tests.verification.conftest import ROOT
from tests.verification.hostile import mutations
from tests.verification.hostile.hdf5 import mutated_hdf5
from tests.verification.hostile.server import COMPUTING, SECONDS, Outcome, Server
from vanelock import template_text
from vanelock.mesh import read_mesh
from vanelock.mesh.matching.pairing import pair
from vanelock.mesh.matching.side import own_part
from vanelock.nonlinear import System

FEW, MANY = 9, int(os.environ.get("VANELOCK_HOSTILE", 2510 if FULL else 80))
"""Mutations of each kind of files: at least, and at most."""
COUNTS = [pytest.param(FEW, id="few"), pytest.param(MANY, id="many", marks=pytest.mark.system)]
RUNS = 4
"""One in so many scenes that pass the check is run as a whole."""
KEPT = os.environ.get("VANELOCK_HOSTILE_KEEP")
"""Folder where files that failed are kept, to make a test of each."""


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with Server() as process:
        yield process


class Trial:
    """Commands on mutations of one kind of files, and what became of them."""

    def __init__(self, server: Server, count: int) -> None:
        self.run, self.count = server.run, count
        self.outcomes: list[Outcome] = []
        self.bad: list[str] = []

    def numbered(self, kind: str) -> Iterator[tuple[int, np.random.Generator]]:
        """Mutations by number, each with its generator; more than a few until one is accepted."""
        for i in range(MANY):
            if i >= self.count and any(each.status == 0 for each in self.outcomes):
                return
            yield i, np.random.default_rng([i, *kind.encode()])

    def judge(
        self, what: str, outcome: Outcome, folder: Path, *more: str, most: float = SECONDS
    ) -> None:
        """Judge one, and keep its files where a folder for them is named."""
        self.outcomes.append(outcome)
        left = [path.name for path in folder.rglob("*.tmp")]
        faults = [*outcome.faults(most=most), *more, *(f"left {name}" for name in left)]
        if faults:
            last = (outcome.err.splitlines() or [""])[-1][:200]
            self.bad.append(f"{what}: {', '.join(faults)}: {last}")
            if KEPT:
                shutil.copytree(folder, Path(KEPT) / what, symlinks=True, dirs_exist_ok=True)

    def check(self, what: str, folder: Path, file: str) -> Outcome:
        """Check a file: nothing may be written."""
        before = set(folder.rglob("*"))
        outcome = self.run(["check", file], folder)
        left = set(folder.rglob("*")) - before
        self.judge(what, outcome, folder, *(f"left {path}" for path in left))
        return outcome

    def report(self, record: Callable[[str, object], None]) -> None:
        """Record the figures, and fail where any of the mutations did."""
        status = Counter(each.status for each in self.outcomes)
        record("mutations", str(len(self.outcomes)))
        record("exit status", ", ".join(f"{k}: {n}" for k, n in sorted(status.items())))
        record("most processor time", f"{max(each.seconds for each in self.outcomes):.1f} s")
        record("most memory", f"{max(each.memory for each in self.outcomes) / 1e6:.0f} MB")
        assert not self.bad, "\n".join(self.bad[:40])
        assert len(self.outcomes) >= self.count
        assert status[0]
        assert status[2] > self.count // 50


@pytest.fixture(params=COUNTS[FULL:])
def trial(server: Server, request: pytest.FixtureRequest) -> Trial:
    return Trial(server, request.param)


STUDIES = (
    'name = "all"\naccuracy = 0.01\n[mesh]\nsize = "coarse"\n[[measured]]\nfile = "rig.csv"\n'
    "[fit]\nparameters = { joints.interlock.mu = [0.1, 1] }\n"
    '[sweep]\n"joints.interlock.mu" = [0.1, 0.2, 0.3]\njoints.hook.interference = ["10 um"]\n'
    "[material.vane]\nE = [[20, 170e9], [600, 140e9]]\n[campbell]\nengine_orders = [1, 2]\n"
    "[outputs]\ngauges = [{ aerofoil = 1, span = 0.1, chord = 0.5 }]\n",
    '[vane]\nchord = "45 mm"\nthickness = "4 mm"\n[casing]\nbosses = 2\n[ring]\nsectors = 16\n'
    '[sweep]\nexcitation.engine_order = [1, -1]\n[response]\nrange = [230, "300 Hz"]\n'
    'points = 20\n[joints]\ninterlock.kn = "1 N/mm^3"\npatch = "area"\n[rom]\nroute = "paper"\n',
)
CSV = b"# rig\nfrequency (Hz), amplitude (um), sigma (um)\n250,1,0.1\n260,5,0.1\n270,2.5,0.1\n"


def universal_file(path: Path) -> bytes:
    """Units, and two function records, in text and in binary."""
    hertz = np.linspace(250, 270, 21)
    units = {"type": 164, "units_code": 1, "length": 1.0, "force": 1.0, "temp": 1.0}
    record = {
        "type": 58, "func_type": 4, "rsp_node": 1, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0,
        "data": 1e-6 / (1j + hertz - 260), "x": hertz, "abscissa_spacing": 1,
        "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 8, "orddenom_spec_data_type": 0,
        "z_axis_spec_data_type": 0, "ordinate_axis_units_lab": "m",
    }  # fmt: skip
    file = pyuff.UFF(str(path))
    for each in ({**units, "temp_offset": 0.0}, {**record, "binary": 0}, {**record, "binary": 1}):
        file.write_sets([each], "add")
    return path.read_bytes()


def test_studies(trial, tmp_path, record):
    """Studies with every table of the schema, and the files of measured curves that they name."""
    paper = (ROOT / "examples" / "paper" / "study.toml").read_text()
    seeds = [text.encode() for text in (template_text(all_keys=True), paper, *STUDIES)]
    (tmp_path / "link").symlink_to("/etc")
    records = universal_file(tmp_path / "rig.uff")
    for i, random in trial.numbered("study"):
        files = {"study.toml": seeds[i % len(seeds)], "rig.csv": CSV, "rig.uff": records}
        which, choice = "study.toml", mutations.TOML
        if i % 4 == 3:
            which, choice = ("rig.uff", "rig.csv")[i // 4 % 2], mutations.MATRIX
            named = f'"{which}"\nrecord = {1 + i // 8 % 2}' if which == "rig.uff" else f'"{which}"'
            files["study.toml"] = seeds[2].replace(b'"rig.csv"', named.encode())
        files[which] = mutations.mutated(random, files[which], choice)
        for name, content in files.items():
            (tmp_path / name).write_bytes(content)
        trial.check(f"study {i}", tmp_path, "study.toml")
    trial.report(record)


@pytest.fixture
def meshes(tmp_path, lattice, write_mesh):
    """Function that writes both parts of a small ring in a format, and a study that names them."""

    def write(ending):
        kind = "tetra" if ending == ".vtk" else "tetra10"
        if ending.startswith(".hexa"):
            kind = "hexahedron20"
        folder, build = tmp_path / ending.strip("."), ring_sectors(lattice)
        folder.mkdir()
        ending = ending.removeprefix(".hexa")
        files, text = {}, "[ring]\nsectors = 12\n"
        for name in ("vane", "casing"):
            files[name] = folder / f"{name}{ending}"
            path = files[name].with_suffix(".vtu") if ending == ".vtk" else files[name]
            called = write_mesh(path, build(name, kind))
            if ending == ".vtk":
                old = {"file_format": "vtk42", "binary": name == "vane"}
                meshio.read(path).write(files[name], **old)
            text += f'[{name}]\nmesh = "{name}{ending}"\nunit = "mm"\n[{name}.sets]\n'
            text += "".join(f'{key} = "{value}"\n' for key, value in called.items())
        (folder / "study.toml").write_text(text)
        return folder, files

    return write


ENDINGS = [".inp", ".bdf", ".msh", ".gmsh.msh", ".vtu", ".vtk", ".hexa.inp", ".hexa.bdf", ".cdb"]


def test_meshes(trial, meshes, record):
    """Meshes of both parts, read and matched."""
    folders = [meshes(ending) for ending in ENDINGS]
    for folder, _ in folders:
        assert trial.run(["check", "study.toml"], folder).faults((0,)) == []
    for i, random in trial.numbered("mesh"):
        folder, files = folders[i % len(folders)]
        path = files[("vane", "casing")[int(random.integers(2))]]
        whole = path.read_bytes()
        path.write_bytes(mutations.mutated(random, whole, mutations.MESH))
        trial.check(f"mesh {i}", folder, "study.toml")
        path.write_bytes(whole)
    trial.report(record)


SCENE = """fixed = [11]
[contacts.pad]
between = ["a", "ground"]
pairs = "pairs.csv"
normal = [0, 0, 1]
kn = 1e4
kt = 1e4
mu = 0.2
interference = "1 um"
[[loads]]
component = "a"
nodes = [4]
direction = [0, 1, 0]
amplitude = 1
[response]
harmonics = 1
mode = 1
points = 5
[outputs]
show = ['loops']
"""


def scenes(folder: Path) -> list[Path]:
    """A scene in each format of matrices; folders."""
    found = []
    for i, (name, write) in enumerate(WRITERS.items()):
        place = folder / f"{i:02d}"
        place.mkdir()
        paths, named = write(place, Model())
        keys = dict(zip(("stiffness", "mass", "damping"), paths, strict=False)) | named
        text = f'name = "{name}"\n[components.a]\n'
        for key, value in keys.items():
            if isinstance(value, dict):
                text += "".join(f'{k}_name = "{v}"\n' for k, v in value.items())
                continue
            file, colon, inside = str(value).partition(":")
            if Path(file).parent != place:
                shutil.copy(file, place)
            text += f'{key} = "{Path(file).name}{colon}{inside}"\n'
        (place / "pairs.csv").write_text("node\n7\n")
        (place / "scene.toml").write_text(text + SCENE)
        found.append(place)
    return found


def test_matrices(trial, tmp_path, record):
    """Scenes and their matrices, labels and node lists; some that pass are run as a whole."""
    folders, passed = scenes(tmp_path), 0
    usable = [f for f in folders if trial.run(["check", "scene.toml"], f).faults((0,)) == []]
    assert len(usable) >= len(folders) - 3
    record("formats", str(len(usable)))
    for i, random in trial.numbered("matrix"):
        folder = usable[i % len(usable)]
        files = sorted(path for path in folder.iterdir() if path.is_file())
        path = files[int(random.integers(len(files)))]
        whole = path.read_bytes()
        choice = mutations.TOML if path.suffix == ".toml" else mutations.MATRIX
        if path.suffix in (".h5", ".hdf5") and random.random() < 0.6:
            mutated_hdf5(random, path)
        else:
            path.write_bytes(mutations.mutated(random, whole, choice))
        accepted = trial.check(f"matrix {i}", folder, "scene.toml").status == 0
        passed += accepted
        # A file that lost its matrices is a study: its run is a large one, and tested elsewhere.
        scene = b"components" in (folder / "scene.toml").read_bytes()
        if accepted and scene and passed % RUNS == 0:
            ran = trial.run(["run", "scene.toml", "-o", "out", "-q"], folder)
            trial.judge(f"matrix {i} run", ran, folder, most=COMPUTING)
            shutil.rmtree(folder / "out", ignore_errors=True)
        path.write_bytes(whole)
    trial.report(record)


@pytest.fixture
def ran(server, tmp_path, lattice, write_mesh):
    """The folder of a scene's run, with a mesh in its results too, and a system of its own."""
    folder = scenes(tmp_path)[0]
    text = (folder / "scene.toml").read_text().replace("show = ['loops']", "show = []")
    (folder / "scene.toml").write_text(text + '[sweep]\n"contacts.pad.mu" = [0.1, 0.2]\n')
    command = ["run", "scene.toml", "-q", "--workers", "1", "-o", str(tmp_path / "ran")]
    assert server.run(command, folder).faults((0,), COMPUTING) == []
    parts = {}
    for name in ("vane", "casing"):
        called = write_mesh(tmp_path / f"{name}.vtu", ring_sectors(lattice)(name, "tetra"))
        parts[name] = own_part(read_mesh(tmp_path / f"{name}.vtu", "mm"), name, called)
    mates = pair(parts["vane"], parts["casing"], 12)
    with in_one_file(tmp_path / "ran" / "results.h5") as file:
        mates.vane.save(file.require_group("mesh/vane"))
        mates.casing.save(file.require_group("mesh/casing"))
        System._read(file["system"]).save(tmp_path / "system.h5")
    shutil.rmtree(tmp_path / "ran" / "results")
    return tmp_path


def test_results(trial, ran, record):
    """Results of a run, checked and compared, and systems from elsewhere."""
    work, out, comparison = ran / "work", ran / "work" / "out", ["compare", "a", "b", "-o", "out"]
    for name in "ab":
        shutil.copytree(ran / "ran", work / name)
    whole, system = (ran / "ran" / "results.h5").read_bytes(), (ran / "system.h5").read_bytes()
    assert trial.run(comparison, work).faults((0,)) == []
    shutil.rmtree(out)
    for i, random in trial.numbered("results"):
        path = work / ("system.h5" if i % 5 == 4 else "a/results.h5")
        path.write_bytes(system if i % 5 == 4 else whole)
        mutated_hdf5(random, path)
        if i % 2 or i % 5 == 4:
            trial.check(f"results {i}", work, str(path.relative_to(work)))
            continue
        compared = trial.run(comparison, work)
        pages = {each.name for each in out.iterdir()} if out.exists() else set()
        wrong = [f"left {pages}"] * (pages not in (set(), {"compare.html"}))
        if compared.status == 0 and "<script>alert" in (out / "compare.html").read_text("utf-8"):
            wrong.append("a script in the page")
        trial.judge(f"results {i}", compared, work, *wrong)
        shutil.rmtree(out, ignore_errors=True)
    trial.report(record)
