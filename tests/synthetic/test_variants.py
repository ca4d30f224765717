"""Variants of the synthetic recording: what each does to the settings, and which are refused."""

import pytest

from pawnb.errors import InputError
from pawnb.synthetic.scene import scene_settings
from pawnb.synthetic.variants import VARIANTS, vary

USUAL = scene_settings(changes={"fps": 240.0})


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("grey", {"grey": True}),
        ("h264-crf28", {"crf": 28}),
        ("h264-crf0", {"crf": 0}),
        ("low-rate", {"fps": 48.0}),
        ("low-rate-3", {"fps": 80.0}),
        ("motion-blur", {"shutter": 0.8}),
        ("covered-lift-off", {"covered_paws": 0.9}),
        ("glass-belt", {"below": True, "n_views": 2}),
        ("reflections", {"reflections": 0.3}),
        ("flicker", {"flicker": 0.2}),
    ],
)
def test_a_variant_changes_what_it_says_and_nothing_else(name, changed):
    done = vary(USUAL, [name])
    assert vars(done) == {**vars(USUAL), **changed}


def test_a_white_mouse_is_paler_than_its_belt_as_no_other_is():
    white = vary(USUAL, ["white-mouse"])
    assert min(white.fur_rgb) > 3 * max(white.belt_rgb)
    assert max(USUAL.fur_rgb) < min(USUAL.belt_rgb)


def test_variants_combine_in_any_order():
    names = ["low-rate", "grey", "h264-crf23", "white-mouse"]
    assert vary(USUAL, names) == vary(USUAL, names[::-1])
    assert vary(USUAL, []) == USUAL


@pytest.mark.parametrize("name", [name for name in VARIANTS if name != "h264-crfNN"])
def test_every_variant_that_is_listed_is_known(name):
    assert vary(USUAL, [name]) != USUAL


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["gray"], "variant 'gray' is unknown (did you mean 'grey'?); known are grey, low-rate,"),
        (["h264-crf60"], "scene setting crf is 60; expected 0 to 51."),
        (["h264-crf23", "h264-crf28"], "h264-crf is there more than once."),
        (["low-rate", "low-rate-2"], "low-rate is there more than once."),
        (["low-rate-0"], "variant 'low-rate-0' is unknown"),
        (["low-rate-40"], "scene setting fps is 6.0; expected 20.0 to 5000.0."),
        (["glass-belt", "reflections"], "a camera below the belt sees no mirror image"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(names, message):
    with pytest.raises(InputError) as caught:
        vary(USUAL, names)
    assert message in str(caught.value)
