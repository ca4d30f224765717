"""Contact where a stride has few samples: feet that stop dead, and real ones seen less often."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import analyse
from pawnb.gait.events.foot_speed import sharpen_speed
from pawnb.schema import make_tracks
from pawnb.signals import differentiate

LEGS = ("FR", "HR", "FL", "HL")


def sharpened(place, *, per_stride):
    """Speed of a foot sampled once a second, in strides of so many seconds."""
    velocity = differentiate(place, dt=1.0)
    return sharpen_speed(
        velocity, velocity=velocity, displacement=place, height=None, fs_hz=1.0,
        stride_hz=1.0 / per_stride,
    )  # fmt: skip


def test_the_speed_of_a_smooth_movement_is_told_between_its_samples():
    # the derivative of sin(t / 2) is cos(t / 2) / 2
    place = np.sin(np.arange(60) / 2.0)
    found = sharpened(place, per_stride=12.0)
    times = np.arange(len(found.speed)) / found.finer
    inside = (times > 5) & (times < 54)
    exact = np.cos(times / 2.0) / 2.0
    np.testing.assert_allclose(found.speed[inside], exact[inside], atol=0.01)
    # central differences of the samples are sin(1/2) / (1/2) of that: 4 % too small
    assert np.abs(differentiate(place, dt=1.0)[6:54] - exact[48:432:8]).max() > 0.018


def test_enough_samples_in_a_stride_are_left_as_they_are():
    place = np.sin(np.arange(100) / 5.0)
    found = sharpened(place, per_stride=31.4)
    np.testing.assert_array_equal(found.speed, differentiate(place, dt=1.0))
    assert (found.finer, found.spread) == (1, 2.0)


def test_what_is_missing_stays_missing_and_ends_keep_their_speed():
    place = np.arange(40.0)
    place[20:25] = np.nan
    place[27:30] = np.nan  # two samples are no curve
    found = sharpened(place, per_stride=8.0)
    times = np.arange(len(found.speed)) / found.finer
    away = ((times > 19) & (times < 25)) | ((times > 26) & (times < 30))
    assert not np.isfinite(found.speed[away]).any()
    np.testing.assert_allclose(found.speed[(times <= 19) | (times >= 30)], 1.0)


def tracks_of(table, every, fps):
    """Tracks of every nth frame of a real mouse."""
    taken = table.iloc[::every]
    tracks = make_tracks(
        np.arange(len(taken)), list(LEGS), fps=fps / every, unit="px", space=("x", "y")
    )
    for k, leg in enumerate(LEGS):
        tracks["position"].data[:, :, k, 0] = taken[[f"{leg}_x", f"{leg}_y_bottom"]]
    tracks["confidence"].data[:] = 1.0
    return tracks


@pytest.mark.slow
@pytest.mark.parametrize(("every", "most"), [(8, 0.025), (12, 0.035)])
def test_contact_of_a_real_mouse_hardly_depends_on_the_frame_rate(real_data, every, most):
    # 400 frames a second, 163 in a stride, tell the contact; of every 8th (20 in a stride) 0.035 of
    # a stride was lost, of every 12th (14 in a stride) 0.07
    table = pd.read_csv(real_data("mouse-locomouse") / "tracks.csv")
    whole, some = (analyse(tracks_of(table, n, 400.0)).strides for n in (1, every))
    lost = []
    for stride in whole.itertuples():
        same = some[
            (some["leg"] == stride.leg)
            & ((some["start_s"] - stride.start_s).abs() < 0.2 * stride.period_s)
        ]
        lost += (stride.contact_duty_factor - same["contact_duty_factor"]).tolist()
    assert np.isfinite(lost).sum() >= 20
    assert abs(np.nanmedian(lost)) < most
