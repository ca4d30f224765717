"""Offsets of films from the frame in which each shows one flash."""

import pytest

from pawnb.errors import InputError
from pawnb.workflow.workbench.film_alignment import offsets_by_event, tell_alignment


def test_frame_0_is_the_first_that_all_films_have():
    assert offsets_by_event(["a", "b", "c"], [30, 25, 18]) == [12, 7, 0]
    assert offsets_by_event(["a", "b"], [None, None]) == [0, 0]


def test_of_a_jointed_animal_frames_are_those_of_the_first_film():
    assert offsets_by_event(["top", "side"], [30, 25], from_first=True) == [0, -5]


def test_a_film_without_the_flash_is_named():
    with pytest.raises(InputError, match="not marked in b, c yet: go to the frame in which b "):
        offsets_by_event(["a", "b", "c"], [0, None, None])


def test_films_of_different_lengths_are_said_until_they_are_aligned():
    assert tell_alignment({"a": 0, "b": 0}, {"a": 9, "b": 9}) == ""
    assert "(frames: a 9, b 7)" in tell_alignment({"a": 0, "b": 0}, {"a": 9, "b": 7})
    assert "frame 2 of a, frame 0 of b" in tell_alignment({"a": 2, "b": 0}, {"a": 9, "b": 7})
