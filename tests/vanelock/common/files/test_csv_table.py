"""CSV files: what is written is what is read back."""

import csv

import numpy as np
from numpy.typing import ArrayLike

from vanelock.common.files.csv_table import write_columns


def test_numbers_read_back_exactly_and_gaps_are_empty(tmp_path):
    frequency = np.array([249.1, 1 / 3, 1e-300, 5e-324])
    amplitude = np.array([np.nan, 2.0**0.5])
    columns: dict[str, ArrayLike] = {
        "frequency (Hz)": frequency,
        "amplitude (µm)": amplitude,
        "state": ["stuck", 'slips, "opens"'],
        "solved": np.array([True, False]),
    }
    path = write_columns(tmp_path / "new" / "curve.csv", columns, ["Peak: 3 µm", "two\nlines"])
    lines = path.read_text("utf-8").splitlines()
    assert lines[:3] == ["# Peak: 3 µm", "# two", "# lines"]
    header, *rows = csv.reader(lines[3:])
    assert header == list(columns)
    assert [float(row[0]) for row in rows] == frequency.tolist()
    assert [row[1] for row in rows] == ["", str(amplitude[1]), "", ""]
    assert [row[2:] for row in rows] == [["stuck", "1"], ['slips, "opens"', "0"], *[["", ""]] * 2]
