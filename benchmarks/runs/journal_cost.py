"""What writing solved points down costs: a response with and without a journal, in turn.

python -m benchmarks.runs.journal_cost runs/vane/results.h5 [harmonics]
"""

import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from vanelock.nonlinear import Options, System, frequency_response
from vanelock.pipeline.journal import journal


def main() -> None:
    """Print CPU seconds of both, the least of five each, and the size of the journal."""
    with h5py.File(sys.argv[1]) as file:
        system = System.load(file["system"])
        case = next(each for each in file["response"].values() if "system" in each)
        hertz = case["frequency"][()]
    harmonics = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    ends = float(hertz.min()), float(hertz.max())
    spent: dict[bool, list[float]] = {True: [], False: []}
    for turn in range(10):
        writes = bool(turn % 2)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "response.journal"
            with journal(path, print) as opened:
                began = time.process_time()
                found = frequency_response(
                    system, ends, Options(harmonics), journal=opened if writes else None
                )
                spent[writes].append(time.process_time() - began)
            size = path.stat().st_size
    least = {writes: np.min(times) for writes, times in spent.items()}
    print(f"{found.points} points, H = {harmonics}, {system.contacts.count} contacts")
    more = least[True] / least[False] - 1
    print(f"without {least[False]:.3f} s, with {least[True]:.3f} s CPU: {more:+.1%}")
    print(f"journal {size / 1e6:.1f} MB, {size / found.points / 1e3:.0f} kB a point")


main()
