"""Runs the command line on a hostile file in this process."""

import time
import traceback
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from tests.verification.hostile.server import Outcome
from vanelock.__main__ import main


class Here:
    """A context manager in the place of a server, without its limits."""

    def __enter__(self) -> "Here":
        """Begin."""
        return self

    def __exit__(self, *_: object) -> None:
        """End."""

    def run(self, arguments: list[str], folder: Path) -> Outcome:
        """Run the command line in a folder."""
        out, err, status = StringIO(), StringIO(), 70
        began = time.process_time()
        with chdir(folder), redirect_stdout(out), redirect_stderr(err):
            try:
                main(arguments)
            except SystemExit as error:
                status = error.code if isinstance(error.code, int) else 1
            except BaseException:
                traceback.print_exc()
        seconds = time.process_time() - began
        return Outcome(status, seconds, 0, out.getvalue(), err.getvalue())
