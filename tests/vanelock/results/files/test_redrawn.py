"""Files that show results: drawn when they would change."""

import pytest

from vanelock.common.errors import InputError
from vanelock.pipeline.progress import silent
from vanelock.results.files.run_folder import OutputFiles


def test_pictures_are_drawn_again_only_when_they_would_change(tmp_path):
    drawn = []

    def write(text):
        def function(path):
            drawn.append(text)
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)

        return function

    def draw(shows, text):
        output_files = OutputFiles(tmp_path, silent)
        path = output_files.draw("figures/a.png", shows, write(text))
        output_files.tidy()
        return path

    for shows, text in (([1], "one"), ([1], "one again"), ([2], "two")):
        path = draw(shows, text)
    assert drawn == ["one", "two"]
    path.write_text("spoilt")
    draw([2], "repaired")
    assert path.read_text() == "repaired"
    (tmp_path / "cache" / "pictures.json").write_text('{"figures/a.png": 3')
    draw([2], "list lost")
    assert path.read_text() == "list lost"


def test_what_is_drawn_last_is_known_to_the_next_run_and_bad_places_are_named(tmp_path):
    drawn = []
    for _ in range(2):
        output_files = OutputFiles(tmp_path, silent)
        output_files.tidy(keep=["report.html"])
        output_files.draw("report.html", [], lambda path: drawn.append(path.write_text("drawn")))
    assert len(drawn) == 1
    (tmp_path / "figures").write_text("a file")
    (tmp_path / "shapes" / "a.png").mkdir(parents=True)
    for name in ("figures/a.png", "shapes/a.png"):
        with pytest.raises(InputError) as caught:
            OutputFiles(tmp_path, silent).draw(name, [], lambda path: path.write_text("drawn"))
        assert str(caught.value).startswith(f"{tmp_path / name}: cannot be written: ")


def test_pictures_of_other_results_are_removed(tmp_path):
    def write(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("drawn")

    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "mine.png").write_text("not ours")
    for names in (("a", "b"), ("b", "c")):
        output_files = OutputFiles(tmp_path, silent)
        for name in names:
            output_files.draw(f"figures/{name}.png", [], write)
        output_files.draw(f"shapes/{names[0]}/step.vtu", [], write)
        output_files.tidy()
    assert [path.name for path in (tmp_path / "shapes").iterdir()] == ["b"]  # nor empty folders
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {"b", "c", "mine"}
