"""Study, mesh, matrix and results files of every kind of damage, each through the command line.

Every mutation ends with exit status 0 or 2 within 10 s of processor time and 1 GB, with a few plain
lines on standard error, no traceback, and nothing half-written.

A few of each kind in this process, without the limit of memory; many in children of their own.
"""

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
import pyuff

from tests.fem.matrix_files import test_formats
from tests.fem.matrix_files.conftest import Model
from tests.mesh.conftest import ring_sectors
from tests.vanelock.results.one_file import in_one_file
from tests.verification.hostile import mutations
from tests.verification.hostile.hdf5 import mutated_hdf5
from tests.verification.hostile.server import COMPUTING, SECONDS, Here, Outcome, Server
from vanelock import template_text
from vanelock.mesh import read_mesh
from vanelock.mesh.matching.pairing import pair
from vanelock.mesh.matching.side import own_part
from vanelock.nonlinear import System

FULL = os.environ.get("VANELOCK_VERIFY") == "full"
ROOT = Path(__file__).resolve().parents[3]
FEW, MANY = 9, int(os.environ.get("VANELOCK_HOSTILE", 2510 if FULL else 80))
"""Mutations of each kind of files, in this process and in children."""
WHERE = [pytest.param(Here, id="few"), pytest.param(Server, id="many", marks=pytest.mark.system)]
RUNS = 4
"""One in so many scenes that pass the check is run as a whole."""
KEPT = os.environ.get("VANELOCK_HOSTILE_KEEP")
"""Folder where files that failed are kept, to make a test of each."""


@pytest.fixture(scope="module", params=WHERE[FULL:])
def server(request: pytest.FixtureRequest) -> Iterator[Here | Server]:
    with request.param() as found:
        yield found


@pytest.fixture
def count(server: Here | Server) -> int:
    return FEW if isinstance(server, Here) else MANY


@dataclass
class Tally:
    """What became of mutations."""

    outcomes: list[Outcome] = field(default_factory=list)
    bad: list[str] = field(default_factory=list)

    def add(
        self, what: str, outcome: Outcome, folder: Path, *more: str, most: float = SECONDS
    ) -> None:
        """Judge one, and keep its files where a folder for them is named."""
        self.outcomes.append(outcome)
        faults = [*outcome.faults(most=most), *more]
        if faults:
            last = (outcome.err.splitlines() or [""])[-1][:200]
            self.bad.append(f"{what}: {', '.join(faults)}: {last}")
            if KEPT:
                name = "".join(c if c.isalnum() else "_" for c in what)
                shutil.copytree(folder, Path(KEPT) / name, symlinks=True, dirs_exist_ok=True)

    def report(self, count: int, record: Callable[[str, object], None]) -> None:
        """Record the figures, and fail where any of the mutations did."""
        status = Counter(each.status for each in self.outcomes)
        record("mutations", str(len(self.outcomes)))
        record("exit status", ", ".join(f"{k}: {n}" for k, n in sorted(status.items())))
        record("most processor time", f"{max(each.seconds for each in self.outcomes):.1f} s")
        record("most memory", f"{max(each.memory for each in self.outcomes) / 1e6:.0f} MB")
        assert not self.bad, "\n".join(self.bad[:40])
        assert len(self.outcomes) >= count
        assert status[0]
        assert status[2] > count // 50


def numbered(kind: str, count: int, tally: Tally) -> Iterator[tuple[int, np.random.Generator]]:
    """Mutations by number, each with its generator; more than a few until one is accepted."""
    for i in range(MANY):
        if i >= count and any(each.status == 0 for each in tally.outcomes):
            return
        yield i, np.random.default_rng([i, *kind.encode()])


