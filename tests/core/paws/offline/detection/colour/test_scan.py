"""The part of a view that is searched."""

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour import scan
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig
from pawnb.core.paws.offline.detection.colour.scan import ROI


def _follow(frames: int, paws: np.ndarray, clutter: np.ndarray) -> ROI:
    """Return a region after paws (frames, 4) moved and poor clutter (frames, 12) was there too."""
    roi = ROI(np.array([600.0, 200.0]), np.array([200.0, 50.0]), (1200, 400))
    for t in range(frames):
        u = np.concatenate([paws[t], clutter[t]])
        roi.follow(u, np.repeat([0.95, 0.03], [4, 12]))
    return roi


def test_the_searched_region_follows_paws_not_what_little_looks_like_them():
    frames = 200
    ahead = np.linspace(0.0, 200.0, frames)[:, None]
    paws = np.array([520.0, 560.0, 660.0, 680.0]) + ahead
    # an edge of the belt comes into the picture behind the animal, as the animal leaves it
    clutter = np.full((frames, 12), 620.0)
    clutter[60:] = 350.0
    roi = _follow(frames, paws, clutter)
    # the region lags behind by 1 / FOLLOW frames, 17 px, and clutter has a tenth of the weight
    assert roi.centre[0] == pytest.approx(800.0 - 17.0, abs=0.1 * (800.0 - 350.0))
    left, _, right, _ = roi.box()
    assert left < paws[-1].min()
    assert paws[-1].max() < right


def test_the_searched_region_stays_where_the_animal_stays():
    frames = 100
    paws = np.tile([520.0, 560.0, 660.0, 680.0], (frames, 1))
    roi = _follow(frames, paws, np.linspace(700.0, 900.0, frames)[:, None] + np.zeros(12))
    assert roi.centre[0] == pytest.approx(600.0, abs=20.0)


PLACES = np.array([-80.0, -40.0, 60.0, 90.0])
"""Paws from the middle of the animal, px."""


class Passing:
    """Views of an animal that goes 0.6 px a frame to the right; a frame is where its paws are."""

    names = ("side",)

    def __init__(self):
        self.asked = []

    def frames(self, start, stop, *, step=1, partly=False):
        for t in range(start, stop, step):
            self.asked.append(t)
            yield t, {"side": 300.0 + 0.6 * t + PLACES}


@pytest.fixture
def search(monkeypatch):
    """Search the passing animal: paws are found where they are within the region."""

    def found(paws, box, _look):
        u = paws[(paws >= box[0]) & (paws < box[2])]
        n, left = len(u), np.full(len(u), box[0])  # what was searched shows, too
        return ColourDetections.of(
            np.column_stack([u, np.zeros(n)]), direction=np.tile([2.0, 1.0], (n, 1)),
            coverage=np.full(n, 0.22), score=np.ones(n), tip=np.column_stack([left, np.zeros(n)]),
        )  # fmt: skip

    monkeypatch.setattr(scan, "searched", lambda paws, roi, _shrink: (paws, roi.box()))
    monkeypatch.setattr(scan, "detect", found)

    def search(frames, home, **options):
        middle = np.array([300.0 + 0.6 * home, 200.0])
        roi = ROI(middle, np.array([150.0, 50.0]), (1200, 400))
        detectors = [DetectorConfig(None, 1, 3, (0.9, 0.4))]
        views = options.pop("views", Passing())
        return scan.scan_video(views, frames, home=home, detectors=detectors, rois=[roi], **options)

    return search


def test_an_animal_that_was_elsewhere_before_the_clicks_is_found_there(search):
    """In frame 0 it is 120 px from where it was clicked, with paws up to 90 px from its middle."""
    found = search((0, 300), 200)
    assert [len(here[0]) for here in found] == [4] * 300
    # what follows the clicks is what would be found without the frames before
    for both, alone in zip(found[200:], search((200, 300), 200), strict=True):
        np.testing.assert_array_equal(both[0].table, alone[0].table)


def test_an_interrupted_search_goes_on_before_the_clicks_and_after(search):
    whole = search((0, 120), 80)
    for done in (30, 100):
        store = DetectionCache()
        reported = []
        part = search(
            (0, 120), 80, store=store, progress=reported.append,
            stop=lambda n=done, reported=reported: len(reported) >= n,
        )  # fmt: skip
        assert done <= len(part) < 120
        views = Passing()
        again = search((0, 120), 80, store=store, views=views)
        assert all(
            np.array_equal(a[0].table, b[0].table) for a, b in zip(again, whole, strict=True)
        )
        assert len(views.asked) == 120 - len(part) + (11 if done < 80 else 0)


def test_the_way_back_can_be_stopped(search):
    assert search((0, 120), 80, stop=lambda: True) == []
