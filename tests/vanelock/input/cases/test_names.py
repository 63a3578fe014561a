"""Names of cases: short, with units, fit for files, and as people write them."""

import pytest

from vanelock.input.cases.names import slug, valued, words
from vanelock.results.figures.curves import _merged


def test_people_and_files_get_the_same_name() -> None:
    name = "mu=0.15,interference=17um,kn=20N_um,angle=-3.5deg,coupling=uncoupled"
    assert words(name) == "μ = 0.15, interference = 17 µm, kn = 20 N/µm, angle = -3.5°, uncoupled"
    assert slug(name) == "mu0.15_interference17um_kn20N_um_angle-3.5deg_couplinguncoupled"
    assert slug("hook.mu=0.15,kn=1e+06") == "hook.mu0.15_kn1e+06"
    for name, text in (
        ("size=coarse,monitor=upper 17um", "size = coarse, monitor = upper 17um"),
        ("mu=0.15,harmonics=3", "μ = 0.15, H = 3"),
        ("nominal", "nominal"),
        (
            "engine_order=-2,coupling=constant-load,friction=isotropic,mu=0.3",
            "EO = -2, constant-load, isotropic friction, μ = 0.3",
        ),
    ):
        assert words(name) == text
    assert words("mu=0.15,harmonics=3", without="harmonics") == "μ = 0.15"
    assert _merged(["mu=0.1,kn=5", "mu=0.3,kn=5"]) == "μ = 0.1 or 0.3, kn = 5"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (4e-6, "m", "4um"),
        (-1e-3, "m", "-1mm"),
        (1.23456789e-5, "m", "12.3456789um"),
        (1.67e7, "N/m", "16.7N_um"),
        (1e-3, "kg m", "1000gmm"),
        (3.0, "N", "3N"),
        (0.15, "", "0.15"),
        ("coupled", "", "coupled"),
        (3, "", "3"),
    ],
)
def test_a_value_in_a_name(value: float | str, unit: str, text: str) -> None:
    assert valued(value, unit) == text
