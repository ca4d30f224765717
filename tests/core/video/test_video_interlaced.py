"""Films that are woven of two pictures each and do not say so."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.core.video import open_view
from pawnb.core.video.doubts.interlaced import looks_interlaced
from pawnb.trial import View


def fields(n):
    """Grey pictures of a rough disc that goes to the right by 6 px a picture."""
    rng = np.random.default_rng(0)
    v, u = np.mgrid[:120, :240]
    ground = cv2.GaussianBlur(rng.uniform(0, 255, (120, 240)), (0, 0), 3)
    coat = 90 + 6 * (cv2.GaussianBlur(rng.uniform(0, 255, (120, 480)), (0, 0), 2) - 127)
    for k in range(n):
        disc = (u - 40 - 6 * k) ** 2 + (v - 60) ** 2 < 30**2
        shown = np.where(disc, coat[:, 240 - 6 * k : 480 - 6 * k], ground)
        yield np.clip(shown + rng.normal(0, 2, shown.shape), 0, 255).astype(np.uint8)


def woven(n):
    both = list(fields(2 * n))
    for first, second in zip(both[::2], both[1::2], strict=True):
        picture = first.copy()
        picture[1::2] = second[1::2]
        yield picture


@pytest.mark.parametrize(("make", "is_woven"), [(fields, False), (woven, True)])
def test_pictures_that_are_woven_of_two_look_interlaced(tmp_path, make, is_woven):
    for k, picture in enumerate(make(12)):
        cv2.imwrite(str(tmp_path / f"{k:03d}.png"), picture)
    with open_view(View(name="v", video="."), tmp_path) as view:
        assert looks_interlaced(view, start=0, stop=12) == is_woven
        assert not looks_interlaced(view, start=3, stop=4)


def test_what_does_not_move_does_not_look_interlaced(tmp_path):
    picture = next(woven(1))
    for k in range(6):
        cv2.imwrite(str(tmp_path / f"{k:03d}.png"), picture)
    with open_view(View(name="v", video="."), tmp_path) as view:
        assert not looks_interlaced(view, start=0, stop=6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("clip", "file"), [("horse_walk", "side.mp4"), ("dog_indoors", "side.avi")]
)
def test_real_clips(real_data, tmp_path, clip, file):
    """Both are progressive; woven of two pictures each they are not."""
    folder = real_data("real-clips") / clip
    with open_view(View(name="v", video=file), folder) as view:
        n = view.n_frames // 2 * 2
        assert not looks_interlaced(view, start=0, stop=n)
        for k in range(0, n, 2):
            picture = view.read(k)
            picture[1::2] = view.read(k + 1)[1::2]
            cv2.imwrite(str(tmp_path / f"{k // 2:03d}.jpg"), picture[..., ::-1])
    with open_view(View(name="v", video="."), tmp_path) as view:
        assert looks_interlaced(view, start=0, stop=view.n_frames)
