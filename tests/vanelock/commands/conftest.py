"""The smallest study's model for searches, and commands called in process."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.small_study import SMALL
from vanelock import parse_study
from vanelock.__main__ import main
from vanelock.commands.fit.refit_model import Rejoined, rejoined
from vanelock.pipeline.cache import Cache
from vanelock.pipeline.step import Stages

GAUGE = "outputs.gauges = [{ aerofoil = 2, span = 0.1, chord = 0.5 }]\n"


@pytest.fixture(scope="session")
def small_model(tmp_path_factory: pytest.TempPathFactory) -> Rejoined:
    """The small study with one harmonic and a strain gauge, its parts reduced."""
    stages = Stages(Cache(tmp_path_factory.mktemp("small"), print), lambda event: None)
    return rejoined(parse_study(f"{SMALL}{GAUGE}response.harmonics = 1\n"), stages)


@pytest.fixture
def called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[object, str, str]]:
    """Function that runs the command in this process and in `tmp_path`: status, output, errors."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: object) -> tuple[object, str, str]:
        with pytest.raises(SystemExit) as ended:
            main([*map(str, arguments)])
        return ended.value.code, *capsys.readouterr()

    return call


@pytest.fixture
def refused(called: Callable[..., tuple[object, str, str]]) -> Callable[..., str]:
    """Function that gives the one line of such a call that must fail with status 2."""

    def line(*arguments: object) -> str:
        status, out, errors = called(*arguments)
        assert (status, out) == (2, "")
        (found,) = errors.splitlines()
        return found

    return line
