"""Make the environment in .venv: system packages, pinned dependencies, vanelock itself.

Run by `make setup` with the Python that the environment is to use. Every step leaves alone what
is already there, and the file `.venv/made`, written last, shows make that nothing is left to do.
"""

import fcntl
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import system_packages
from system_packages import CannotInstall, install_line

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / ".venv"
PYTHON = ENVIRONMENT / "bin" / "python"
LOCK = "requirements.lock"
BUILD_TOOLS = (
    "pip",
    "setuptools",
    "setuptools-scm",
    "vcs-versioning",
    "packaging",
    "Cython",
    "numpy",
)

# Solves [[2, -1], [-1, 2]] x = [1, 0] with x = [2/3, 1/3].
_CHECK_CHOLMOD = """
import numpy as np, scipy.sparse as sp
from sksparse.cholmod import cholesky
x = cholesky(sp.csc_matrix([[2.0, -1.0], [-1.0, 2.0]]))(np.array([1.0, 0.0]))
assert np.allclose(x, [2 / 3, 1 / 3], rtol=1e-14), x
"""
_CHECK_PARDISO = """
import numpy as np, scipy.sparse as sp, pypardiso
x = pypardiso.spsolve(sp.csr_matrix([[2.0, -1.0], [-1.0, 2.0]]), np.array([1.0, 0.0]))
assert np.allclose(x, [2 / 3, 1 / 3], rtol=1e-14), x
"""
# In a process of its own: without a usable GL driver VTK ends the process.
_CHECK_GRAPHICS = """
import os
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
import gmsh, pyvista
gmsh.initialize(interruptible=False)
gmsh.finalize()
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 32))
plotter.background_color = "white"
plotter.add_mesh(pyvista.Sphere(), color="black", lighting=False)
image = plotter.screenshot(return_img=True)
assert image.min() < 64 and image.max() == 255, "blank picture"
"""


def main() -> None:
    """Make or complete the environment; one line and exit status 1 where a person must act."""
    os.chdir(ROOT)
    began = time.monotonic()
    with open(__file__) as script:
        fcntl.flock(script, fcntl.LOCK_EX)  # two make commands at once take turns
        cholmod_obstacle = _system()
        _browser()
        try:
            _virtual_environment()
            _dependencies()
            _sparse_solver(cholmod_obstacle)
        except subprocess.CalledProcessError as error:
            sys.exit(f"setup: failed, see above: {' '.join(map(str, error.cmd))}")
        _graphics()
        _contact_law()
        (ENVIRONMENT / "made").write_text(f"{ROOT}\n")
    _say(f"done in {time.monotonic() - began:.0f} s")


def _system() -> str | None:
    """Install what the system lacks; return why CHOLMOD cannot be built, if so."""
    if sys.platform != "linux":
        return None  # elsewhere the wheels bring their own libraries
    required = system_packages.missing_required()
    wanted = system_packages.missing_for_cholmod()
    if not required and not wanted:
        return None
    line = install_line([*required, *wanted])
    reason = "could not be installed"
    for packages in [required + wanted, required] if required and wanted else [required + wanted]:
        try:
            system_packages.install(packages)
            break
        except CannotInstall as error:
            reason = str(error)
    if system_packages.missing_required():
        sys.exit(
            f"setup: the system lacks libraries that gmsh, VTK or Python's venv need ({reason}).\n"
            f"setup: as root, run this line and then the same make command again:\n\n    {line}\n"
        )
    still = system_packages.missing_for_cholmod()
    return f"{reason}; to have it: {install_line(still)} && rm .venv/made" if still else None


def _browser() -> None:
    """What the tests of the report look at it with; without it they fail, and all else works."""
    wanted = system_packages.missing_for_tests() if sys.platform == "linux" else []
    if not wanted:
        return
    try:
        system_packages.install(wanted)
    except CannotInstall as error:
        _say(f"NOTE: no browser ({error}): tests of the report will fail, nothing else")
        _say(f"NOTE: to have it: {install_line(wanted)}")


