"""A field from a file at a part's nodes: exact at its points, close between them; bad files."""

from pathlib import Path

import numpy as np
import pytest

from vanelock.common.errors import InputError
from vanelock.stages.parts.loads import _nodal_field


def smooth(x):
    return 1e5 * (1 + 0.3 * x[:, 0] / 0.1 - 0.2 * (x[:, 1] / 0.1) ** 2)


def written(path: Path, points, values) -> Path:
    rows = [
        f"{v / 1e3:.17g};{1e3 * x:.17g};{z:.17g};{1e3 * y:.17g}"
        for (x, y, z), v in zip(points, values, strict=True)
    ]
    path.write_text("# of a flow\n\npressure (kPa);x (mm);z [m];y (mm)\n" + "\n".join(rows))
    return path


def test_points_keep_their_values_whatever_the_order_and_units_of_columns(tmp_path):
    points = np.random.default_rng(2).uniform(0, 0.1, (50, 3))
    path = written(tmp_path / "p.csv", points, smooth(points))
    found = _nodal_field(path, "pressure", "Pa", points)
    np.testing.assert_allclose(found, smooth(points), rtol=1e-9)


def test_between_points_the_error_falls_with_their_distance(tmp_path):
    nodes = np.column_stack([*np.random.default_rng(3).uniform(0, 0.1, (2, 400)), np.zeros(400)])
    errors = []
    for count in (10, 40):
        x, y = np.meshgrid(*[np.linspace(0, 0.1, count)] * 2)
        points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        found = _nodal_field(
            written(tmp_path / "p.csv", points, smooth(points)), "pressure", "Pa", nodes
        )
        errors.append(np.abs(found / smooth(nodes) - 1).mean())
    assert errors[0] < 0.01
    assert errors[1] < errors[0] / 3


@pytest.mark.parametrize(("text", "message"), [
    ("x,y,z\n0,0,0\n", "line 1: 0 columns pressure: needed are x .m., y .m., z .m., pressure"),
    ("x,y,z,pressure (mm)\n0,0,0,1\n", "line 1: pressure .mm.: not a unit like Pa"),
    ("x,y,z,pressure\n0,0,0,1\n0,0,one,1\n", "line 3: needs a number in each column"),
    ("x,y,z,pressure\n0,0,0,1\n0,0\n", "line 3: needs a number in each column"),
    ("x,y,z,pressure\n0,0,0,nan\n", "line 2: numbers must be finite"),
    ("x,y,z,pressure\n", "needs a line of names and one of numbers at least"),
    ("x,y,z,pressure\n5,0,0,1\n", "the node at 0, 0, 0 mm lies 5e.03 mm from the nearest"),
    ("x,y,z,pressure\n0,0,0,1\n0.089,0,0,1\n", "the node at 100, 0, 0 mm lies 11 mm from"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused(tmp_path, text, message):
    path = tmp_path / "p.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        _nodal_field(path, "pressure", "Pa", np.array([[0.0, 0, 0], [0.1, 0, 0]]))
