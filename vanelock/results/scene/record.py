"""What a scene's run writes into results.h5, in the places where a study's run writes it.

/component/<name>      assembly.Piece
/system                nonlinear.System of the first case
/limits/<name>         assembly.Modes
/response/free, stuck  linear responses
/response/<case>       nonlinear.Response, its preload and, where it is another, its system; lower,
                       jumps: as of a study
/provenance            the scene's text, date, versions, times of the stages
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from vanelock.input.schema.scene import Scene
from vanelock.nonlinear import Response
from vanelock.quantities import warnings
from vanelock.results.files import writer
from vanelock.results.files.ledger import Ledger
from vanelock.rom import System
from vanelock.stages.scene.modes import SceneModes
from vanelock.stages.scene.monitor import Found
from vanelock.stages.scene.piece import Piece


class SceneRecord(Ledger):
    """The results file of a scene's run, written part by part as they come.

    Parameters
    ----------
    folder : Path
        The run's folder.
    scene : Scene
        What is computed.
    text : str
        Its file.
    """

    def __init__(self, folder: Path, scene: Scene, text: str) -> None:
        super().__init__(folder)
        self._system: System | None = None
        self.begin(scene.model_dump_json(), text)

    def model(self, pieces: Sequence[Piece], system: System) -> None:
        """Components and system of a case; those of the first stand at the root."""
        first, self._system = self._system is None, system
        if not first:
            return
        with self._file.edit(*(["component"] if pieces else []), "system") as file:
            for piece in pieces:
                self._file.put(file, f"component/{piece.name}", piece, {})
            self._file.put_system(file, "system", system)

    def linear(self, label: str, limits: SceneModes, responses: Mapping[str, Response]) -> None:
        """Modes and linear responses of a set of limits."""
        self._limits(label, limits, responses)

    def case(
        self,
        found: Found,
        key: str,
        responses: Sequence[Response],
        static: Response,
        monitor: str,
    ) -> None:
        """Everything about a case, at once; of its responses the higher comes first."""
        where = f"response/{found.case.name}"
        values: dict[str, Any] = {"monitor": monitor, "key": key}
        attributes = values | {f"sweep {k}": v for k, v in found.case.values.items()}
        attributes["warnings"] = warnings.of_case(found)
        if found.peak is not None:
            attributes["peak_frequency"] = found.peak.frequency
            attributes["peak_amplitude"] = found.peak.amplitude
        with self._file.edit(where) as file:
            for place, response in zip((where, f"{where}/lower"), responses, strict=False):
                self._file.put(file, place, response, attributes if place == where else {})
            writer.put_jumps(file, where, found.sweeps)
            self._file.put(file, f"{where}/preload", static, {})
            assert self._system is not None
            self._file.put_system(file, f"{where}/system", self._system)
