"""What a check says of a study that is not computed, and of the results of a run."""

import subprocess
import sys

import pytest

from vanelock import check_file
from vanelock.common.errors import InputError
from vanelock.results.files.writer import Results


def rows(path):
    return dict(check_file(path).rows)


@pytest.mark.parametrize(
    ("text", "elements"),
    [
        ("", "medium"),
        ('mesh.size = "5 mm"', "5 mm"),
        ('[sweep]\n"mesh.size" = ["coarse", 0.004]', "coarse, 4 mm"),
        ("accuracy = 0.02\nresponse.harmonics = 3", "chosen for an error of 2 %"),
        ('accuracy = 0.02\nmesh.size = "coarse"', "coarse"),
    ],
)
def test_elements_are_those_that_a_run_has(tmp_path, text, elements):
    (tmp_path / "my.toml").write_text(text)
    found = rows(tmp_path / "my.toml")
    assert found["vane"] == found["casing"] == f"from dimensions, elements {elements}"
    assert ("accuracy" in found) == ("accuracy" in text)
    if "harmonics" in text:
        chosen = "an error of 2 %: the run chooses mesh, modes, frequencies"
        assert found["accuracy"] == chosen


def test_every_wrong_file_of_measurements_gets_its_line(tmp_path):
    with pytest.raises(InputError, match="File name too long|no such file"):
        rows(tmp_path / ("x" * 300))
    (tmp_path / "bad.csv").write_text("frequency (Hz), amplitude (kg)\n1, 2\n")
    tables = "".join(f'[[measured]]\nfile = "{name}.csv"\n' for name in ("absent", "bad"))
    (tmp_path / "my.toml").write_text(tables)
    with pytest.raises(InputError) as caught:
        rows(tmp_path / "my.toml")
    lines = [line.partition(": ")[2] for line in str(caught.value).splitlines()]
    assert [line.partition(" ")[0] for line in lines] == ["measured[0].file:", "measured[1].file:"]
    assert lines[0].endswith("absent.csv: no such file")
    assert "column amplitude" in lines[1]


@pytest.mark.parametrize(
    ("failed", "expected"),
    [(0, "0"), (2, "2: mu=0, mu=1"), (7, "7: mu=0, mu=1, mu=2, mu=3, mu=4, ...")],
)
def test_failed_cases_are_counted(tmp_path, failed, expected):
    results = Results(tmp_path / "results.h5")
    with results.edit() as file:
        about = file.create_group("provenance")
        about.create_group("versions")
        about.attrs.update({"date": "2026-01-01", "settings": "{}", "study": "", "given": "{}"})
        for i in range(failed):
            file.create_group(f"failed/mu={i}").attrs.update({"reason": "it", "attempts": 2})
    results.flush()
    assert rows(tmp_path)["failed"] == expected


@pytest.mark.system
def test_a_check_loads_neither_what_draws_nor_what_solves_nor_what_fits(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text('name = "x"\n')
    program = (
        "import sys, vanelock\n"
        f"assert dict(vanelock.check_file({str(study)!r}).rows)['cases'] == '1'\n"
        "print(sorted({'gmsh', 'matplotlib', 'pyvista', 'skfem', 'numba', 'sksparse',"
        " 'scipy.optimize', 'scipy.stats'} & set(sys.modules)))"
    )
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert shown.stdout == b"[]\n"
