"""The system's packages that vanelock's wheels do not bring, and how to get them on Debian.

gmsh does not import without its X and GL libraries, and VTK crashes the process when it renders
without a GL library, so both are looked for before either is imported. CHOLMOD is compiled from
source and needs a compiler; without it another sparse solver is used. The tests of the report look
at it in a browser, which nothing else needs.
"""

import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from pathlib import Path

# Shared library -> Debian package. The first ten are libgmsh's own needs; VTK opens GL and EGL.
REQUIRED_LIBRARIES = {
    "libGLU.so.1": "libglu1-mesa",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libXext.so.6": "libxext6",
    "libXft.so.2": "libxft2",
    "libXrender.so.1": "libxrender1",
    "libXcursor.so.1": "libxcursor1",
    "libXfixes.so.3": "libxfixes3",
    "libXinerama.so.1": "libxinerama1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
    "libEGL.so.1": "libegl1",
}

# Debian's CHOLMOD is several times faster on OpenBLAS, which installing it selects.
CHOLMOD_LIBRARIES = {
    "libcholmod.so": "libsuitesparse-dev",
    "libopenblas.so.0": "libopenblas0-pthread",
}

# Any of these serves; the first is Debian's package.
BROWSERS = ("chromium", "chromium-browser", "google-chrome")

_PROBE = """
import ctypes, sys
for name in sys.argv[1:]:
    try:
        ctypes.CDLL(name)
    except OSError:
        print(name)
"""


class CannotInstall(Exception):
    """What is missing, why it was not installed, and the line that installs it."""


def absent_libraries(names: Iterable[str]) -> list[str]:
    """Those that the dynamic loader does not find; asked of a fresh process each time."""
    command = [sys.executable, "-c", _PROBE, *names]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.split()


def missing_required() -> list[str]:
    """Debian packages without which nothing runs, as far as they are missing."""
    packages = [REQUIRED_LIBRARIES[name] for name in absent_libraries(REQUIRED_LIBRARIES)]
    if subprocess.run(
        [sys.executable, "-c", "import ensurepip, venv"], capture_output=True
    ).returncode:
        packages.insert(0, "python3-venv")
    return packages


def missing_for_cholmod() -> list[str]:
    """Debian packages that building and running CHOLMOD's Python interface lacks."""
    packages = [CHOLMOD_LIBRARIES[name] for name in absent_libraries(CHOLMOD_LIBRARIES)]
    compiler = shlex.split(str(sysconfig.get_config_var("CC") or "gcc"))[0]
    if not (shutil.which(compiler) and Path("/usr/include/stdio.h").exists()):
        packages += ["gcc", "libc6-dev"]
    if not (Path(sysconfig.get_path("include")) / "Python.h").exists():
        packages.append("python3-dev")
    return packages


def missing_for_tests() -> list[str]:
    """Debian packages that only the tests need, as far as they are missing: a browser."""
    return [] if any(map(shutil.which, BROWSERS)) else [BROWSERS[0]]


def install_line(packages: Sequence[str]) -> str:
    """The line that installs the packages, for a person to run."""
    sudo = "sudo " if os.geteuid() != 0 and shutil.which("sudo") else ""
    return (
        f"{sudo}apt-get update && "
        f"{sudo}apt-get install --yes --no-install-recommends {' '.join(packages)}"
    )


def install(packages: Sequence[str]) -> None:
    """Install Debian packages where that is allowed.

    Raises
    ------
    CannotInstall
        If there is no apt-get, no right to use it, or it fails.
    """
    if not shutil.which("apt-get"):
        raise CannotInstall("there is no apt-get on this system")
    prefix = _privilege()
    if prefix is None:
        raise CannotInstall("not root, and no sudo without a password")
    print(f"setup: installing {' '.join(packages)}", flush=True)
    apt = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]
    apt += ["--quiet=2", "-o", "DPkg::Lock::Timeout=300"]
    install_command = [*apt, "install", "--yes", "--no-install-recommends", *packages]
    if any(Path("/var/lib/apt/lists").glob("*Packages*")) and _succeeds(install_command):
        return
    # No package lists, or old ones that name versions which are gone.
    _succeeds([*apt, "update"])
    if not _succeeds(install_command):
        raise CannotInstall("apt-get failed, see above")


def _privilege() -> list[str] | None:
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and _succeeds(["sudo", "-n", "true"], stderr=subprocess.DEVNULL):
        return ["sudo", "-n"]
    return None


def _succeeds(command: Sequence[str], stderr: int | None = None) -> bool:
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stderr, check=False
    )
    return done.returncode == 0
