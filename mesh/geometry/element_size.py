"""Element sizes by name."""

from vanelock.common.errors import InputError

SIZES = {  # m
    "coarse": {"vane": 0.025, "casing": 0.025},
    "medium": {"vane": 0.0115, "casing": 0.0125},
    "paper": {"vane": 0.0058, "casing": 0.0100},
    "fine": {"vane": 0.0048, "casing": 0.0060},
}
SMALLEST, LARGEST = 0.001, 0.05


def element_size(size: str | float, part: str) -> float:
    """Largest element edge of a part, m, from a name or a length.

    Parameters
    ----------
    size : {"coarse", "medium", "paper", "fine"} or float
        A name, or a length in m between 1 and 50 mm.
    part : {"vane", "casing"}
        A named size may differ from part to part.

    Raises
    ------
    InputError
        For an unknown name or a length out of range.
    """
    if isinstance(size, str):
        if size not in SIZES:
            names = ", ".join(f'"{name}"' for name in SIZES)
            raise InputError(f'mesh.size = "{size}": allowed are {names} or a length in m')
        return SIZES[size][part]
    if not SMALLEST <= size <= LARGEST:
        raise InputError(f"mesh.size = {size:g} m: must lie between {SMALLEST} and {LARGEST} m")
    return float(size)
