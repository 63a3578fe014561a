"""Two masses and a friction damper, in pyHarm and here: how far the curves differ, and their cost.

    python -m benchmarks.peers.two_masses --peer-python PATH [--instants 1024 4096]

PATH as in `peer.py`. Masses, springs, damping, load and band are those of pyHarm's tutorial on
friction; the friction is that of a Jenkins element, which both programs have.
"""

import argparse
import os
import resource
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.peers.peer import ONE_THREAD
from vanelock.nonlinear import Contact, Options, System, frequency_response

PEER = Path(__file__).with_name("two_masses_pyharm.py")


def two_masses() -> System:
    """A sprung mass, and a small one on it that slides on the ground."""
    return System.from_matrices(
        M=np.diag([1.0, 0.02]),
        C=np.diag([0.05, 0.0]),
        K=[[680.0, -40.0], [-40.0, 40.0]],
        contacts=[Contact(tangential=1, kt=400.0, mu=0.5, preload=1.0)],
        force={0: 1.0},
    )


def peer(python: str, instants: int, folder: Path) -> tuple[np.ndarray, np.ndarray, float]:
    """Frequencies, rad/s, harmonics of the large mass, (p, 6) complex, and CPU time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [python, str(PEER), str(instants), "curve.npz"]
    environment = {**os.environ, **ONE_THREAD}
    # in a folder of its own: it leaves a file where it runs
    subprocess.run(command, check=True, capture_output=True, env=environment, cwd=folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    found = np.load(folder / "curve.npz")
    x = found["x"]
    return found["omega"], np.hstack([x[:, :1], x[:, 1::2] - 1j * x[:, 2::2]]), seconds


def main() -> None:
    """Print a line for each number of instants."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--peer-python", required=True)
    parser.add_argument("--instants", type=int, nargs="+", default=[1024, 4096])
    given = parser.parse_args()
    for instants in given.instants:
        with tempfile.TemporaryDirectory() as folder:
            omega, theirs, seconds = peer(given.peer_python, instants, Path(folder))
        begin = time.process_time()
        found = frequency_response(two_masses(), omega / (2 * np.pi), Options(5))
        own = time.process_time() - begin
        ours = found.output[:, :, 0, 0]
        apart = np.abs(theirs - ours).max() / np.abs(ours).max()
        print(
            f"{instants} instants: {len(omega)} frequencies to {omega.max():.2f} rad/s; apart by "
            f"{apart:.1e} of the largest amplitude; CPU {seconds:.1f} s there, {own:.2f} s here",
            flush=True,
        )


if __name__ == "__main__":
    main()