def listing(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def checked(server: Here | Server, tally: Tally, what: str, folder: Path, file: str) -> Outcome:
    """Check a file: nothing may be written."""
    before = listing(folder)
    outcome = server.run(["check", file], folder)
    left = sorted(set(listing(folder)) - set(before))
    tally.add(what, outcome, folder, *([f"left {left}"] if left else []))
    return outcome


def studies() -> list[bytes]:
    """Studies with every table of the schema."""
    texts = [template_text(all_keys=True), (ROOT / "examples" / "paper" / "study.toml").read_text()]
    texts.append(
        'name = "all"\naccuracy = 0.01\n[mesh]\nsize = "coarse"\n[[measured]]\nfile = "rig.csv"\n'
        "[fit]\nparameters = { joints.interlock.mu = [0.1, 1] }\n"
        '[sweep]\n"joints.interlock.mu" = [0.1, 0.2, 0.3]\njoints.hook.interference = ["10 um"]\n'
        "[material.vane]\nE = [[20, 170e9], [600, 140e9]]\n[campbell]\nengine_orders = [1, 2]\n"
        "[outputs]\ngauges = [{ aerofoil = 1, span = 0.1, chord = 0.5 }]\n"
    )
    texts.append(
        '[vane]\nchord = "45 mm"\nthickness = "4 mm"\n[casing]\nbosses = 2\n[ring]\nsectors = 16\n'
        '[sweep]\nexcitation.engine_order = [1, -1]\n[response]\nrange = [230, "300 Hz"]\n'
        'points = 20\n[joints]\ninterlock.kn = "1 N/mm^3"\npatch = "area"\n[rom]\nroute = "paper"\n'
    )
    return [text.encode() for text in texts]


CSV = b"# rig\nfrequency (Hz), amplitude (um), sigma (um)\n250,1,0.1\n260,5,0.1\n270,2.5,0.1\n"


def universal_file(path: Path) -> Path:
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
    return path


def test_studies(server, count, tmp_path, record_property):
    """Study files, and the files of measured curves that they name."""
    tally, seeds = Tally(), studies()
    (tmp_path / "link").symlink_to("/etc")
    records = universal_file(tmp_path / "rig.uff").read_bytes()
    for i, random in numbered("study", count, tally):
        text, csv, uff = seeds[i % len(seeds)], CSV, records
        if i % 8 == 7:
            text, csv = seeds[2], mutations.mutated(random, csv, mutations.MATRIX)
        elif i % 8 == 3:
            text = seeds[2].replace(b'"rig.csv"', b'"rig.uff"\nrecord = %d' % (1 + i // 8 % 2))
            uff = mutations.mutated(random, uff, mutations.MATRIX)
        else:
            text = mutations.mutated(random, text, mutations.TOML)
        (tmp_path / "study.toml").write_bytes(text)
        (tmp_path / "rig.csv").write_bytes(csv)
        (tmp_path / "rig.uff").write_bytes(uff)
        checked(server, tally, f"study {i}", tmp_path, "study.toml")
    tally.report(count, record_property)


@pytest.fixture
def meshes(tmp_path, lattice, write_mesh):
    """Function that writes both parts of a small ring in a format, and a study that names them."""
    build = ring_sectors(lattice)

    def write(ending, cell_type="tetra10"):
        folder = tmp_path / f"{ending.strip('.')}_{cell_type}"
        folder.mkdir()
        text = "[ring]\nsectors = 12\n"
        for name in ("vane", "casing"):
            called = write_mesh(folder / f"{name}{ending}", build(name, cell_type))
            text += f'[{name}]\nmesh = "{name}{ending}"\nunit = "mm"\n[{name}.sets]\n'
            text += "".join(f'{key} = "{value}"\n' for key, value in called.items())
        (folder / "study.toml").write_text(text)
        return folder

    return write


ENDINGS = [".inp", ".bdf", ".msh", ".gmsh.msh", ".vtu", ".vtk", ".hexa.inp", ".hexa.bdf", ".cdb"]


def test_meshes(server, count, tmp_path, meshes, record_property):
    """Meshes of both parts, read and matched."""
    import meshio

    tally, folders = Tally(), []
    for ending in ENDINGS:
        if ending == ".vtk":
            folder = meshes(".vtu", "tetra")
            for name in ("vane", "casing"):
                mesh = meshio.read(folder / f"{name}.vtu")
                mesh.write(folder / f"{name}.vtk", file_format="vtk42", binary=name == "vane")
            text = (folder / "study.toml").read_text().replace(".vtu", ".vtk")
            (folder / "study.toml").write_text(text)
        elif ending.startswith(".hexa"):
            folder = meshes(ending.removeprefix(".hexa"), "hexahedron20")
        else:
            folder = meshes(ending)
        assert server.run(["check", "study.toml"], folder).faults((0,)) == []
        own = ending.removeprefix(".hexa")
        folders.append((folder, {n: folder / f"{n}{own}" for n in ("vane", "casing")}))
    wholes = [{n: p.read_bytes() for n, p in files.items()} for _, files in folders]
    for i, random in numbered("mesh", count, tally):
        folder, files = folders[i % len(folders)]
        name = ("vane", "casing")[int(random.integers(2))]
        whole = wholes[i % len(folders)][name]
        files[name].write_bytes(mutations.mutated(random, whole, mutations.MESH))
        checked(server, tally, f"mesh {i}", folder, "study.toml")
        files[name].write_bytes(whole)
    tally.report(count, record_property)


def scenes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """A scene in each format of matrices; folders."""
    given: list[tuple[tuple[Path, ...], dict[str, Path]]] = []
    monkeypatch.setattr(test_formats, "load_matrices", lambda *a, **k: given.append((a, k)))
    found = []
    for i, (name, write) in enumerate(test_formats.WRITERS.items()):
        place = folder / f"{i:02d}"
        place.mkdir()
        write(place, Model())
        paths, named = given.pop()
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
        text += (
            'fixed = [11]\n[contacts.pad]\nbetween = ["a", "ground"]\npairs = "pairs.csv"\n'
            'normal = [0, 0, 1]\nkn = 1e4\nkt = 1e4\nmu = 0.2\ninterference = "1 um"\n[[loads]]\n'
            'component = "a"\nnodes = [4]\ndirection = [0, 1, 0]\namplitude = 1\n[response]\n'
            "harmonics = 1\nmode = 1\npoints = 5\n[outputs]\nshow = ['loops']\n"
        )
        (place / "pairs.csv").write_text("node\n7\n")
        (place / "scene.toml").write_text(text)
        found.append(place)
    monkeypatch.undo()
    return found


def test_matrices(server, count, tmp_path, monkeypatch, record_property):
    """Scenes and their matrices, labels and node lists; some that pass are run as a whole."""
    tally, folders, passed = Tally(), scenes(tmp_path, monkeypatch), 0
    usable = [f for f in folders if server.run(["check", "scene.toml"], f).faults((0,)) == []]
    assert len(usable) >= len(folders) - 3
    for i, random in numbered("matrix", count, tally):
        folder = usable[i % len(usable)]
        files = sorted(path for path in folder.iterdir() if path.is_file())
        path = files[int(random.integers(len(files)))]
        whole = path.read_bytes()
        choice = mutations.TOML if path.suffix == ".toml" else mutations.MATRIX
        if path.suffix in (".h5", ".hdf5") and random.random() < 0.6:
            mutated_hdf5(random, path)
        else:
            path.write_bytes(mutations.mutated(random, whole, choice))
        outcome = checked(server, tally, f"matrix {i}", folder, "scene.toml")
        passed += outcome.status == 0
        # A file that lost its matrices is a study: its run is a large one, and tested elsewhere.
        scene = b"components" in (folder / "scene.toml").read_bytes()
        if outcome.status == 0 and scene and passed % RUNS == 0:
            ran = server.run(["run", "scene.toml", "-o", "out", "-q"], folder)
            wrong = half_written(folder / "out", ran)
            tally.add(f"matrix {i} run", ran, folder, *wrong, most=COMPUTING)
            shutil.rmtree(folder / "out", ignore_errors=True)
        path.write_bytes(whole)
    record_property("formats", str(len(usable)))
    tally.report(count, record_property)


def half_written(folder: Path, outcome: Outcome) -> list[str]:
    """What is not whole in a folder that a command wrote to."""
    left = [path.name for path in folder.rglob("*") if path.name.endswith(".tmp")]
    return [f"left {left}"] if left else []


@pytest.fixture
def ran(server, tmp_path, monkeypatch, lattice, write_mesh):
    """The folder of a scene's run, with a mesh in its results too, and a system of its own."""
    folder = scenes(tmp_path, monkeypatch)[0]
    text = (folder / "scene.toml").read_text().replace("show = ['loops']", "show = []")
    (folder / "scene.toml").write_text(text + '[sweep]\n"contacts.pad.mu" = [0.1, 0.2]\n')
    outcome = server.run(
        ["run", "scene.toml", "-q", "--workers", "1", "-o", str(tmp_path / "ran")], folder
    )
    assert outcome.faults((0,), COMPUTING) == []
    parts = {}
    for name in ("vane", "casing"):
        part = ring_sectors(lattice)(name, "tetra")
        called = write_mesh(tmp_path / f"{name}.vtu", part)
        parts[name] = own_part(read_mesh(tmp_path / f"{name}.vtu", "mm"), name, called)
    mates = pair(parts["vane"], parts["casing"], 12)
    with in_one_file(tmp_path / "ran" / "results.h5") as file:
        mates.vane.save(file.require_group("mesh/vane"))
        mates.casing.save(file.require_group("mesh/casing"))
        System._read(file["system"]).save(tmp_path / "system.h5")
    shutil.rmtree(tmp_path / "ran" / "results")
    return tmp_path


def test_results(server, count, ran, record_property):
    """Results of a run, checked and compared, and systems from elsewhere."""
    tally, work = Tally(), ran / "work"
    work.mkdir()
    shutil.copytree(ran / "ran", work / "b")
    (work / "a").mkdir()
    whole, system = (ran / "ran" / "results.h5").read_bytes(), (ran / "system.h5").read_bytes()
    shutil.copy(ran / "ran" / "results.h5", work / "a")
    assert server.run(["compare", "a", "b", "-o", "out"], work).faults((0,)) == []
    shutil.rmtree(work / "out")
    for i, random in numbered("results", count, tally):
        path = work / ("system.h5" if i % 5 == 4 else "a/results.h5")
        path.write_bytes(system if i % 5 == 4 else whole)
        mutated_hdf5(random, path)
        if i % 2 or i % 5 == 4:
            checked(server, tally, f"results {i}", work, str(path.relative_to(work)))
            continue
        out = work / "out"
        found = server.run(["compare", "a", "b", "-o", "out"], work)
        wrong = half_written(work, found)
        pages = {each.name for each in out.iterdir()} if out.exists() else set()
        if pages and pages != {"compare.html", "compare.csv"}:
            wrong.append(f"left {pages}")
        if found.status == 0 and "<script>alert" in (out / "compare.html").read_text("utf-8"):
            wrong.append("a script in the page")
        tally.add(f"results {i}", found, work, *wrong)
        shutil.rmtree(out, ignore_errors=True)
    tally.report(count, record_property)