def _virtual_environment() -> None:
    check = "import pip, sys; sys.exit(sys.version_info < (3, 11))"
    if PYTHON.exists() and _runs(check):
        return
    _say(f"creating .venv with Python {sys.version.split()[0]} ({sys.executable})")
    subprocess.run([sys.executable, "-m", "venv", "--clear", ENVIRONMENT], check=True)


def _dependencies() -> None:
    _say(f"installing the versions of {LOCK}")
    # The build tools first: with them in place nothing unpinned is fetched to build a wheel.
    _pip_locked("test, docs", only=BUILD_TOOLS)
    _pip_locked("test, docs", "--no-build-isolation")
    _pip("--no-build-isolation", "--no-deps", "--editable", ".")


def _sparse_solver(obstacle: str | None) -> None:
    """CHOLMOD, else PARDISO, else SciPy's own SuperLU, which is always there."""
    if _runs(_CHECK_CHOLMOD):
        return
    if obstacle is None:
        _say("building CHOLMOD's interface")
        # Never from pip's cache: a wheel built against another system's CHOLMOD may be there.
        options = ["--no-build-isolation", "--no-cache-dir", "--force-reinstall", "--no-deps"]
        try:
            _pip_locked("cholmod", *options)
            if _runs(_CHECK_CHOLMOD, show=True):
                return
            obstacle = "it was built but does not solve"
        except subprocess.CalledProcessError:
            obstacle = "its interface did not build, see above"
        subprocess.run(
            [PYTHON, "-m", "pip", "uninstall", "--quiet", "--yes", "scikit-sparse"], check=True
        )
    _say(f"NOTE: no CHOLMOD ({obstacle})")
    try:
        _pip_locked("pardiso", "--no-deps")
        if _runs(_CHECK_PARDISO, show=True):
            _say("NOTE: PARDISO takes its place: right, but up to several times slower")
            return
    except subprocess.CalledProcessError:
        pass
    _say("NOTE: SciPy's SuperLU takes its place: right, but five to ten times slower")


def _graphics() -> None:
    if not _runs(_CHECK_GRAPHICS, show=True):
        sys.exit(
            "setup: gmsh and VTK are installed, but one of them does not work here, see above; "
            "a missing software driver is installed by: apt-get install libgl1-mesa-dri"
        )


def _contact_law() -> None:
    """Compile the kernels, a minute that neither the first study nor the tests then take."""
    began = time.monotonic()
    laws = ("orthogonal", "isotropic")
    running = [subprocess.Popen([PYTHON, ROOT / "tools" / "kernels.py", law]) for law in laws]
    if any([process.wait() for process in running]):
        sys.exit("setup: the solver does not work here, see above")
    _say(f"kernels compiled in {time.monotonic() - began:.0f} s")


def _pip_locked(purpose: str, *options: str, only: Sequence[str] = ()) -> None:
    """Install what a part of the lock names; a file whose digest is not there is refused."""
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.write(locked((ROOT / LOCK).read_text(), purpose, only))
        file.flush()
        _pip(*options, "--require-hashes", "--requirement", file.name)


def locked(text: str, purpose: str, only: Sequence[str] = ()) -> str:
    """The requirements of a part of the lock, or those of some names among them."""
    (part,) = re.findall(rf"^# For: {re.escape(purpose)}\n([^#]*)", text, re.MULTILINE)
    found: list[str] = re.findall(r"^\S+==.*\n(?:[ ]+.*\n)*", part, re.MULTILINE)
    if only:
        wanted = {name.lower() for name in only}
        found = [each for each in found if each.partition("==")[0].lower() in wanted]
    return "".join(found)


def _pip(*arguments: str) -> None:
    command: Sequence[str | Path] = [PYTHON, "-m", "pip", "install", "-qq"]
    subprocess.run([*command, *arguments], check=True)


def _runs(code: str, show: bool = False) -> bool:
    stream = None if show else subprocess.DEVNULL
    return subprocess.run([PYTHON, "-c", code], stdout=stream, stderr=stream).returncode == 0


def _say(text: str) -> None:
    print(f"setup: {text}", flush=True)


if __name__ == "__main__":
    main()
