"""A network that follows points, named in a trial: tracks, corrections, checks, the record."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb.core.edits.log import EditLog, Move, Retrack
from pawnb.core.paws.offline.detection.point_tracking.point_tracker import PointTracker
from pawnb.errors import InputError, InputWarning
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.trial import load_trial
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.provenance.record import trial_checksums
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking import point_tracker
from pawnb.workflow.tracking.track import retrack, track

N, SIZE = 60, (200, 120)
POINTS = ("FR", "HR")
FRAMES = (4, 30, 55)
TRIAL = """
[trial]
kind = "paws"
name = "alike"
fps = 100.0
[animal]
id = "a1"
[[views]]
name = "side"
video = "side.avi"
points = ["FR", "HR"]
[start]
points = "start.csv"
[tracking]
evidence = "learnt"
"""
NAMED = 'point_tracker = "net.pt"\n'


def way():
    """Two points that pass each other twice in 16 frames, (N, 2, 2) px."""
    swing = 30 * np.sin(2 * np.pi * np.arange(N) / 16)
    front = np.stack([100 + swing, np.full(N, 66.0)], -1)
    hind = np.stack([100 - swing, np.full(N, 58.0)], -1)
    return np.stack([front, hind], axis=1)


class Knowing:
    """A network that knows the way."""

    def __init__(self):
        self.asked, self.told, self.truth = [], 0, np.empty(0)

    def tell_slow(self):
        self.told += 1

    def see(self, stack):
        """Tell where the points are in the squares of 512 px that are made of pictures."""
        xy = np.einsum("nij,npj->npi", stack.to_body[..., :2], way()) + stack.to_body[:, None, :, 2]
        self.truth = (xy + 0.5) * 512 / np.array(stack.grey.shape[:0:-1])

    def follow(self, pictures, queries):
        self.asked.append(queries[:, 0].astype(int).tolist())
        # the piece in which all queries are where the points are
        for first in range(len(self.truth) - len(pictures) + 1):
            seen = self.truth[first : first + len(pictures)]
            off = np.linalg.norm(seen[queries[:, 0].astype(int)] - queries[:, None, 1:], axis=-1)
            if off.min(axis=1).max() < 1e-6:
                break
        places = seen[:, off.argmin(axis=1)].transpose(1, 0, 2)
        return places, np.full(places.shape[:2], 0.95)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two patches of the same look: what is seen does not tell one from the other."""
    folder = tmp_path_factory.mktemp("alike")
    random = np.random.default_rng(0)

    def noise(width, height, low, high):
        grain = cv2.GaussianBlur(random.normal(size=(height, width)), (0, 0), 1.5)
        return (low + (high - low) * (0.5 + np.clip(grain / grain.std() / 4, -0.5, 0.5))).astype(
            np.uint8
        )

    ground, patch = noise(*SIZE, 60, 110), noise(15, 15, 0, 255)
    with GreyVideoWriter(folder / "side.avi", size=SIZE, fps=100.0) as video:
        for here in way().round().astype(int):
            picture = ground.copy()
            for u, v in here[::-1]:
                picture[v - 7 : v + 8, u - 7 : u + 8] = patch
            video.write(picture)
    rows = [(t, "side", p, *way()[t, i]) for t in FRAMES for i, p in enumerate(POINTS)]
    pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"]).to_csv(
        folder / "start.csv", index=False
    )
    (folder / "net.pt").write_bytes(b"weights")
    (folder / "trial.toml").write_text(TRIAL + NAMED)
    return folder


@pytest.fixture
def network(monkeypatch):
    one, plain = Knowing(), PointTracker.detect

    def detect(tracker, view, stack, annotations, *, points):
        one.see(stack)
        return plain(tracker, view, stack, annotations, points=points)

    monkeypatch.setattr(PointTracker, "detect", detect)
    monkeypatch.setattr(point_tracker, "load_tapir", lambda path: one)
    return one


def quiet(_done, _total):
    """No bar."""


