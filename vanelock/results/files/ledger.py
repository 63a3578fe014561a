"""What every run writes into its results file: where it comes from, what failed, how it ended."""

import platform
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from pathlib import Path

import vanelock
from vanelock.common.product import Product
from vanelock.nonlinear import Response
from vanelock.pipeline.cache import installed
from vanelock.pipeline.executor.tasks import Failure
from vanelock.pipeline.progress import Done
from vanelock.results.files.results_file import NAME
from vanelock.results.files.writer import Results

LIBRARIES = (
    "gmsh",
    "h5py",
    "matplotlib",
    "numba",
    "numpy",
    "pydantic",
    "pyvista",
    "scikit-fem",
    "scikit-sparse",
    "scipy",
    "vtk",
)


class Ledger:
    """The results file of a run, written part by part as they come.

    Parameters
    ----------
    folder : Path
        The run's folder.
    """

    def __init__(self, folder: Path) -> None:
        self._file = Results(folder / NAME)

    def begin(self, settings: str, text: str) -> None:
        """Begin the file: what is computed (as JSON, and as it was given), when and by what."""
        self._file.wait_for_the_end(settings)
        with self._file.edit() as file:
            group = file.require_group("provenance")
            group.attrs["date"] = datetime.now(UTC).isoformat(timespec="seconds")
            group.attrs["study"] = text
            group.attrs["settings"] = settings
            versions = group.require_group("versions")
            versions.attrs["vanelock"] = vanelock.__version__
            versions.attrs["python"] = platform.python_version()
            versions.attrs["platform"] = platform.platform()
            for library in LIBRARIES:
                versions.attrs[library] = installed(library)

    def together(self) -> AbstractContextManager[None]:
        """Let all that a block writes appear at once."""
        return self._file.together()

    def _limits(self, label: str, limits: Product, responses: Mapping[str, Response]) -> None:
        """Modes and linear responses of a set of limits."""
        named = {f"{which},{label}" if label else which: which for which in responses}
        places = [f"limits/{label or 'all'}", *(f"response/{name}" for name in named)]
        with self._file.edit(*places) as file:
            self._file.put(file, places[0], limits, {})
            for name, which in named.items():
                self._file.put(file, f"response/{name}", responses[which], {"linear": which})

    def complete(self, done: Mapping[str, Done]) -> None:
        """End the file: times and hashes of all stages, nothing is missing."""
        with self._file.edit() as file:
            for key, entry in done.items():
                group = file.require_group(f"provenance/stages/{entry.stage} {key[:8]}")
                group.attrs["key"] = key
                group.attrs["seconds"] = entry.seconds
                group.attrs["cached"] = entry.cached
            file.attrs["complete"] = True
        self._file.end()

    def failed(self, name: str, values: Mapping[str, float | str], failure: Failure) -> None:
        """A case that could not be computed."""
        with self._file.edit() as file:
            group = file.require_group(f"failed/{name}")
            group.attrs["reason"], group.attrs["attempts"] = failure.reason, failure.attempts
            for key, value in values.items():
                group.attrs[f"sweep {key}"] = value

    def flush_if_due(self) -> None:
        """Let additions appear in the file, unless it is too soon after the last ones."""
        self._file.flush_if_due()

    @contextmanager
    def finished(self) -> Iterator[None]:
        """If this block ends early, let the last additions appear, as far as that can be done."""
        try:
            yield
        except BaseException:
            try:
                self._file.flush()
            finally:
                self._file.abandon()
            raise
