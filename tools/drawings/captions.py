"""Names and values of dimensions, as a drawing shows them."""

from pydantic import BaseModel


def caption(dimensions: BaseModel, name: str, prefix: str = "") -> str:
    """A dimension's dotted name and value: lengths in mm, angles in degrees.

    Parameters
    ----------
    dimensions : BaseModel
        What it belongs to.
    name : str
        Its name there, such as "hook.roof_radius".
    prefix : str
        Put before the name.
    """
    *path, last = name.split(".")
    for step in path:
        dimensions = getattr(dimensions, step)
    text = type(dimensions).model_fields[last].description or ""
    value = getattr(dimensions, last)
    if text.endswith("[m]"):
        shown = millimetres(value)
    elif text.endswith("[deg]"):
        shown = f"{value:.6g}°"
    elif "fraction of the " in text:
        shown = f"{value:.6g} × {text.partition('fraction of the ')[2]}"
    else:
        shown = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"{prefix}{name}  {shown}"


def millimetres(length: float) -> str:
    """A length in m as a drawing shows it."""
    return f"{1e3 * length:.6g}"
