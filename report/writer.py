"""A page of blocks as one file of HTML that needs nothing else."""

import os
from pathlib import Path

from vanelock.files import placed
from vanelock.report.blocks import Page


def write_page(path: str | os.PathLike[str], page: Page) -> Path:
    """Write the page, whole or not at all, and return its path."""
    target = Path(path)
    with placed(target) as temporary:
        temporary.write_text(f"<!doctype html><title>{page.title}</title>", "utf-8")
    return target