def off(tracks):
    uv = tracks["image_position"].isel(view=0, individual=0)
    uv = uv.transpose("time", "keypoint", "image_space").to_numpy()
    return np.linalg.norm(uv - way(), axis=-1)


@pytest.mark.slow
def test_tracks_are_better_with_it_and_a_correction_asks_for_what_is_new(folder, network):
    trial = load_trial(folder)
    alone = track(dataclasses.replace(trial, point_tracker=None), progress=quiet)
    assert not network.asked
    helped = track(trial, progress=quiet)
    assert network.told == 1
    assert (off(helped) < 8).mean() > (off(alone) < 8).mean() + 0.2
    assert (off(helped) < 8).mean() > 0.9
    step = provenance_steps(helped)[-1]
    assert "net.pt" in step["inputs"]
    assert step["parameters"]["point_tracker"]["side_px"] == 512
    # two pieces, from rows 0 and 36: all clicks, and those of frame 30 and then 55 carried on
    assert network.asked == [[4, 30, 4, 30], [0, 0, 19, 19], [47, 47]]
    log = EditLog(helped, retrack=lambda t, f, **o: retrack(trial, t, f, progress=quiet, **o))
    log.apply(Move(frame=9, view="side", point="FR", u=way()[9, 0, 0], v=way()[9, 0, 1]))
    log.apply(Retrack(frame=9))
    # the correction alone, in the rows between the clicks on either side: 9 - 4
    assert network.asked[3:] == [[5]]
    assert network.told == 1
    assert (off(log.tracks) < 8).mean() > 0.9
    assert off(log.tracks)[9, 0] == 0


def test_the_file_is_one_of_the_trial_and_of_its_checks(folder, network):
    trial = load_trial(folder)
    assert trial.point_tracker == "net.pt"
    assert "net.pt" in trial_checksums(trial)
    report = check_trial(trial)
    assert "point tracker: net.pt" in report.found


@pytest.mark.parametrize("look", [track, check_trial])
def test_what_is_missing_is_said_before_anything_is_tracked(folder, look):
    trial = dataclasses.replace(load_trial(folder), point_tracker="other.pt")
    said = r"point_tracker: there is no file .*other\.pt; expected the weights of BootsTAPIR"
    if look is check_trial:
        assert any("other.pt" in fault for fault in look(trial).faults)
        return
    with pytest.raises(InputError, match=said):
        look(trial)


def clicks(*frames):
    rows = [(frame, "side", "FR", 1.0, 2.0) for frame in frames]
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


@pytest.mark.parametrize(
    ("evidence", "frames", "said"),
    [("colour", (1, 2), "found by colour; --set"), ("learnt", (1,), "one frame: click a second")],
)
def test_tracks_that_were_found_without_it_say_so(folder, evidence, frames, said):
    trial = load_trial(folder)
    with pytest.warns(InputWarning, match=f"was not used, as .*{said}"):
        point_tracker.tell_unused(trial, xr.Dataset(attrs={"evidence": evidence}), clicks(*frames))


@pytest.mark.parametrize(("named", "evidence"), [("net.pt", "learnt"), (None, "colour")])
def test_otherwise_nothing_is_said(folder, recwarn, named, evidence):
    trial = dataclasses.replace(load_trial(folder), point_tracker=named)
    point_tracker.tell_unused(trial, xr.Dataset(attrs={"evidence": evidence}), clicks(1, 2))
    assert not recwarn


def test_another_file_is_another_kind_of_evidence(folder, network):
    """No run goes on from one with other weights."""
    trial = load_trial(folder)
    (one,) = point_tracker.point_trackers(trial)
    (same,) = point_tracker.point_trackers(trial)
    assert one.name == same.name
    assert one.kept is same.kept
    (folder / "other.pt").write_bytes(b"others")
    (other,) = point_tracker.point_trackers(dataclasses.replace(trial, point_tracker="other.pt"))
    assert other.name != one.name
