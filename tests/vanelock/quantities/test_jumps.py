"""Several solutions: what is said of jumps, and where a direction may be given."""

import pytest

from vanelock import parse_study
from vanelock.common.errors import InputError
from vanelock.quantities.warnings import notes
from vanelock.stages.response.summary import Jump, Peak, Sweep

JUMP = Jump((250.0, 250.2), (5e-6, 2e-6))
UP = Sweep("up", Peak(3, 250.0, 5e-6, False), (JUMP,))
DOWN = Sweep("down", Peak(7, 248.0, 6e-6, False), ())


def test_a_jump_is_reported_with_its_place_and_heights() -> None:
    first, second = notes([UP])
    assert first == "sweeping up JUMPS from 5 to 2 um between 250 and 250.2 Hz"
    assert second.endswith('may reach higher: response.direction = "both"')
    both = Sweep("both", UP.peak, (JUMP,))
    assert "looked for from every jump" in list(notes([both]))[1]
    assert not list(notes([DOWN]))


def test_the_lower_of_two_sweeps_and_the_largest_of_many_jumps_are_given():
    lines = list(notes([DOWN, UP]))
    assert lines[-1] == ("the peak is that of the sweep down; sweeping up reaches 5 um at 250 Hz")
    alike = Sweep("up", DOWN.peak, ())
    assert list(notes([DOWN, alike])) == []
    jumps = tuple(Jump((200.0 + i, 200.5 + i), (1e-6 * i, 0.0)) for i in range(1, 8))
    (line, _) = notes([Sweep("down", None, jumps)])
    assert line.count("between") == 4
    assert "between 207 and 207.5 Hz" in line
    assert line.endswith("; and 3 smaller jumps")


@pytest.mark.parametrize("direction", ["down", "both"])
def test_where_both_directions_are_taken_anyway_none_is_given(direction: str) -> None:
    with pytest.raises(InputError, match=r"response\.direction"):
        parse_study(f'accuracy = 0.01\n[response]\ndirection = "{direction}"\n')
