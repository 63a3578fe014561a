"""A run as one object: what its file holds, and what is made again from that."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import vanelock
from tests.vanelock.scenes.test_run import PAD, arm
from vanelock.commands.stored.run import show_again
from vanelock.common.errors import InputError
from vanelock.common.tables import Table
from vanelock.nonlinear import Options, frequency_response, peak_response
from vanelock.pipeline.progress import Event, Finished
from vanelock.quantities.sensitivities import Sensitivities
from vanelock.results.files.writer import Results
from vanelock.rom import System

pytestmark = pytest.mark.usefixtures("undrawn")


MU = "contacts.pad.mu"
CASES = ("mu=0.05", "mu=0.2")


def scene(folder: Path) -> Path:
    """An arm of four nodes on springs, its third node pressed on a pad, its last one shaken."""
    path = folder / "arm.toml"
    sweep = f'[sweep]\n"{MU}" = [0.05, 0.2]\n[outputs]\nshow = ["report"]\n'
    path.write_text(f"{arm(folder)}modes = 2\n{PAD}{sweep}[response]\npoints = 21\n")
    return path


@contextmanager
def inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arm")
    scene(folder)
    with inside(folder):
        run = vanelock.run("arm.toml", quiet=True)
    assert run.folder == Path("runs/arm")
    return vanelock.load(folder / run.folder)


def test_it_says_in_one_line_what_it_is(ran):
    assert repr(ran) == f"Run('{ran.folder}': 2 cases)"
    assert ran.cases == CASES
    assert ran.complete
    assert dict(ran.failed) == {}
    assert ran.page == ran.folder / "report.html"
    page = ran.page.read_text("utf-8")
    assert "arm &lt;b&gt;" in page
    assert "arm <b>" not in page
    assert ran.monitor == "arm 4, y"
    shown = ran._repr_html_()
    assert shown is not None
    assert "<td>mu=0.05</td>" in shown


def test_the_table_is_the_terminals(ran, capsys):
    heard: list[Event] = []
    given = vanelock.load_scene(ran.folder.parents[1] / "arm.toml")
    summaries = vanelock.run_scene(given, ran.folder, heard.append)
    (printed,) = (each for each in heard if isinstance(each, Table) and each.key == "cases")
    found = ran.table
    assert found[MU].tolist() == [0.05, 0.2]
    for head, values in printed.by_head().items():
        read = [None if each != each else each for each in found[head].tolist()]
        assert (
            read == pytest.approx(values, rel=1e-12)
            if head not in ("case", "converged")
            else (read == values)
        ), head
    assert set(found) - set(printed.by_head()) == {MU, "damping ratio (%)"}
    assert found["peak (µm)"].tolist() == pytest.approx(
        [1e6 * each.peak.amplitude for each in summaries if each.peak is not None]
    )
    assert capsys.readouterr() == ("", "")


def test_a_response_is_that_of_the_file_and_of_the_system(ran):
    found = ran.response("mu=0.2")
    assert found.attrs == {"case": "mu=0.2", "monitor": "arm 4, y", MU: 0.2}
    assert found.frequency.attrs["units"] == "Hz"
    assert found.amplitude.attrs["units"] == "m"
    assert found.amplitude.dims == ("frequency", "output", "direction")
    assert found.direction.values.tolist() == ["x", "y", "z"]
    with h5py.File(ran.folder / "results.h5") as file:
        group = file["response/mu=0.2"]
        order = np.argsort(group["frequency"][()])
        np.testing.assert_array_equal(found.frequency, group["frequency"][()][order])
        np.testing.assert_array_equal(found.displacement, group["output"][()][order])
    top = found.amplitude.sel(output="arm 4", direction="y").argmax("frequency")
    hertz = float(found.frequency[top])
    again = frequency_response(ran.system("mu=0.2"), [hertz], Options(3))
    at = found.amplitude.sel(frequency=hertz, output="arm 4").values
    np.testing.assert_allclose(again.amplitude[0, 0], at, rtol=1e-6)
    row = ran.table.set_index("case").loc["mu=0.2"]
    assert (row["at (Hz)"], row["peak (µm)"]) == pytest.approx((hertz, 1e6 * at[1]))


def test_keys_move_the_peak_as_differences_say(ran):
    with h5py.File(ran.folder / "results.h5") as file:
        found = Sensitivities.load(file["response/mu=0.05/sensitivities"])
        system = System.load(file["response/mu=0.05/system"])
    assert not found.reason
    expected = [
        "excitation",
        "damping.ratio",
        *(f"contacts.pad.{name}" for name in ("mu", "interference", "kn", "kt")),
    ]
    assert sorted(found.keys) == sorted(set(expected) & set(found.keys))
    assert {"contacts.pad.mu", "excitation"} <= set(found.keys)
    at = dict(zip(found.keys, zip(found.amplitude, found.frequency, strict=True), strict=True))
    frequency, amplitude = found.at
    near = 0.97 * frequency, 1.03 * frequency

    def peak(share: float) -> np.ndarray:
        contacts = replace(system.contacts, mu=(1 + share) * system.contacts.mu)
        moved = replace(system, contacts=contacts)
        solved = peak_response(moved, "force", [1.0], near, Options(3))
        return np.array([solved.amplitude[0], solved.frequency[0]])

    step = 1e-4
    up, down, here = peak(step), peak(-step), peak(0.0)
    np.testing.assert_allclose(here, [amplitude, frequency], rtol=1e-7)
    by_mu = (up - down) / (2 * step) / here
    np.testing.assert_allclose(at["contacts.pad.mu"], by_mu, rtol=1e-3, atol=1e-7)
    displaces = [at[key][0] for key in ("excitation", "contacts.pad.interference") if key in at]
    assert sum(displaces) == pytest.approx(1, abs=1e-6)
    page = ran.page.read_text("utf-8")
    assert page.count("What moves the peak of ") == 2


def test_a_wrong_name_lists_what_there_is_and_what_is_no_run_is_refused(ran, tmp_path):
    have = r"no case 'mu=1' \(it has free, mu=0\.05, mu=0\.2, stuck\)$"
    for ask in (ran.response, ran.system, ran.plot):
        with pytest.raises(InputError, match=have) as caught:
            ask("mu=1")
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="'free' is a linear limit"):
        ran.plot("free")
    with pytest.raises(InputError, match="'free' is a linear limit: name a case, which has a sys"):
        ran.system("free")
    with pytest.raises(InputError, match="no such folder"):
        vanelock.load(tmp_path / "none")
    with pytest.raises(InputError, match=r"holds no results\.h5: not the folder of a run"):
        vanelock.load(tmp_path)
    assert vanelock.load(ran.folder / "results.h5").cases == CASES
    with pytest.raises(InputError, match="no such file"):
        vanelock.run(tmp_path / "none.toml")


def test_the_figure_has_the_curves_of_the_programs_own(ran):
    figure = ran.plot()
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    peaks = dict(zip(ran.cases, ran.table["peak (µm)"], strict=True))
    plain = "\n".join(texts).replace("\N{NO-BREAK SPACE}", " ")
    for mu, peak in (("μ = 0.05", peaks["mu=0.05"]), ("μ = 0.2", peaks["mu=0.2"])):
        assert f"{mu}, H = 3\n{vanelock.render.style.number(peak)} µm at" in plain
    assert "linear, free" in plain
    assert "linear, stuck" in plain
    assert figure.texts[0].get_text() == "arm <b>: forced response"
    drawn = [line.get_ydata() for line in figure.axes[0].lines if len(line.get_ydata()) > 5]
    highest = max(np.nanmax(np.asarray(each, float)) for each in drawn)
    assert highest == pytest.approx(1e6 * float(ran.response("free").amplitude.max()), rel=1e-9)
    alone = ran.plot("mu=0.2", logarithmic=True)
    assert len(alone.legends[0].get_texts()) == 3
    assert alone.axes[0].get_yscale() == "log"
    shown: bytes = figure._repr_png_()
    assert shown.startswith(b"\x89PNG")


def test_a_run_goes_on_says_so_and_goes_where_it_is_sent(tmp_path, capsys):
    path = scene(tmp_path)
    path.write_text(path.read_text().replace('show = ["report"]', "show = []"))
    first = vanelock.run(path, tmp_path / "here")
    printed = capsys.readouterr()
    assert "Responses of arm 4, y" in printed.out
    assert "response mu=0.2: " in printed.err
    again = vanelock.run(str(path), str(tmp_path / "here"))
    assert "response mu=0.2: unchanged" in capsys.readouterr().err
    assert again.table.equals(first.table)
    with pytest.raises(InputError, match=r"no report\.html: outputs\.show has none"):
        first.page  # noqa: B018


def test_a_run_that_was_stopped_shows_what_it_has(tmp_path):
    path, heard = scene(tmp_path), []

    def stop(event: Event) -> None:
        heard.append(event)
        if getattr(event, "stage", "").startswith("response mu=0.2"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vanelock.run_scene(vanelock.load_scene(path), tmp_path / "run", stop)
    found = vanelock.load(tmp_path / "run")
    assert not found.complete
    assert repr(found).endswith(", not complete)")
    said: list[Event] = []
    with pytest.raises(InputError, match="not complete, so without pictures and page"):
        show_again(tmp_path / "run", said.append)
    assert [each.key for each in said if isinstance(each, Table)] == ["cases"]
    with pytest.raises(InputError, match=r"no report\.html: not complete"):
        found.page  # noqa: B018


def test_a_case_that_failed_says_why(tmp_path):
    """Modes 10 and 9 of six are refused; a sweep over them has one case."""
    path = scene(tmp_path)
    text = path.read_text().replace("modes = 2", "modes = 0")
    path.write_text(text.replace(f'"{MU}" = [0.05, 0.2]', '"response.mode" = [1, 10, 9]'))
    found = vanelock.run(path, tmp_path / "run", quiet=True)
    assert found.cases == ("mode=1",)
    assert list(found.failed) == ["mode=10", "mode=9"]  # as they failed
    assert repr(found).endswith(": 1 case, 2 FAILED)")
    with pytest.raises(InputError, match=r"case 'mode=9' could not be computed: .*response\.mode"):
        found.response("mode=9")


def test_a_page_drawn_again_names_the_versions_that_computed(tmp_path):
    vanelock.run(scene(tmp_path), tmp_path / "run", quiet=True)
    drawn = (tmp_path / "run" / "report.html").read_text("utf-8")
    (tmp_path / "run" / "report.html").unlink()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vanelock.__version__", "99.9")
        patch.setattr("vanelock.results.record.versions", dict)
        heard: list[Event] = []
        show_again(tmp_path / "run" / "results.h5", heard.append)
    last = heard[-1]
    assert isinstance(last, Finished)
    assert last.page == str(tmp_path / "run" / "report.html")
    again = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert again.replace("vanelock 99.9", f"vanelock {vanelock.__version__}") == drawn


def test_a_run_without_a_finished_case_has_no_page(tmp_path):
    results = Results(tmp_path / "results.h5")
    with results.edit() as file:
        about = file.create_group("provenance")
        about.create_group("versions")
        about.attrs.update({"date": "2026-01-01", "settings": "{}", "study": "", "given": "{}"})
    results.flush()
    with pytest.raises(InputError, match="no case is finished yet"):
        show_again(tmp_path)
