"""What cases are called: in file names, in titles and legends."""

import re


def slug(name: str) -> str:
    """A case's name for use in file names."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", name.replace("=", "")).strip("_")


SCALES = {
    "m": ((1e-3, 1e3, "mm"), (0.0, 1e6, "µm")),
    "N/m": ((1e5, 1e-6, "N/µm"), (0.0, 1.0, "N/m")),
    "Pa": ((1e9, 1e-9, "GPa"), (1e5, 1e-6, "MPa"), (0.0, 1.0, "Pa")),
    "kg m": ((0.0, 1e6, "g mm"),),
    "m^2/N": ((0.0, 1.0, "m²/N"),),
    "N/m^3": ((0.0, 1.0, "N/m³"),),
    "kg/m^3": ((0.0, 1.0, "kg/m³"),),
    "deg": ((0.0, 1.0, "°"),),
    "degC": ((0.0, 1.0, "°C"),),
    "N": ((0.0, 1.0, "N"),),
    "Hz": ((0.0, 1.0, "Hz"),),
    "rpm": ((0.0, 1.0, "rpm"),),
}
"""By SI unit: from which size on, factor, and unit that is shown."""
_PLAIN = str.maketrans({"µ": "u", "²": "2", "³": "3", "/": "_", " ": "", "°": "deg"})
_SHOWN = {s.translate(_PLAIN): s for scales in SCALES.values() for _, _, s in scales}
_VALUE = re.compile(rf"(-?[\d.]+(?:e[+-]?\d+)?)({'|'.join(sorted(_SHOWN, key=len)[::-1])})")


def scaled(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers up to `largest`, in an SI unit, are shown."""
    for least, factor, shown in SCALES.get(unit, ()):
        if largest >= least or not largest:
            return factor, shown
    return 1.0, unit


def valued(value: float | str, unit: str = "") -> str:
    """A value as case names, and so files, have it: "4um", "20N_um", "_" in place of "per"."""
    if isinstance(value, str):
        return value
    factor, shown = scaled(abs(value), unit)
    return f"{factor * value:.9g}{shown.translate(_PLAIN)}"


def words(name: str, without: str = "") -> str:
    """A case's name, such as "mu=0.3,interference=4um", as people write it; one key left out."""
    symbols = {"mu": "μ", "harmonics": "H", "engine_order": "EO"}
    clear = {"coupling": "", "friction": " friction"}  # whose values say what they are
    texts = []
    for text in name.split(","):
        key, _, value = text.partition("=")
        if key in clear:
            texts.append(value + clear[key])
        elif key != without:
            texts.append(f"{symbols.get(key, key)} = {_quantity(value)}" if value else key)
    return ", ".join(texts)


def _quantity(value: str) -> str:
    """A value of a case's name as people write it: "4 µm"."""
    found = _VALUE.fullmatch(value)
    if found is None:
        return value
    shown = _SHOWN[found[2]]
    return f"{found[1]}{'' if shown == '°' else ' '}{shown}"


def of_case(name: str) -> str:
    """The case in a caption: " (μ = 0.3)", nothing where there is one case alone."""
    return "" if name in ("", "nominal") else f" ({words(name)})"


def fixed(text: str) -> str:
    """A text that is not broken into lines."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")
