"""What stands still in a grey picture, and what that says about paws."""

import cv2
import numpy as np

from pawnb.core.paws.offline.detection.colour.colour_model import learn
from pawnb.core.paws.offline.detection.colour.photometry.background import (
    estimate_background,
    to_grey,
)
from pawnb.core.pixels.grey import has_colour

SIZE = (120, 60)


class Picture:
    """A frame made of an array."""

    def __init__(self, pixels):
        self.pixels = pixels

    def crop(self, u0, v0, u1, v1):
        return self.pixels[v0:v1, u0:u1]


class Clip:
    """A bright square that walks to the right over a bright line that stands."""

    def __init__(self, *, colour=None, saved_as_colour=False):
        self.names, self.n_frames = ["one"], 60
        self.colour, self.saved_as_colour = colour, saved_as_colour
        self.rng = np.random.default_rng(0)

    def picture(self, i):
        image = np.full(SIZE[::-1], 30, np.uint8)
        image[40:44] = 180
        cv2.rectangle(image, (i, 20), (i + 12, 32), 200, -1)
        image = np.clip(image + self.rng.normal(scale=2.0, size=image.shape), 0, 255)
        image = image.astype(np.uint8)
        if self.saved_as_colour or self.colour:
            image = np.stack([image] * 3, axis=-1)
        if self.colour:
            image[:, :, 0] = self.colour
        return image

    def frame(self, i):
        return {"one": Picture(self.picture(i))}


def test_what_walks_is_not_still_and_what_stands_is():
    for saved_as_colour in (False, True):
        clip = Clip(saved_as_colour=saved_as_colour)
        (still,) = estimate_background(clip, [SIZE], {0: clip.picture(0)})
        assert still.shape == SIZE[::-1]
        assert abs(float(np.median(still[20:32])) - 30) < 3
        assert abs(float(np.median(still[40:44])) - 180) < 3
        assert still[20:32].max() < 60


def test_pictures_in_colour_have_no_background():
    assert estimate_background(Clip(colour=90), [SIZE], {0: Clip(colour=90).picture(0)}) == [None]
    assert has_colour(Clip(colour=90).picture(0))
    assert not has_colour(Clip(saved_as_colour=True).picture(0))
    assert to_grey(Clip(saved_as_colour=True).picture(0)).shape == SIZE[::-1]


def test_a_line_as_bright_as_a_paw_is_told_apart_by_standing_still():
    clip = Clip()
    background = estimate_background(clip, [SIZE], {0: clip.picture(0)})
    click = [np.array([[36.0, 26.0]])]
    knows = learn([clip.picture(30)], click, around_px=9, backgrounds=background)
    later = clip.picture(55)
    score = type(knows)(knows.table, knows.paw_width_px, 9, background[0]).score(later)
    assert np.median(score[23:30, 58:65]) > 0
    assert np.median(score[40:44, 10:110]) < 0
    # a part of the view is compared with the same part of the background
    part = type(knows)(knows.table, knows.paw_width_px, 9, background[0]).score(
        later[10:50, 40:100], (40, 10)
    )
    np.testing.assert_allclose(part[10:30, 10:50], score[20:40, 50:90])
