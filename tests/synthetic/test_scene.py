"""Settings of a synthetic scene: presets, and sentences for what makes no sense."""

import dataclasses

import pytest

from pawnb.errors import InputError
from pawnb.synthetic.scene import SceneSettings, scene_settings


def test_presets_grow_harder():
    easy, normal, hard = (scene_settings(d) for d in ("easy", "normal", "hard"))
    for name in ("period_sd", "phase_jitter", "drift_mm", "read_noise", "blur_px", "belt_marks"):
        values = [getattr(s, name) for s in (easy, normal, hard)]
        assert values == sorted(set(values)), name
    red_over_green = [s.paw_rgb[0] - s.paw_rgb[1] for s in (easy, normal, hard)]
    assert red_over_green == sorted(red_over_green, reverse=True)
    assert normal == SceneSettings()


def test_sizes_are_rounded():
    assert (scene_settings(changes={"scale": 0.2}).width, 140) == (410, 140)
    assert scene_settings(changes={"scale": 1}).width == 2048
    assert scene_settings(changes={"scale": 0.33}).height == 231


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene_settings().seed = 3


@pytest.mark.parametrize(
    ("difficulty", "changes", "message"),
    [
        ("hrad", {}, "difficulty is 'hrad' (did you mean 'hard'?); expected easy, normal, hard."),
        ("easy", {"scale": 4.0}, "scene setting scale is 4.0; expected 0.05 to 2.0."),
        ("easy", {"n_views": 5}, "scene setting n_views is 5; expected 2 to 4."),
        ("easy", {"direction": 0}, "scene settings: direction is 0; expected one of 1, -1."),
        (
            "easy",
            {"paw_rgb": [300, 0, 0]},
            "scene setting paw_rgb is (300.0, 0.0, 0.0); expected red, green and blue, "
            "each from 0 to 255.",
        ),
    ],
)
def test_bad_settings_are_refused_in_a_sentence(difficulty, changes, message):
    with pytest.raises(InputError) as caught:
        scene_settings(difficulty, changes=changes)
    assert str(caught.value) == message


def test_an_unknown_setting_is_named_with_the_nearest():
    with pytest.raises(InputError, match=r"unknown name 'belt_spead_mm_s'.*'belt_speed_mm_s'"):
        scene_settings(changes={"belt_spead_mm_s": 200})
