"""Tables and responses in the forms of pandas and xarray, which are optional."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vanelock.common.lazy import library
from vanelock.common.tables import Table

if TYPE_CHECKING:
    import pandas
    import xarray

EXTRA = "frames"


def frame(table: Table, more: Mapping[str, Sequence[Any]]) -> "pandas.DataFrame":
    """A table's columns by their heads, and further ones behind the first of them."""
    made = library("pandas", EXTRA, "Run.table").DataFrame(table.by_head())
    for place, (name, values) in enumerate(more.items(), start=1):
        made.insert(place, name, list(values))
    return made


def dataset(
    response: h5py.Group,
    outputs: Sequence[str],
    directions: Sequence[str],
    about: Mapping[str, Any],
) -> "xarray.Dataset":
    """A stored response of outputs in some directions, frequencies ascending.

    What did not converge is NaN there, since nothing of it is to be trusted.
    """
    xarray_library = library("xarray", EXTRA, "Run.response")
    order = np.argsort(response["frequency"][()], kind="stable")
    converged = response["converged"][()][order]
    by_point = ["frequency", "output", "direction"]
    by_harmonic = ["frequency", "harmonic", "output", "direction"]

    def known(name: str) -> Any:
        values = response[name][()][order]
        values[~converged] = np.nan
        return values

    amplitude, displacement = known("amplitude"), known("output")
    half = {"units": "m", "long_name": "half the peak-to-peak"}
    wave = {"units": "m", "long_name": "coefficients q^(h) of q(t) = Re Σ q^(h) exp(i h ω t)"}
    made: xarray.Dataset = xarray_library.Dataset(
        {
            "amplitude": (by_point, amplitude, half),
            "displacement": (by_harmonic, displacement, wave),
            "converged": (["frequency"], converged),
            "residual": (["frequency"], response["residual"][()][order]),
        },
        {
            "frequency": ("frequency", response["frequency"][()][order], {"units": "Hz"}),
            "harmonic": np.arange(displacement.shape[1]),
            "output": list(outputs),
            "direction": list(directions),
        },
        dict(about),
    )
    return made
