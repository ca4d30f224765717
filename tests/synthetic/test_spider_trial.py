"""The synthetic spider on disk: what is written, and that the truth is true of the pictures."""

import itertools

import av
import numpy as np
import pandas as pd
import pytest

from pawnb.core.pose.poses import Poses, joint_positions, leg_angles
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError
from pawnb.gait.phases import phase_lags
from pawnb.io.pose import PoseNames, read_pose
from pawnb.schema import EVENTS_COLUMNS, PHASES_COLUMNS, TRACKS_COLUMNS
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

SCALE, FRAMES = 0.3, 110
ANIMAL = load_species("dolomedes")
NAMES = PoseNames(legs=ANIMAL.leg_names, joints=ANIMAL.joints, segments=ANIMAL.segments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A normal run, 384 x 307 px."""
    path = tmp_path_factory.mktemp("spider") / "normal"
    render_spider_trial(path, frames=FRAMES, scale=SCALE, seed=5)
    return path


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Return a function that renders a few frames of another scene."""

    def render(**options):
        path = tmp_path_factory.mktemp("short")
        render_spider_trial(path, **{"frames": 14, "scale": 0.25, "motion": "still", **options})
        return path

    return render


def pictures(folder):
    with av.open(str(folder / "spider.avi")) as container:
        return np.stack([frame.to_ndarray() for frame in container.decode(video=0)])


def truth(folder, name):
    return pd.read_csv(folder / "truth" / f"{name}.csv")


def read_poses(folder, file="truth/pose.csv"):
    table = read_pose(folder / file, names=NAMES)
    return Poses(
        frames=table["frame"].to_numpy(),
        xy=table[["x", "y"]].to_numpy(),
        heading_deg=table["heading"].to_numpy(),
        scale=table["scale"].to_numpy(),
        angles_deg=table[list(NAMES.joints)].to_numpy(),
        lengths_px=table[list(NAMES.lengths)].to_numpy(),
    )


def places(folder, points):
    """Return u, v of points in the frames with the animal, shape (frames, points, 2)."""
    tracks = truth(folder, "tracks").pivot_table(index="frame", columns="point", values=["u", "v"])
    return np.stack([tracks[axis][points].to_numpy() for axis in ("u", "v")], axis=-1)


def test_files_tables_and_trial_are_those_of_the_contract(folder):
    names = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert names == {
        "spider.avi", "start_pose.csv", "trial.toml", "truth/pose.csv", "truth/tracks.csv",
        "truth/events.csv", "truth/phases.csv",
    }  # fmt: skip
    trial = load_trial(folder)
    assert (trial.kind, trial.fps, trial.animal.species) == ("pose", 125.0, "dolomedes")
    # thesis §4.1: 0.557 px are 0.023 cm at half of 1280 x 1024
    assert trial.calibration.px_per_unit == pytest.approx(2 * SCALE * 0.557 / 0.23, rel=0.02)
    assert pictures(folder).shape == (FRAMES, round(1024 * SCALE), round(1280 * SCALE))
    tracks = truth(folder, "tracks")
    assert list(tracks.columns) == [*TRACKS_COLUMNS, "visible"]
    assert len(set(tracks["point"])) == 1 + 8 + 8 * 7
    assert list(truth(folder, "events").columns) == list(EVENTS_COLUMNS)
    assert list(truth(folder, "phases").columns) == list(PHASES_COLUMNS)
    for name in ("pose", "tracks", "events", "phases"):
        assert not truth(folder, name).isna().any().any()


def test_poses_put_the_joints_where_the_tracks_are(folder):
    poses = read_poses(folder)
    found = joint_positions(ANIMAL, poses)
    joints = ("BC", "CT", "TF", "FP", "PT", "TM", "MT")
    for i, leg in enumerate(ANIMAL.leg_names):
        expected = places(folder, [*(f"{leg}.{joint}" for joint in joints), leg])
        np.testing.assert_allclose(found[:, i], expected, atol=1e-6)
    np.testing.assert_allclose(places(folder, ["body"])[:, 0], poses.xy, atol=1e-6)


def test_empty_frames_come_first_and_then_the_animal_walks_in(folder):
    start, end = load_trial(folder).views[0].background_frames
    shots = pictures(folder).astype(float)
    assert start == 0
    assert end >= 8
    arena = shots[:, 80:-80]
    dark = (arena < 0.5 * np.median(arena[:end], axis=0)).sum(axis=(1, 2))
    assert dark[:end].max() == 0
    assert dark[-1] > 200
    pose, first = truth(folder, "pose"), truth(folder, "tracks").groupby("frame")["visible"]
    assert pose["frame"].iloc[0] == end
    # it comes in from one side, part by part
    assert first.sum().iloc[0] < 3
    assert dark[end + 8] < 0.5 * dark[-1]
    begin = pd.read_csv(folder / "start_pose.csv")
    points = places(folder, list(set(truth(folder, "tracks")["point"])))
    whole = ((points > 0) & (points < 1280 * SCALE - 1)).all(axis=(1, 2))
    assert len(begin) == 1
    assert abs(begin["frame"][0] - pose["frame"][np.argmax(whole)]) <= 6  # the body counts too
    assert (FRAMES - begin["frame"][0]) / FRAMES > 0.4
    same = pose[pose["frame"] == begin["frame"][0]].iloc[0]
    for column in ("x", "y", "heading", "scale", "L1_BC", "R4_MT"):
        assert begin[column][0] == pytest.approx(same[column], abs=6e-4)


def test_dark_pixels_lie_under_the_animal_and_only_there(folder):
    shots = pictures(folder).astype(float)
    empty = shots[: load_trial(folder).views[0].background_frames[1]].mean(axis=0)
    poses = read_poses(folder)
    joints = joint_positions(ANIMAL, poses)
    rows = slice(82, 225)  # between the walls
    for k in range(40, len(poses), 12):
        share = shots[poses.frames[k]] / np.maximum(empty, 1.0)
        for leg in joints[k]:
            inner = 0.5 * (leg[2:6] + leg[3:7])  # middles of femur to metatarsus
            assert (
                np.median(share[inner[:, 1].round().astype(int), inner[:, 0].round().astype(int)])
                < 0.5
            )
        a, b = joints[k, :, :-1].reshape(-1, 2), joints[k, :, 1:].reshape(-1, 2)
        at = np.argwhere(share[rows] < 0.6)[:, ::-1] + (0, rows.start)
        along = np.clip(((at[:, None] - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0, 1)
        from_legs = np.linalg.norm(at[:, None] - a - along[..., None] * (b - a), axis=-1).min(1)
        turn = np.radians(poses.heading_deg[k])
        ahead = (at - poses.xy[k]) @ np.array([np.cos(turn), np.sin(turn)]) / poses.scale[k]
        aside = (at - poses.xy[k]) @ np.array([-np.sin(turn), np.cos(turn)]) / poses.scale[k]
        on_body = (np.abs(ahead) < 19.0) & (np.abs(aside) < 7.5)  # with palps and spinnerets
        assert len(at) > 150
        stray = ~on_body & (from_legs > 1.6 * poses.scale[k] + 0.7)
        assert stray.mean() < 0.01


def test_legs_are_painted_without_bias(short):
    """The middle of a leg's picture is its stick, to a twentieth of a pixel."""
    folder = short(difficulty="easy", frames=30, scale=0.5, seed=3)
    shots = pictures(folder).astype(float)
    ink = 1.0 - shots[10:].mean(axis=0) / shots[:10].mean(axis=0)
    joints = joint_positions(ANIMAL, read_poses(folder).take(slice(0, 1)))[0]
    offsets = []
    for leg in joints:
        a, b = leg[4], leg[5]  # the tibia
        normal = np.array([-(b - a)[1], (b - a)[0]]) / np.hypot(*(b - a))
        k = np.arange(-5.0, 5.01, 0.25)
        for share in (0.3, 0.5, 0.7):
            u, v = (a + share * (b - a) + k[:, None] * normal).T
            u0, v0 = np.floor(u).astype(int), np.floor(v).astype(int)
            du, dv = u - u0, v - v0
            value = ((1 - du) * (1 - dv) * ink[v0, u0] + du * (1 - dv) * ink[v0, u0 + 1]
                     + (1 - du) * dv * ink[v0 + 1, u0] + du * dv * ink[v0 + 1, u0 + 1])  # fmt: skip
            if max(abs(value[0]), abs(value[-1])) < 0.06:  # no neighbour in the section
                offsets.append((value * k).sum() / value.sum() * normal)
    assert len(offsets) > 15
    assert np.abs(np.mean(offsets, axis=0)).max() < 0.05


def test_events_are_extremes_of_the_leg_angles_of_the_poses(folder):
    poses, events = read_poses(folder), truth(folder, "events")
    angles = leg_angles(ANIMAL, poses)
    assert len(events) > 40
    for leg, own in events.groupby("leg"):
        series = angles[:, ANIMAL.leg_names.index(leg)]
        kinds = own.sort_values("frame")["event"].tolist()
        assert all(a != b for a, b in itertools.pairwise(kinds))
        for event in own.itertuples():
            near = int(np.argmin(np.abs(poses.frames - event.frame)))
            if not 3 <= near < len(series) - 3:
                continue
            # a parabola through the three frames about the extreme
            sign = 1 if event.event == "AEP" else -1
            top = near - 2 + int(np.argmax(sign * series[near - 2 : near + 3]))
            before, middle, after = series[top - 1 : top + 2]
            at = poses.frames[top] + 0.5 * (before - after) / (before - 2 * middle + after)
            assert abs(at - event.frame) < 0.35
    np.testing.assert_allclose(events["time_s"], events["frame"] / 125.0)
    first = pd.read_csv(folder / "start_pose.csv")["frame"][0]
    assert events["frame"].between(first, FRAMES - 1).all()


def test_phases_follow_from_the_events(folder):
    aep = truth(folder, "events").query("event == 'AEP'")
    times = {leg: own["time_s"].to_numpy() for leg, own in aep.groupby("leg")}
    phases = truth(folder, "phases")
    assert len(phases.groupby(["leg", "reference"])) == 16  # §4.2.4's pairs
    for (leg, reference), own in phases.groupby(["leg", "reference"]):
        base = times[reference]
        stride, expected = phase_lags(times[leg], np.column_stack([base[:-1], base[1:]]))
        np.testing.assert_array_equal(own["stride"], stride)
        np.testing.assert_allclose(own["phase"], expected, atol=1e-9)


def test_the_same_arguments_give_the_same_recording(short):
    a, b, other = short(seed=1), short(seed=1), short(seed=2)
    for name in ("spider.avi", "truth/pose.csv", "start_pose.csv", "trial.toml"):
        assert (a / name).read_bytes() == (b / name).read_bytes()
    assert (a / "spider.avi").read_bytes() != (other / "spider.avi").read_bytes()


def test_a_still_animal_is_still(short):
    folder = short(motion="still")
    pose = truth(folder, "pose")
    assert pose["frame"].tolist() == list(range(10, 14))
    assert np.ptp(pose.drop(columns="frame").to_numpy(), axis=0).max() == 0
    assert truth(folder, "events").empty
    assert truth(folder, "phases").empty


def test_a_drifting_animal_moves_a_tenth_of_a_pixel_a_frame(short):
    folder = short(motion="drift", frames=50, difficulty="easy")
    pose = truth(folder, "pose")
    steps = np.diff(pose[["x", "y"]].to_numpy(), axis=0)
    np.testing.assert_allclose(np.hypot(*steps.T), 0.1)
    assert np.ptp(pose[[*NAMES.joints, "heading"]].to_numpy(), axis=0).max() == 0
    # and so does its picture: the centroid of what it darkens
    shots = pictures(folder).astype(float)
    empty = shots[:10].mean(axis=0)
    ink = np.where(shots[10:] < 0.7 * empty, empty - shots[10:], 0.0)
    ink[:, :70] = ink[:, -70:] = 0.0  # dark rows beside the panel
    v, u = np.mgrid[: ink.shape[1], : ink.shape[2]]
    centroid = (
        np.stack([(ink * u).sum((1, 2)), (ink * v).sum((1, 2))], 1) / ink.sum((1, 2))[:, None]
    )
    slope = np.polyfit(pose["frame"], centroid, 1)[0]
    np.testing.assert_allclose(slope, steps[0], atol=0.01)


def test_difficulty_is_noise_shade_and_pale_tips(short):
    shots, tips = {}, {}
    for name in ("easy", "normal", "hard"):
        folder = short(difficulty=name, frames=20, scale=0.5, seed=8)
        shots[name] = pictures(folder).astype(float)
        share = shots[name][10:].mean(axis=0) / shots[name][:10].mean(axis=0)
        u, v = (
            joint_positions(ANIMAL, read_poses(folder))[0, :, 6:8]
            .mean(axis=1)
            .round()
            .astype(int)
            .T
        )
        tips[name] = np.median(share[v, u])  # in the middle of the tarsi
    assert tips["easy"] < tips["normal"] < tips["hard"] < 0.9
    assert tips["normal"] - tips["easy"] > 0.05
    assert tips["hard"] - tips["normal"] > 0.08
    noise = {name: shot[:10].std(axis=0).mean() for name, shot in shots.items()}
    assert noise["easy"] < noise["normal"] < noise["hard"]
    middle, corner = (slice(240, 270), slice(300, 340)), (slice(150, 170), slice(0, 30))
    fall = {name: shot[0][corner].mean() / shot[0][middle].mean() for name, shot in shots.items()}
    assert fall["easy"] > fall["normal"]  # vignetting


def test_a_shadow_drifts_over_the_hard_panel(short):
    folder = short(difficulty="hard", frames=80, seed=1)
    shots = pictures(folder)[:, 90:110].astype(float)  # rows of the panel that feet do not reach
    columns = shots.mean(axis=1)
    change = np.ptp(columns.reshape(80, -1, 32).mean(axis=2) / columns.mean(), axis=0)
    assert change.max() > 0.1
    calm = pictures(short(difficulty="normal", frames=80, seed=1))[:, 90:110].mean(axis=1)
    assert np.ptp(calm.reshape(80, -1, 32).mean(axis=2) / calm.mean(), axis=0).max() < 0.05


def test_walls_reflect_the_animal(short):
    """Beyond the nearer wall the picture darkens where the mirror image of a foot must be."""
    folder = short(difficulty="hard", frames=60, scale=0.5, seed=2)
    shots = pictures(folder).astype(float)
    poses = read_poses(folder)
    middle = (1024 * 0.5 - 1) / 2
    side = np.sign(poses.xy[0, 1] - middle)
    wall = middle + side * 50.0 * 2.42  # the arena is 10 cm wide
    joints = joint_positions(ANIMAL, poses.take(slice(0, 1)))[0]
    legs = joints[[i for i, leg in enumerate(joints) if (leg[-1, 1] - poses.xy[0, 1]) * side > 0]]
    near = legs[np.argmin(np.abs(wall - legs[:, -1, 1]))]
    u, v = near[5]  # where the metatarsus begins
    empty, full = shots[:10].mean(axis=0), shots[10:].mean(axis=0)
    share = full / empty
    row, column = round(2 * wall - v), round(u)
    seen = share[row - 1 : row + 2, column - 1 : column + 2].mean()
    away = np.median(share[row - 1 : row + 2])  # the same rows, far from the image
    assert seen < away - 0.03


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"difficulty": "hart"}, "difficulty is 'hart' (did you mean 'hard'?); expected"),
        ({"motion": "walk"}, "motion is 'walk'; expected run, still, drift"),
        ({"scale": 0.01}, "scale is 0.01; expected 0.1 to 2"),
        ({"seed": -1}, "seed is -1"),
        ({"frames": 1}, "frames is 1; expected 2 or more"),
        ({"frames": 20, "motion": "run"}, "in 20 frames the animal is never wholly in view"),
    ],
)
def test_bad_input_is_refused_before_anything_is_written(tmp_path, options, sentence):
    with pytest.raises(InputError) as caught:
        render_spider_trial(tmp_path / "new", **options)
    assert sentence in str(caught.value)
    assert not (tmp_path / "new").exists()


def test_a_rendering_that_is_broken_off_leaves_no_half_video(tmp_path):
    def stop(done, _total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_spider_trial(tmp_path, frames=16, scale=0.1, motion="still", progress=stop)
    assert [path.name for path in tmp_path.iterdir()] == ["truth"]
