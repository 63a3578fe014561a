"""What cases are called: in file names, in titles and legends."""

import re
from collections.abc import Sequence


def slug(name: str) -> str:
    """A case's name for use in file names."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", name.replace("=", "")).strip("_")


LENGTHS = ("interference",)
"""Last words of keys whose values are lengths that people tell in µm."""


def words(name: str, without: str = "") -> str:
    """A case's name, such as "mu=0.3,harmonics=1", as people write it; one key left out."""
    symbols = {"mu": "μ", "harmonics": "H", "engine_order": "EO"}
    clear = {"coupling": "", "friction": " friction"}  # whose values say what they are
    texts = []
    for text in name.split(","):
        key, _, value = text.partition("=")
        if key in clear:
            texts.append(value + clear[key])
        elif key != without:
            texts.append(f"{symbols.get(key, key)} = {_told(key, value)}" if value else key)
    return ", ".join(texts)


def _told(key: str, value: str) -> str:
    """A swept value, a small length in µm."""
    try:
        return f"{1e6 * float(value):.6g} µm" if key.endswith(LENGTHS) else value
    except ValueError:
        return value


def merged(names: Sequence[str]) -> str:
    """Words for cases that share a curve: the values that differ are listed, equal ones once."""
    values: dict[str, list[str]] = {}
    for name in names:
        for text in words(name).split(", "):
            key, _, value = text.partition(" = ")
            if value not in values.setdefault(key, []):
                values[key].append(value)
    return ", ".join(
        f"{key} = {' or '.join(found)}" if any(found) else key for key, found in values.items()
    )


def of_case(name: str) -> str:
    """The case in a caption: " (μ = 0.3)", nothing where there is one case alone."""
    return "" if name in ("", "nominal") else f" ({words(name)})"


def fixed(text: str) -> str:
    """A text that is not broken into lines."""
    return text.replace(" ", "\N{NO-BREAK SPACE}")
