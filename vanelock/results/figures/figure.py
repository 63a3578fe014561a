"""A picture of a run with what a reader needs beside it: a caption, and the numbers it shows."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """A picture or animation.

    Attributes
    ----------
    path : Path
        PNG or GIF file.
    title : str
        Heading.
    caption : str
        What it shows, of which case, and what to read off it, for someone who did not make the
        run.
    data : tuple of Path
        Files that hold the numbers shown: CSV, VTU or PVD.
    """

    path: Path
    title: str
    caption: str
    data: tuple[Path, ...] = ()
